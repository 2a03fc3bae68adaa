//! Worker pool of a render, and its periodic checkpoints.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::Progress;
use super::checkpoint::{self, CheckpointError, Head};
use super::checkpointer::{Checkpointer, RenderState};
use super::wave::{Wave, WorkItem};
use crate::job::Job;
use petzval_base::lanes::Real;
use petzval_base::rays::ColumnPool;
use petzval_base::stats::Stats;

/// Render time from which a complete picture is kept in a checkpoint until it is in its file, unless
/// the interval between checkpoints is shorter. Writing it costs less than a hundredth of this time.
const WORTH_KEEPING: Duration = Duration::from_secs(10);

/// The workers of a render.
pub(super) struct Workers<'a> {
    pub job: &'a Job,
    pub progress: &'a Progress,
    checkpointer: Option<&'a Checkpointer>,
    waves: ColumnPool<Wave>,
    /// The number of film samples of all completed items, including those of the resumed render.
    samples_taken: AtomicU64,
    /// Statistics of all completed items, of splats, and of the resumed render.
    stats: Mutex<Stats>,
    start: Instant,
    /// The time of the last checkpoint, or of the last attempt.
    last_checkpoint: Mutex<Instant>,
}

pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<'a> Workers<'a> {
    /// Returns workers that resume from the counts of a checkpoint.
    pub fn new(
        job: &'a Job,
        progress: &'a Progress,
        checkpointer: Option<&'a Checkpointer>,
        resumed: Option<&Head>,
    ) -> Self {
        let (samples_taken, earlier) =
            resumed.map(|head| (head.film_samples, head.stats.clone())).unwrap_or_default();
        let start = Instant::now();
        Self {
            job,
            progress,
            checkpointer,
            waves: ColumnPool::default(),
            samples_taken: AtomicU64::new(samples_taken),
            stats: Mutex::new(earlier),
            start,
            last_checkpoint: Mutex::new(start),
        }
    }

    pub fn stopped(&self) -> bool {
        self.progress.stop.load(Ordering::Relaxed)
    }

    /// Renders the items that the state does not hold yet, until the render is stopped, and writes
    /// periodic checkpoints.
    pub fn render_items<R: Real<Scalar = f32>>(
        &self,
        items: &[WorkItem],
        state: &impl RenderState,
    ) {
        let render = |(number, item): (usize, &WorkItem)| {
            if state.is_done(number) || self.stopped() {
                return;
            }
            let rendered = self.waves.lend(
                || Wave::new(self.job),
                |wave| {
                    let rendered = wave.render_item::<R>(self.job, item, self.progress)?;
                    Some((rendered, std::mem::take(&mut wave.stats)))
                },
            );
            if let Some(((mut result, samples), stats)) = rendered {
                result.sums.round();
                state.add_result(number, result);
                self.samples_taken.fetch_add(samples, Ordering::Relaxed);
                lock(&self.stats).add(&stats);
            }
        };
        let work = || items.par_iter().enumerate().for_each(render);
        let Some(interval) = self.interval() else { return work() };
        let ended = AtomicBool::new(false);
        thread::scope(|scope| {
            let writer = scope.spawn(|| {
                while !ended.load(Ordering::Relaxed) {
                    match self.time_to_checkpoint(interval) {
                        Duration::ZERO => self.try_checkpoint(state),
                        left => thread::park_timeout(left),
                    }
                }
            });
            let _guard = WriterGuard { ended: &ended, writer: writer.thread() };
            work();
        });
    }

    /// Adds splats until they cover this many samples or the render is stopped.
    pub fn render_splats<R: Real<Scalar = f32>>(&self, state: &mut impl RenderState, samples: u32) {
        let checkpoint_is_due =
            || self.interval().is_some_and(|interval| self.time_to_checkpoint(interval).is_zero());
        let goes_on = || !self.stopped() && !checkpoint_is_due();
        while !state.splats().covers(samples) && !self.stopped() {
            let mut stats = Stats::default();
            state.splats().add_samples::<R>(self.job, samples, &goes_on, None, &mut stats);
            lock(&self.stats).add(&stats);
            if checkpoint_is_due() {
                self.try_checkpoint(state);
            }
        }
    }

    /// Returns the time between checkpoints, if there are any.
    fn interval(&self) -> Option<Duration> {
        self.checkpointer.and_then(|checkpointer| checkpointer.interval)
    }

    fn time_to_checkpoint(&self, interval: Duration) -> Duration {
        interval.saturating_sub(lock(&self.last_checkpoint).elapsed())
    }

    /// Writes a checkpoint. Reports an error and goes on, as the picture is worth more.
    fn try_checkpoint(&self, state: &impl RenderState) {
        if let Some(checkpointer) = self.checkpointer
            && let Err(error) = self.write_checkpoint(checkpointer, state)
        {
            (checkpointer.on_error)(&error);
        }
        *lock(&self.last_checkpoint) = Instant::now();
    }

    fn write_checkpoint(
        &self,
        checkpointer: &Checkpointer,
        state: &impl RenderState,
    ) -> Result<(), CheckpointError> {
        let head = self.head(checkpointer, false);
        match head.film_samples < checkpointer.existing_samples {
            true => Ok(()),
            false => checkpoint::write(&checkpointer.path, &head, |body| state.save(body)),
        }
    }

    /// Writes the last file of a render: a checkpoint if it is not complete, or else the part that is
    /// asked for. A complete picture without a part that took long is kept in a checkpoint too, until
    /// it is in its file.
    pub fn write_final(
        &self,
        state: &impl RenderState,
        complete: bool,
    ) -> Result<(), CheckpointError> {
        let Some(checkpointer) = self.checkpointer else { return Ok(()) };
        let interval = checkpointer.interval;
        let worth_keeping =
            || interval.is_some_and(|time| self.start.elapsed() >= time.min(WORTH_KEEPING));
        match (complete, &checkpointer.part_path) {
            (false, _) if interval.is_some() => self.write_checkpoint(checkpointer, state),
            (true, Some(part_path)) => {
                let head = self.head(checkpointer, true);
                let written = checkpoint::write(part_path, &head, |body| state.save(body));
                if written.is_err() && interval.is_some() {
                    self.try_checkpoint(state);
                }
                written
            }
            (true, None) if worth_keeping() => {
                self.try_checkpoint(state);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn head(&self, checkpointer: &Checkpointer, complete: bool) -> Head {
        let film_samples = self.samples_taken.load(Ordering::Relaxed);
        Head { complete, film_samples, stats: self.stats(), ..checkpointer.head.clone() }
    }

    /// Returns the statistics of all completed items.
    pub fn stats(&self) -> Stats {
        lock(&self.stats).clone()
    }
}

/// Ends the writer thread, even if a worker panics.
struct WriterGuard<'a> {
    ended: &'a AtomicBool,
    writer: &'a Thread,
}

impl Drop for WriterGuard<'_> {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        self.writer.unpark();
    }
}
