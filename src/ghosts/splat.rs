//! Putting ghosts on the film: a stage of its own, behind all others.

use std::ops::Range;
use std::sync::atomic::Ordering;
use std::time::Duration;

use rayon::prelude::*;

use super::photons::Photons;
use super::{Ghosts, Pair};
use crate::film::FilmSums;
use crate::lanes::Real;
use crate::lens::{Model, RealLens};
use crate::rays::{LensBatch, WAVE};
use crate::render::{Job, Progress};
use crate::sampler::{Dimension, pair, pixel_key};
use crate::stats::{Stage, Stats};
use crate::thread_time::thread_time;

/// Waves whose light waits at a time: 8 MB.
const CHUNK: u32 = 512;

/// Samples of the picture to one light path: ghosts are unsharp, and need few.
pub const SAMPLES: u64 = 4;

/// In how many bands a path is traced at once.
const TOGETHER: usize = 4;

/// A path in one band that comes to the film.
#[derive(Clone, Copy)]
struct Arrival {
    /// Its place in the wave.
    slot: u32,
    pixel: [u32; 2],
    /// What of its flux becomes light of the pixel.
    share: [f32; 3],
}

/// Light for a pixel of the picture.
type Splat = ([u32; 2], [f32; 3]);

/// Waves of light paths of one sample number, in a picture of this width and height.
fn waves([width, height]: [u32; 2]) -> u32 {
    (u64::from(width) * u64::from(height)).div_ceil(SAMPLES * WAVE as u64) as u32
}

impl Ghosts {
    /// Bytes that wait at most to be added to the film of a picture of this width and height.
    pub fn bytes_waiting(resolution: [u32; 2]) -> u64 {
        let paths = u64::from(waves(resolution).min(CHUNK)) * (WAVE * TOGETHER) as u64;
        paths * size_of::<Splat>() as u64
    }

    /// A light path for every [`SAMPLES`] samples of the picture, and what they bring to the film. It falls
    /// into the pixel it falls on: filters would not change what is unsharp. As everywhere the
    /// sum depends on seed and sample numbers only, and parts of the samples add up.
    pub fn expose<R: Real<Scalar = f32>>(
        &self,
        job: &Job,
        samples: Range<u32>,
        film: &mut FilmSums,
        stats: &mut Stats,
        progress: &Progress,
    ) {
        let Model::Real(lens) = &job.camera.model else { return };
        let waves = waves(job.frame.resolution);
        // Of one sample number: what is added is divided by how many there are.
        let paths = f64::from(waves) * WAVE as f64;
        let pitch = [0, 1].map(|i| job.camera.film[i] / f64::from(job.frame.resolution[i]));
        let scale = job.camera.imaging_ratio / (pitch[0] * pitch[1] * paths);
        for sample in samples {
            for first in (0..waves).step_by(CHUNK as usize) {
                if progress.stop.load(Ordering::Relaxed) {
                    return;
                }
                let one = |photons: &mut Box<Photons>, wave| {
                    let start = thread_time();
                    let splats = self.wave::<R>(job, lens, photons, [wave, sample], scale);
                    (splats, thread_time().saturating_sub(start))
                };
                let chunk: Vec<(Vec<Splat>, Duration)> = (first..waves.min(first + CHUNK))
                    .into_par_iter()
                    .map_init(Box::default, one)
                    .collect();
                let stage = &mut stats.stages[Stage::Ghosts as usize];
                for (splats, time) in chunk {
                    stage.time += time;
                    stage.rays += WAVE as u64;
                    for (pixel, light) in splats {
                        film.add(pixel, job.film.balanced(light.map(f64::from)));
                    }
                }
            }
        }
    }

    /// The light of one wave, which is of one pair. Every path is traced in some bands that lie
    /// evenly apart, so that the hue of what few paths bring is near that of many.
    fn wave<R: Real<Scalar = f32>>(
        &self,
        job: &Job,
        lens: &RealLens,
        photons: &mut Photons,
        [wave, sample]: [u32; 2],
        scale: f64,
    ) -> Vec<Splat> {
        // The waves of a sample number share out pairs and bands evenly.
        let of_sample = pixel_key(sample, u32::MAX - 1, job.seed);
        let [u, v] = pair(of_sample, wave, Dimension::Wavelength);
        let Some(Pair { share, entry, bands, .. }) = self.choose(f64::from(u)) else {
            return Vec::new();
        };
        photons.sample(job, lens, pixel_key(wave, sample, of_sample), Some(entry));
        let together = bands.len().min(TOGETHER);
        let factor = scale / (share * together as f64);
        let stride = bands.len() / together;
        let first = (v * stride as f32) as usize;
        let mut arrivals: Vec<Arrival> = Vec::new();
        for (surfaces, response) in bands.iter().skip(first).step_by(stride) {
            if !photons.through::<R>(lens, surfaces) {
                continue;
            }
            let LensBatch { x, y, weight, .. } = photons.behind();
            for i in 0..photons.len() {
                if let Some(pixel) = place(job, [x[i], y[i]]) {
                    let share = response.map(|r| (f64::from(weight[i]) * r * factor) as f32);
                    arrivals.push(Arrival { slot: i as u32, pixel, share });
                }
            }
        }
        photons.connect::<R>(job, arrivals.iter().map(|arrival| arrival.slot));
        let splat = |&Arrival { slot, pixel, share }: &Arrival| {
            let flux = photons.arrived(slot as usize);
            let light = [0, 1, 2].map(|c| flux[c] * share[c]);
            let shines = light != [0.0; 3] && light.iter().all(|c| c.is_finite());
            shines.then_some((pixel, light))
        };
        arrivals.iter().filter_map(splat).collect()
    }

    /// The pair that a number in [0, 1) falls to.
    fn choose(&self, u: f64) -> Option<&Pair> {
        let mut sum = 0.0;
        let found = self.pairs.iter().find(|pair| {
            sum += pair.share;
            u < sum
        });
        found.or(self.pairs.last())
    }
}

/// The pixel of the rendered part in which a point of the film lies, mm.
fn place(job: &Job, point: [f32; 2]) -> Option<[u32; 2]> {
    let frame = &job.frame;
    let share = [0, 1].map(|i| f64::from(point[i]) / job.camera.film[i]);
    // Mirrored in x and upside down in y, as the film stage has it.
    let share = [0.5 - share[0], 0.5 + share[1]];
    let pixel = [0, 1].map(|i| (share[i] * f64::from(frame.resolution[i])).floor());
    let inside =
        (0..2).all(|i| pixel[i] >= f64::from(frame.low[i]) && pixel[i] < f64::from(frame.high[i]));
    inside.then(|| pixel.map(|p| p as u32))
}
