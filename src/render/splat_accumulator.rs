//! Accumulator of the light that light paths splat, which adds whole sample numbers.

use std::io;
use std::sync::atomic::AtomicBool;

use crate::film::FilmSums;
use crate::job::Job;
use crate::light_tracing::SplatStage;
use crate::light_tracing::light_paths::LightPathInput;
use petzval_base::io::codec::{ChecksumReader, ChecksumWriter};
use petzval_base::lanes::Real;
use petzval_base::stats::Stats;

/// Sum of the light of some sample numbers: lamp images, caustics and ghosts.
pub(super) struct SplatAccumulator {
    /// `None` if there are no light paths.
    film: Option<FilmSums>,
    /// The number of sample numbers in the sum.
    pub samples: u32,
    stage: SplatStage,
}

impl SplatAccumulator {
    pub fn new(job: &Job) -> Self {
        let film = || FilmSums::new(job.frame).with_extra(&job.extra_channels());
        let film = (!job.light_strategies().is_empty()).then(film);
        Self { film, samples: 0, stage: SplatStage::default() }
    }

    /// Returns whether the sum has this many sample numbers, or there are no light paths.
    pub fn covers(&self, samples: u32) -> bool {
        self.film.is_none() || self.samples >= samples
    }

    /// Adds the light of further sample numbers until the sum has this many, as long as `goes_on` says
    /// so: it is asked between sample numbers, as a checkpoint cannot tell a part of one from the whole.
    /// If `stop` is given, the sum is of no use once it is set.
    pub fn add_samples<R: Real<Scalar = f32>>(
        &mut self,
        job: &Job,
        until: u32,
        goes_on: &(dyn Fn() -> bool + Sync),
        stop: Option<&AtomicBool>,
        stats: &mut Stats,
    ) {
        let Some(film) = &mut self.film else { return };
        let [first, end] = [self.samples, until].map(|n| job.samples.start.saturating_add(n));
        let input = LightPathInput { stop, ..job.light_path_input() };
        let strategies = job.light_strategies();
        let added = self.stage.run::<R>(&input, &strategies, first..end, goes_on, film, stats);
        self.samples = if added == end - first { until } else { self.samples + added };
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
