//! Ghosts, sample number by sample number.

use std::io;

use super::{Job, Progress};
use crate::checkpoint::{Reader, Writer};
use crate::film::FilmSums;
use crate::lanes::Real;
use crate::stats::Stats;

/// What ghosts have brought to the film so far.
pub(super) struct Haunt {
    /// Where there are any.
    film: Option<FilmSums>,
    /// Sample numbers that the film is the sum of.
    pub samples: u32,
}

impl Haunt {
    pub fn new(job: &Job) -> Self {
        Self { film: job.ghosts.as_ref().map(|_| FilmSums::new(job.frame, false)), samples: 0 }
    }

    /// Whether the ghosts of so many samples are there, or none are wanted.
    pub fn reaches(&self, samples: u32) -> bool {
        self.film.is_none() || self.samples >= samples
    }

    /// Adds those of the next sample number: always all of them, as part of one could not be told
    /// from the whole.
    pub fn add<R: Real<Scalar = f32>>(&mut self, job: &Job, stats: &mut Stats) {
        if let (Some(ghosts), Some(film)) = (&job.ghosts, &mut self.film) {
            let sample = job.samples.start.saturating_add(self.samples);
            let whole = Progress::default();
            ghosts.expose::<R>(job, sample..sample.saturating_add(1), film, stats, &whole);
        }
        self.samples += 1;
    }

    /// Adds a share of them to a film.
    pub fn put(&self, film: &mut FilmSums, share: f64) {
        if let Some(ghosts) = &self.film {
            film.add_film(ghosts, share);
        }
    }

    /// Adds their mean over the samples.
    pub fn put_mean(&self, film: &mut FilmSums) {
        if self.samples > 0 {
            self.put(film, 1.0 / f64::from(self.samples));
        }
    }

    pub fn save(&self, to: &mut Writer) -> io::Result<()> {
        to.u32(self.samples)?;
        self.film.iter().try_for_each(|film| film.save(to))
    }

    /// Adds those of other samples.
    pub fn receive(&mut self, from: &mut Reader) -> io::Result<()> {
        self.samples += from.below(1 << 30, "samples of ghosts")? as u32;
        self.film.iter_mut().try_for_each(|film| film.receive(from))
    }
}
