//! Surfaces that receive light from one side, and skies of which only a part is sampled.

use std::f64::consts::PI;

use glam::Vec3;
use petzval_render::Backend;
use petzval_render::prepare::{Changes, prepare};
use petzval_scene::Reception;
use petzval_scene_formats::pbrt;

use super::{Mean, at, closest, patchwork, read, scene};
use crate::support::Random;

/// Returns a scene of many small lights above and below a floor.
pub fn small_lights() -> petzval_scene::Scene {
    let mut random = Random::new(5);
    let mut world = String::from("AreaLightSource \"diffuse\" \"bool twosided\" true\n");
    for i in 0..60 {
        let [x, y, z] = [0; 3].map(|_| random.between(-4.0, 4.0));
        let shape = ["sphere", "disk"][i % 2];
        world += &format!(
            "AttributeBegin Translate {x} {y} {z} Rotate {} 1 {x} {y} \
             Shape \"{shape}\" \"float radius\" 0.1 AttributeEnd\n",
            7 * i
        );
    }
    scene(&world)
}

/// The irradiance at a point, with lights chosen for a receiver of this side.
fn irradiance(scene: &petzval_scene::Scene, facing: Vec3) -> Mean {
    let from = at([0.3, 0.2, 0.1], [0.2, 0.1, 1.0]);
    let mut random = Random::new(6);
    let (n, mut sum, mut squares) = (400_000, 0.0, 0.0);
    for _ in 0..n {
        let mut pair = || [random.next() as f32, random.next() as f32].map(|u| u.min(0.999_999_94));
        let (choice, u) = (pair(), pair());
        let Some(sample) = scene.sample_light(&from, facing, choice, u) else { continue };
        let cos = from.normal.dot(sample.direction.normalize()).max(0.0);
        let value = f64::from(cos * sample.radiance[0] / sample.density);
        sum += value;
        squares += value * value;
    }
    let n = f64::from(n);
    let mean = sum / n;
    Mean { mean, error: ((squares / n - mean * mean) / n).sqrt() }
}

#[test]
fn a_receiver_of_one_side_gets_the_same_light_with_less_noise() {
    let scene = small_lights();
    let normal = Vec3::new(0.2, 0.1, 1.0).normalize();
    let (both, one) = (irradiance(&scene, Vec3::ZERO), irradiance(&scene, normal));
    let apart = (both.mean - one.mean).abs();
    assert!(apart < 6.0 * both.error.hypot(one.error), "{both:?} {one:?}");
    assert!(one.error < 0.7 * both.error, "{both:?} {one:?}");
}

#[test]
fn the_density_of_a_hit_knows_the_side_of_the_receiver() {
    check_densities(|normal| normal.into());
}

/// Checks that the density of a hit is that with which the light was sampled, for a receiver of this
/// normal.
pub fn check_densities(reception: impl Fn(Vec3) -> Reception) {
    let scene = small_lights();
    let from = at([0.3, 0.2, 0.1], [0.2, 0.1, 1.0]);
    let reception = reception(from.normal);
    let mut random = Random::new(9);
    let mut compared = 0;
    for _ in 0..20_000 {
        let mut pair = || [random.next() as f32, random.next() as f32].map(|u| u.min(0.999_999_94));
        let (choice, u) = (pair(), pair());
        let Some(sample) = scene.sample_light(&from, reception, choice, u) else { continue };
        let direction = sample.direction.normalize();
        let (ray, hit) = closest(&scene, from.position, direction);
        if hit.shape == petzval_base::rays::NO_INDEX {
            continue;
        }
        let (_, point) = scene.surface(&ray, &hit);
        if point.position.distance(from.position + sample.direction) > 1e-3 {
            continue;
        }
        let density = scene.area_light_density(from.position, reception, &hit, &point, direction);
        let grazing = 1e-4 / point.normal.dot(direction).powi(2);
        let off = (density / sample.density - 1.0).abs();
        assert!(off < 1e-3 + grazing, "{density}, not {}", sample.density);
        compared += 1;
    }
    assert!(compared > 10_000, "{compared}");
}

#[test]
fn a_floor_under_a_picture_of_the_sky_has_the_brightness_of_its_irradiance() {
    // Directions darker than the mean are found by BSDF sampling alone: pictures must not lose
    // them, nor count those above it twice.
    let (folder, sky) = (crate::support::folder(), patchwork([16, 16]));
    crate::support::write_picture(&sky, folder.path().join("sky.exr"));
    let light = "LightSource \"infinite\" \"string filename\" \"sky.exr\"";
    let scene = read(&[("sky.exr", &sky)], light).expect("a scene");
    let expected = Mean::irradiance(&scene, &at([0.0; 3], [0.0, 0.0, 1.0]), 4_000_000);
    for (integrator, depth) in [("directlighting", 5), ("path", 3)] {
        let text = format!(
            "Film \"rgb\" \"integer xresolution\" 32 \"integer yresolution\" 32
             Integrator \"{integrator}\" \"integer maxdepth\" {depth}
             LookAt 0 0 1  0 0 0  0 1 0 Camera \"perspective\" \"float fov\" 1
             WorldBegin {light} Material \"diffuse\" \"rgb reflectance\" [0.5 0.5 0.5]
             Shape \"trianglemesh\" \"point3 P\" [-9 -9 0  9 -9 0  9 9 0  -9 9 0]
             \"integer indices\" [0 1 2 2 3 0]"
        );
        let description =
            pbrt::read(&crate::support::write(&folder, "floor.pbrt", text)).expect("a scene");
        let changes = Changes { samples: Some(2048), ..Changes::default() };
        let job = prepare(description, &changes).expect("a job").job;
        let found = crate::support::mean(&crate::support::picture(&job, Backend::Simd, 1))[0];
        let expected = 0.5 * expected.mean / PI;
        assert!((found / expected - 1.0).abs() < 0.004, "{integrator}: {found}, not {expected}");
    }
}
