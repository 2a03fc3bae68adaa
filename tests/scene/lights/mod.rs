//! Lights: strength, densities of samples, choice among many lights, and extreme input.

mod density;
mod facing;
mod glossy;
mod lanes;
mod many;
mod nasty;
mod strength;
use crate::support::{Random, folder, write, write_picture};
use glam::Vec3;
use petzval_base::lanes::f32x8;
use petzval_base::rays::{Hit, Ray};
use petzval_image::Picture;
use petzval_scene::{LightSample, Scene, SurfacePoint, TraversalStack};
use petzval_scene_formats::pbrt;
use petzval_scene_formats::pbrt::SceneErrors;

/// Reads the world of a scene file that refers to these pictures.
fn read(pictures: &[(&str, &Picture)], world: &str) -> Result<Scene, SceneErrors> {
    let folder = folder();
    for (name, picture) in pictures {
        write_picture(picture, folder.path().join(name));
    }
    let text = format!("Camera \"perspective\"\nWorldBegin\n{world}");
    pbrt::read(&write(&folder, "test.pbrt", text)).map(|description| description.scene)
}

fn scene(world: &str) -> Scene {
    read(&[], world).expect("a scene of a test")
}

/// A point of a surface without position error.
fn at(position: [f32; 3], normal: [f32; 3]) -> SurfacePoint {
    let normal = Vec3::from(normal).normalize();
    SurfacePoint { position: position.into(), error: Vec3::ZERO, normal, shading_normal: normal }
}

fn sample(scene: &Scene, from: &SurfacePoint, random: &mut Random) -> Option<LightSample> {
    let mut pair = || [random.next() as f32, random.next() as f32].map(|u| u.min(0.999_999_94));
    scene.sample_light(from, Vec3::ZERO, pair(), pair())
}

fn closest(scene: &Scene, from: Vec3, direction: Vec3) -> (Ray, Hit) {
    let (origin, direction) = (from.to_array(), direction.to_array());
    let ray = Ray { origin, direction, t_max: f32::INFINITY };
    (ray, scene.closest::<f32x8>(&ray, &mut TraversalStack::default()))
}

/// A mean of samples and its standard error.
#[derive(Clone, Copy, Debug)]
struct Mean {
    mean: f64,
    error: f64,
}

impl Mean {
    /// The mean of a function of a point's light samples, over their density.
    fn of(scene: &Scene, from: &SurfacePoint, count: u32, f: impl Fn(&LightSample) -> f64) -> Self {
        let mut random = Random::new(7);
        let (mut sum, mut squares) = (0.0, 0.0);
        for _ in 0..count {
            let Some(sample) = sample(scene, from, &mut random) else { continue };
            let value = f(&sample) / f64::from(sample.density);
            assert!(value.is_finite(), "{sample:?}");
            sum += value;
            squares += value * value;
        }
        let n = f64::from(count);
        let mean = sum / n;
        Self { mean, error: ((squares / n - mean * mean).max(0.0) / n).sqrt() }
    }

    /// The unoccluded irradiance at a point.
    fn irradiance(scene: &Scene, from: &SurfacePoint, count: u32) -> Self {
        Self::of(scene, from, count, |sample| {
            let cos = from.normal.dot(sample.direction.normalize()).max(0.0);
            f64::from(sample.radiance[0] * cos)
        })
    }

    /// Checks the mean within 6 standard errors, which are small enough to detect an error of 0.3
    /// %.
    #[track_caller]
    fn assert_is(self, expected: f64) {
        assert!(self.error < 0.0015 * expected, "too noisy: {self:?}");
        let away = (self.mean - expected).abs();
        let allowed = (6.0 * self.error + 2e-4 * expected).min(0.003 * expected);
        assert!(away < allowed, "{self:?} instead of {expected}");
    }
}

/// A picture of random pixels, a fifth of them black and one very bright.
fn patchwork(size: [usize; 2]) -> Picture {
    let mut random = Random::new(3);
    let mut pixels: Vec<[f32; 3]> = (0..size[0] * size[1])
        .map(|i| match i % 5 {
            0 => [0.0; 3],
            _ => [random.next() as f32, random.next() as f32, 0.5],
        })
        .collect();
    pixels[size[0] * size[1] / 3] = [60.0, 50.0, 40.0];
    Picture { size, pixels }
}
