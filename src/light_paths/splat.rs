//! Splats: light that light paths add to pixels, in an order that no thread changes.

use std::time::Duration;

use rayon::prelude::*;

use super::LightPathInput;
use crate::film::FilmSums;
use crate::rays::WAVE_SIZE;
use crate::stats::{Stage, Stats, thread_time};

/// Most splats that wait to be added to the film: 10 MB.
const MOST_WAITING: u64 = 1 << 19;

/// A pixel of the picture and the light that is added to it.
#[derive(Clone, Copy)]
pub(crate) struct Splat {
    pub pixel: [u32; 2],
    pub light: [f32; 3],
}

/// Number of the light paths of a sample number, in whole waves.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathCount {
    waves: u32,
}

impl PathCount {
    /// One path for every `samples_per_path` pixels of a picture of this width and height.
    pub fn new([width, height]: [u32; 2], samples_per_path: u64) -> Self {
        let pixels = u64::from(width) * u64::from(height);
        Self { waves: pixels.div_ceil(samples_per_path * WAVE_SIZE as u64) as u32 }
    }

    /// Returns the number of paths.
    pub fn paths(self) -> f64 {
        f64::from(self.waves) * WAVE_SIZE as f64
    }

    /// Returns the factor from the flux of a path (radiance times mm^2 sr) to the value of the pixel
    /// that receives it.
    pub fn splat_scale(self, input: &LightPathInput<'_>) -> f64 {
        let pitch = input.camera.pixel_pitch(input.frame.resolution);
        // The film divides by the number of samples.
        input.camera.imaging_ratio / (pitch[0] * pitch[1] * self.paths())
    }

    /// Returns the largest size of the splats that wait to be added to the film (bytes), if a path
    /// has so many at most.
    pub fn bytes_waiting(self, splats_per_path: u64) -> u64 {
        let paths = u64::from(self.waves.min(chunk(splats_per_path))) * WAVE_SIZE as u64;
        paths * splats_per_path * size_of::<Splat>() as u64
    }
}

/// Returns the number of waves that are traced before their splats are added to the film.
fn chunk(splats_per_path: u64) -> u32 {
    (MOST_WAITING / (splats_per_path * WAVE_SIZE as u64)).max(1) as u32
}

/// Adds the splats of all waves of a sample number to the film, in the order of the waves. `wave`
/// returns the splats of one; each thread has its own columns `C`.
pub(crate) fn add_splats<C: Default + Send>(
    input: &LightPathInput<'_>,
    (PathCount { waves: count }, splats_per_path): (PathCount, u64),
    film: &mut FilmSums,
    stats: &mut Stats,
    wave: impl Fn(&mut C, u32) -> Vec<Splat> + Sync,
) {
    let size = chunk(splats_per_path);
    for first in (0..count).step_by(size as usize) {
        let one = |columns: &mut C, number| {
            let start = thread_time();
            let splats = wave(columns, number);
            (splats, thread_time().saturating_sub(start))
        };
        let chunk: Vec<(Vec<Splat>, Duration)> =
            (first..count.min(first + size)).into_par_iter().map_init(C::default, one).collect();
        let stage = &mut stats.stages[Stage::LightPaths as usize];
        for (splats, time) in chunk {
            stage.time += time;
            stage.rays += WAVE_SIZE as u64;
            for Splat { pixel, light } in splats {
                film.add_light(pixel, input.response.apply_colour(light.map(f64::from)));
            }
        }
    }
}

/// Returns the position of a film point (mm) in the whole picture, in pixels from its top left.
pub(crate) fn film_pixels(input: &LightPathInput<'_>, point: [f32; 2]) -> [f64; 2] {
    let share = [0, 1].map(|i| f64::from(point[i]) / input.camera.film[i]);
    // The picture is mirrored in x and upside down in y, as in the film stage.
    let share = [0.5 - share[0], 0.5 + share[1]];
    [0, 1].map(|i| share[i] * f64::from(input.frame.resolution[i]))
}
