//! View of a camera, by a few thousand rays: where they enter the lens, and which lights they hit.

use glam::Vec3;

use super::{CameraPose, LightPathInput};
use crate::advance::PathColumns;
use petzval_base::lanes::f32x8;
use petzval_base::rays::{SampleBatch, WAVE_SIZE};
use petzval_base::sampler::{Dimension, pixel_key, sample_2d};
use petzval_base::stats::LensStats;
use petzval_lens::{Camera, LensColumns, LensModel};
use petzval_scene::{Surroundings, luminance};

/// Waves of camera rays.
const CAMERA_WAVES: u32 = 4;
/// Largest distance from the axis, in radii of the front element, at which light paths cross the
/// plane of the front vertex. Rays far off the axis of a fisheye cross it anywhere, or nowhere.
const MAX_ENTRY: f64 = 2.0;
/// Margin of the square of entry points about the camera rays.
const MARGIN: f64 = 1.05;

/// Rays of a whole picture, and the lights that they hit.
pub(crate) struct CameraView {
    /// Half side of a square about the front vertex that holds all of them (mm), except those that
    /// cross its plane far beside the lens.
    pub half: f64,
    /// Value of a pixel that sees radiance 1.
    pub exposure: f64,
    /// Number of hits, by light.
    hits: Vec<u32>,
    rays: u32,
}

impl CameraView {
    /// Traces the rays; `None` if none leaves the lens.
    pub fn new(input: &LightPathInput<'_>) -> Option<Self> {
        let LensModel::Real(lens) = &input.camera.model else { return None };
        let farthest = MAX_ENTRY * lens.prescription.rows[0].diameter / 2.0;
        let mut view =
            Self { half: 0.0, exposure: 0.0, hits: vec![0; input.scene.lights.all.len()], rays: 0 };
        let (mut columns, mut paths) = (LensColumns::default(), PathColumns::default());
        let mut samples = SampleBatch::default();
        let key = pixel_key(u32::MAX, u32::MAX - 2, input.seed);
        // Rays leave the lens as those of a camera at rest.
        let pose = CameraPose::at(input.camera, None, 0.0);
        for wave in 0..CAMERA_WAVES {
            sample_film(input.camera, key, wave, &mut samples);
            // Bands at even distances have the mean response of all, nearly.
            let bands = lens.bands.len();
            samples.band = (bands * (2 * wave as usize + 1)) / (2 * CAMERA_WAVES as usize);
            let mut stats = LensStats::default();
            let rays = &mut paths.rays;
            input.camera.generate_rays::<f32x8>(&samples, &mut columns, rays, &mut stats);
            for i in 0..rays.len {
                let [origin, direction] =
                    [rays.ray(i).origin, rays.ray(i).direction].map(Vec3::from);
                let crossing = pose.crossing(lens, origin, direction);
                let reach = crossing.map_or(f64::INFINITY, |([x, y], _)| x.abs().max(y.abs()));
                if reach <= farthest {
                    view.half = view.half.max(reach);
                }
                view.exposure += f64::from(luminance(rays.throughput(i)));
            }
            for i in 0..samples.len {
                samples.time[i] = input.arrival_time(key, samples.sample[i]).scene;
            }
            if let Some(motion) = input.timing.and_then(|timing| timing.camera_motion.as_ref()) {
                motion.transform_rays(&samples.time, rays);
            }
            if input.scene.has_media() {
                rays.medium[..rays.len].fill(input.scene.camera_medium);
            }
            let surroundings = Surroundings::of(input.scene, &samples, 0, 1);
            paths.trace::<f32x8>(input.scene, &surroundings, |_, _| ());
            for hit in &paths.hits[..paths.rays.len] {
                if let Some(shape) = input.scene.shapes.get(hit.shape as usize)
                    && let Some(count) = view.hits.get_mut(shape.light as usize)
                {
                    *count += 1;
                }
            }
            view.rays += WAVE_SIZE as u32;
        }
        view.half *= MARGIN;
        view.exposure /= f64::from(view.rays);
        (view.half > 0.0 && view.half.is_finite()).then_some(view)
    }

    /// Returns the share of the rays that hit a light.
    pub fn share(&self, light: u32) -> f64 {
        f64::from(self.hits[light as usize]) / f64::from(self.rays)
    }
}

/// Samples a wave over the whole film and pupil.
pub(crate) fn sample_film(camera: &Camera, key: u32, wave: u32, samples: &mut SampleBatch) {
    samples.len = WAVE_SIZE;
    for i in 0..WAVE_SIZE {
        let number = wave * WAVE_SIZE as u32 + i as u32;
        (samples.key[i], samples.sample[i]) = (key, number);
        let [film, pupil] = [Dimension::Film, Dimension::Pupil].map(|d| sample_2d(key, number, d));
        for axis in 0..2 {
            let place = (f64::from(film[axis]) - 0.5) * camera.film[axis];
            samples.film[axis][i] = place as f32;
            samples.pupil[axis][i] = pupil[axis];
        }
    }
}
