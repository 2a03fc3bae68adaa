//! Ghost stage: splats light paths on the film, after all other stages.

use std::ops::Range;
use std::time::Duration;

use rayon::prelude::*;

use super::light_paths::LightPaths;
use super::{GhostInput, GhostPair, Ghosts};
use crate::film::FilmSums;
use crate::lanes::Real;
use crate::lens::{LensModel, RealLens};
use crate::rays::{LensBatch, WAVE_SIZE};
use crate::sampler::{Dimension, pixel_key, sample_2d};
use crate::stats::thread_time;
use crate::stats::{Stage, Stats};

/// Waves that are traced before their splats are added to the film: 8 MB.
const CHUNK: u32 = 512;

/// Samples of the picture per light path. Ghosts are unsharp and need few paths.
pub const SAMPLES_PER_PATH: u64 = 4;

/// Largest number of bands in which one path is traced.
const BANDS_PER_PATH: usize = 4;

/// A path in one band that arrives on the film.
#[derive(Clone, Copy)]
struct Arrival {
    /// Its index in the wave.
    slot: u32,
    pixel: [u32; 2],
    /// Factor from its flux to the value of the pixel, by channel.
    share: [f32; 3],
}

/// A pixel of the picture and the light that is added to it.
#[derive(Clone, Copy)]
struct Splat {
    pixel: [u32; 2],
    light: [f32; 3],
}

/// Returns the number of waves of light paths per sample index, for a picture of this width and
/// height.
fn waves([width, height]: [u32; 2]) -> u32 {
    (u64::from(width) * u64::from(height)).div_ceil(SAMPLES_PER_PATH * WAVE_SIZE as u64) as u32
}

impl Ghosts {
    /// Returns the largest size of the splats that wait to be added to the film of a picture of
    /// this width and height (bytes).
    pub fn bytes_waiting(resolution: [u32; 2]) -> u64 {
        let paths = u64::from(waves(resolution).min(CHUNK)) * (WAVE_SIZE * BANDS_PER_PATH) as u64;
        paths * size_of::<Splat>() as u64
    }

    /// Traces one light path for every [`SAMPLES_PER_PATH`] samples of the picture and adds the
    /// ghosts to the film: a stage.
    ///
    /// A path is added to the pixel that it hits; a filter would not change an unsharp image. The
    /// sum depends on seed and sample indices only, and the sums of disjoint sample ranges add up.
    pub fn splat<R: Real<Scalar = f32>>(
        &self,
        input: &GhostInput<'_>,
        samples: Range<u32>,
        film: &mut FilmSums,
        stats: &mut Stats,
    ) {
        let LensModel::Real(lens) = &input.camera.model else { return };
        let waves = waves(input.frame.resolution);
        // Paths of one sample index. The film divides by the number of samples.
        let paths = f64::from(waves) * WAVE_SIZE as f64;
        let pitch = [0, 1].map(|i| input.camera.film[i] / f64::from(input.frame.resolution[i]));
        let scale = input.camera.imaging_ratio / (pitch[0] * pitch[1] * paths);
        for sample in samples {
            for first in (0..waves).step_by(CHUNK as usize) {
                let one = |wave_paths: &mut Box<LightPaths>, wave| {
                    let start = thread_time();
                    let splats = self.wave::<R>(input, lens, wave_paths, [wave, sample], scale);
                    (splats, thread_time().saturating_sub(start))
                };
                let chunk: Vec<(Vec<Splat>, Duration)> = (first..waves.min(first + CHUNK))
                    .into_par_iter()
                    .map_init(Box::default, one)
                    .collect();
                let stage = &mut stats.stages[Stage::Ghosts as usize];
                for (splats, time) in chunk {
                    stage.time += time;
                    stage.rays += WAVE_SIZE as u64;
                    for Splat { pixel, light } in splats {
                        film.add_light(pixel, input.response.apply_colour(light.map(f64::from)));
                    }
                }
            }
        }
    }

    /// Returns the splats of one wave, which samples one pair. Every path is traced in several
    /// evenly spaced bands, so that few paths already have nearly the right hue.
    fn wave<R: Real<Scalar = f32>>(
        &self,
        input: &GhostInput<'_>,
        lens: &RealLens,
        wave_paths: &mut LightPaths,
        [wave, sample]: [u32; 2],
        scale: f64,
    ) -> Vec<Splat> {
        // A low-discrepancy sequence distributes the waves of a sample index over pairs and bands.
        let of_sample = pixel_key(sample, u32::MAX - 1, input.seed);
        let [u, v] = sample_2d(of_sample, wave, Dimension::Wavelength);
        let Some(GhostPair { share, entry, bands, .. }) = self.choose(f64::from(u)) else {
            return Vec::new();
        };
        wave_paths.sample(input, lens, pixel_key(wave, sample, of_sample), Some(entry));
        let traced_bands = bands.len().min(BANDS_PER_PATH);
        let factor = scale / (share * traced_bands as f64);
        let stride = bands.len() / traced_bands;
        let first = (v * stride as f32) as usize;
        let mut arrivals: Vec<Arrival> = Vec::new();
        for (surfaces, response) in bands.iter().skip(first).step_by(stride) {
            if !wave_paths.trace::<R>(lens, surfaces) {
                continue;
            }
            let LensBatch { x, y, weight, .. } = wave_paths.film_hits();
            for i in 0..wave_paths.len() {
                if let Some(pixel) = film_pixel(input, [x[i], y[i]]) {
                    let share = response.map(|r| (f64::from(weight[i]) * r * factor) as f32);
                    arrivals.push(Arrival { slot: i as u32, pixel, share });
                }
            }
        }
        wave_paths.connect::<R>(input, arrivals.iter().map(|arrival| arrival.slot));
        let splat = |&Arrival { slot, pixel, share }: &Arrival| {
            let flux = wave_paths.flux(slot as usize);
            let light = [0, 1, 2].map(|c| flux[c] * share[c]);
            let is_lit = light != [0.0; 3] && light.iter().all(|c| c.is_finite());
            is_lit.then_some(Splat { pixel, light })
        };
        arrivals.iter().filter_map(splat).collect()
    }

    /// Returns the pair that a number in [0, 1) selects.
    fn choose(&self, u: f64) -> Option<&GhostPair> {
        let mut sum = 0.0;
        let found = self.pairs.iter().find(|pair| {
            sum += pair.share;
            u < sum
        });
        found.or(self.pairs.last())
    }
}

/// Returns the rendered pixel that contains a film point (mm).
fn film_pixel(input: &GhostInput<'_>, point: [f32; 2]) -> Option<[u32; 2]> {
    let frame = &input.frame;
    let share = [0, 1].map(|i| f64::from(point[i]) / input.camera.film[i]);
    // The picture is mirrored in x and upside down in y, as in the film stage.
    let share = [0.5 - share[0], 0.5 + share[1]];
    let pixel = [0, 1].map(|i| (share[i] * f64::from(frame.resolution[i])).floor());
    let inside =
        (0..2).all(|i| pixel[i] >= f64::from(frame.low[i]) && pixel[i] < f64::from(frame.high[i]));
    inside.then(|| pixel.map(|p| p as u32))
}
