//! Accumulator of the light that light paths splat, which adds one sample number at a time.

use std::io;
use std::sync::atomic::AtomicBool;

use crate::film::FilmSums;
use crate::io::codec::{ChecksumReader, ChecksumWriter};
use crate::job::Job;
use crate::lanes::Real;
use crate::light_tracing::light_paths::LightPathInput;
use crate::stats::Stats;

/// Sum of the light of some sample numbers: lamp images, caustics and ghosts.
pub(super) struct SplatAccumulator {
    /// `None` if there are no light paths.
    film: Option<FilmSums>,
    /// The number of sample numbers in the sum.
    pub samples: u32,
}

impl SplatAccumulator {
    pub fn new(job: &Job) -> Self {
        Self { film: job.has_light_paths().then(|| FilmSums::new(job.frame)), samples: 0 }
    }

    /// Returns whether the sum has this many sample numbers, or there are no light paths.
    pub fn covers(&self, samples: u32) -> bool {
        self.film.is_none() || self.samples >= samples
    }

    /// Adds the light of the next sample number. Without `stop`, it always adds all of it, even if
    /// the render is stopped meanwhile: a checkpoint cannot tell a part of a sample number from the
    /// whole. With it, the sum is of no use once `stop` is set.
    pub fn add_sample<R: Real<Scalar = f32>>(
        &mut self,
        job: &Job,
        stats: &mut Stats,
        stop: Option<&AtomicBool>,
    ) {
        if let Some(film) = &mut self.film {
            let sample = job.samples.start.saturating_add(self.samples);
            let samples = sample..sample.saturating_add(1);
            let input = LightPathInput { stop, ..job.light_path_input() };
            if let Some(lamps) = &job.lamp_images {
                lamps.splat::<R>(&input, samples.clone(), film, stats);
            }
            if let Some(caustics) = &job.caustics {
                caustics.splat::<R>(&input, samples.clone(), film, stats);
            }
            if let Some(ghosts) = &job.ghosts {
                ghosts.splat::<R>(&input, samples, film, stats);
            }
        }
        self.samples += 1;
    }

    /// Adds the sum to a film, times a factor.
    pub fn add_scaled_to(&self, film: &mut FilmSums, factor: f64) {
        if let Some(splats) = &self.film {
            film.add_film(splats, factor);
        }
    }

    /// Adds the mean over the sample numbers to a film.
    pub fn add_mean_to(&self, film: &mut FilmSums) {
        if self.samples > 0 {
            self.add_scaled_to(film, 1.0 / f64::from(self.samples));
        }
    }

    pub fn save(&self, to: &mut ChecksumWriter) -> io::Result<()> {
        to.u32(self.samples)?;
        self.film.iter().try_for_each(|film| film.save(to))
    }

    /// Adds the saved light of other sample numbers.
    pub fn add_saved(&mut self, from: &mut ChecksumReader) -> io::Result<()> {
        self.samples += from.below(1 << 30, "samples of light paths")? as u32;
        self.film.iter_mut().try_for_each(|film| film.receive(from))
    }
}
