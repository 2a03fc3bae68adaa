//! Progressive render: a picture that is shown while it is refined.

use std::sync::atomic::Ordering;

use rayon::ThreadPool;
use rayon::prelude::*;

use super::splat_accumulator::SplatAccumulator;
use super::uniform::PASS_SAMPLES;
use super::wave::{Wave, WorkItem};
use super::{OpticalImage, Progress, RenderError};
use crate::film::{ExtraChannels, FilmSums, Tile, TileSums};
use crate::job::Job;
use petzval_base::lanes::f32x8;
use petzval_base::rays::ColumnPool;
use petzval_base::stats::Stats;
use petzval_image::Picture;

/// Render that takes samples step by step and has a picture after each step.
///
/// The picture after some number of samples per pixel is that of [`render`](super::render()) with
/// this number, without diffraction, bit for bit and whatever the steps: tiles carry the rounding
/// errors of their sums, and passes end at the same sample numbers. Neither the layers nor the stop
/// criteria of the job apply.
pub struct ProgressiveRender<'a> {
    job: &'a Job,
    pool: ThreadPool,
    waves: ColumnPool<Wave>,
    tiles: Vec<Tile>,
    /// The samples of the current pass, by tile.
    pass: Vec<TileSums>,
    /// The samples of complete passes.
    film: FilmSums,
    splats: SplatAccumulator,
    samples: u32,
}

impl<'a> ProgressiveRender<'a> {
    /// Starts a render without samples. 0 threads mean one for each core.
    ///
    /// # Errors
    /// Returns an error if the threads cannot be started.
    pub fn new(job: &'a Job, threads: usize) -> Result<Self, RenderError> {
        let pool = super::thread_pool(threads)?;
        let tiles = job.tiles();
        Ok(Self {
            job,
            waves: ColumnPool::default(),
            pool,
            pass: Self::new_pass(job, &tiles),
            tiles,
            film: FilmSums::new(job.frame).with_extra(&Self::extra_channels(job)),
            splats: SplatAccumulator::new(job),
            samples: 0,
        })
    }

    /// Returns the channels that the picture depends on: a sensor reads both halves of the pupil, if they are recorded.
    fn extra_channels(job: &Job) -> ExtraChannels {
        match job.records_halves() {
            true => job.extra_channels(),
            false => ExtraChannels::default(),
        }
    }

    /// Returns the sums of a pass without samples.
    fn new_pass(job: &Job, tiles: &[Tile]) -> Vec<TileSums> {
        let channels = Self::extra_channels(job);
        tiles.iter().map(|tile| TileSums::new(tile).with_extra(&channels)).collect()
    }

    /// Returns the memory of the pixels of a job besides its film (bytes): the sums of a pass and their
    /// errors, and a copy of the film from which a picture is made.
    pub fn bytes(job: &Job) -> u64 {
        let pixels: u64 = job.frame.size().map(u64::from).iter().product();
        let extra = (Self::extra_channels(job).count() * size_of::<f64>()) as u64;
        3 * pixels * (FilmSums::bytes_per_pixel(false) + extra)
    }

    /// Returns the number of samples that every pixel has taken.
    pub fn samples(&self) -> u32 {
        self.samples
    }

    /// Takes more samples of every pixel, at most `count`: a step ends where a pass does. Returns
    /// the render with them.
    ///
    /// # Errors
    /// Returns an error if `progress` is stopped. The samples so far are lost, as some pixels have
    /// more than others.
    pub fn step(mut self, count: u32, progress: &Progress) -> Result<Self, RenderError> {
        let end = (self.samples + 1).next_multiple_of(PASS_SAMPLES).min(self.samples + count);
        let first = self.job.samples.start;
        let samples = first + self.samples..first + end;
        let Self { job, pool, waves, tiles, pass, splats, .. } = &mut self;
        pool.install(|| {
            tiles.par_iter().zip(pass).for_each(|(&tile, sums)| {
                if progress.stop.load(Ordering::Relaxed) {
                    return;
                }
                let item = WorkItem { tile, samples: samples.clone(), seed: job.seed };
                let rendered = waves.lend(
                    || Wave::new(job),
                    |wave| wave.render_item::<f32x8>(job, &item, progress),
                );
                if let Some((result, _)) = rendered {
                    sums.add_exactly(&result.sums);
                }
            });
        });
        let stopped = || progress.stop.load(Ordering::Relaxed);
        while !splats.covers(end) && !stopped() {
            let (stop, stats) = (Some(&progress.stop), &mut Stats::default());
            pool.install(|| {
                splats.add_samples::<f32x8>(job, end, &|| !stopped(), stop, stats);
            });
        }
        if stopped() {
            return Err(RenderError::Stopped);
        }
        self.samples = end;
        if end.is_multiple_of(PASS_SAMPLES) {
            self.film = self.film_with_pass();
            self.pass = Self::new_pass(self.job, &self.tiles);
        }
        Ok(self)
    }

    /// Returns the picture, read out by the sensor if there is one. Diffraction, which takes seconds,
    /// is left out.
    pub fn picture(&self) -> Picture {
        let mut film = self.film_with_pass();
        self.splats.add_scaled_to(&mut film, 1.0);
        OpticalImage::from_film(film, self.samples).read_out(self.job).picture
    }

    /// Returns the film of complete passes with the samples of the current one.
    fn film_with_pass(&self) -> FilmSums {
        let mut film = self.film.clone();
        for (tile, sums) in self.tiles.iter().zip(&self.pass) {
            let mut sums = sums.clone();
            sums.round();
            film.add_tile(tile, &sums);
        }
        film
    }
}
