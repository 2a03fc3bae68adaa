//! Those who work on a render, and who writes down meanwhile what they have done.

use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::thread::{self, Thread};
use std::time::{Duration, Instant};

use rayon::prelude::*;

use super::keeper::{Keep, Keeper};
use super::{Job, Progress, Share, Wave};
use crate::checkpoint::{self, CheckpointError, Head};
use crate::lanes::Real;
use crate::stats::Stats;

/// A picture that took so long, or the time between checkpoints, is kept until it stands in its file.
/// To write the samples down costs less than a hundredth of that.
const WORTH: Duration = Duration::from_secs(10);

/// The workers of a render, and its keeper.
pub(super) struct Crew<'a> {
    pub job: &'a Job,
    pub progress: &'a Progress,
    keeper: Option<&'a Keeper>,
    waves: Vec<Mutex<Box<Wave>>>,
    /// Film samples of the shares that are entered, and of the render that it goes on from.
    taken: AtomicU64,
    /// What each worker has done up to its last share; the last entry is of nobody.
    booked: Vec<Mutex<Stats>>,
    begun: Instant,
    /// When the last checkpoint was written, or would have been.
    kept: Mutex<Instant>,
}

pub(super) fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl<'a> Crew<'a> {
    /// A crew that goes on from what others did.
    pub fn new(
        job: &'a Job,
        progress: &'a Progress,
        keeper: Option<&'a Keeper>,
        from: Option<&Head>,
    ) -> Self {
        let workers = rayon::current_num_threads();
        let mut booked: Vec<Mutex<Stats>> = Vec::new();
        booked.resize_with(workers, Mutex::default);
        let (taken, earlier) =
            from.map(|head| (head.taken, head.stats.clone())).unwrap_or_default();
        booked.push(Mutex::new(earlier));
        let waves = (0..workers).map(|_| Mutex::new(Wave::new(job))).collect();
        let begun = Instant::now();
        let taken = AtomicU64::new(taken);
        Self { job, progress, keeper, waves, taken, booked, begun, kept: Mutex::new(begun) }
    }

    pub fn stopped(&self) -> bool {
        self.progress.stop.load(Ordering::Relaxed)
    }

    /// Enters what each share receives, unless it is there already; not all of them where it is told
    /// to stop.
    pub fn expose<R: Real<Scalar = f32>>(&self, shares: &[Share], state: &impl Keep) {
        let one = |(number, share): (usize, &Share)| {
            if state.has(number) || self.stopped() {
                return;
            }
            let worker = rayon::current_thread_index().unwrap_or(0);
            let mut wave = lock(&self.waves[worker]);
            if let Some((received, samples)) = wave.expose_tile::<R>(self.job, share, self.progress)
            {
                state.enter(number, received);
                self.taken.fetch_add(samples, Ordering::Relaxed);
                lock(&self.booked[worker]).clone_from(&wave.stats);
            }
        };
        let work = || shares.par_iter().enumerate().for_each(one);
        let Some(every) = self.keeper.and_then(|keeper| keeper.every) else { return work() };
        let ended = AtomicBool::new(false);
        thread::scope(|scope| {
            let writer = scope.spawn(|| {
                while !ended.load(Ordering::Relaxed) {
                    match self.left(every) {
                        Duration::ZERO => self.keep(state),
                        left => thread::park_timeout(left),
                    }
                }
            });
            let _end = End { ended: &ended, writer: writer.thread() };
            work();
        });
    }

    /// Adds ghosts until they are those of so many samples, or it is told to stop.
    pub fn haunt<R: Real<Scalar = f32>>(&self, state: &mut impl Keep, samples: u32) {
        while !state.haunt().reaches(samples) && !self.stopped() {
            let mut stats = Stats::default();
            state.haunt().add::<R>(self.job, &mut stats);
            if let Some(last) = self.booked.last() {
                lock(last).add(&stats);
            }
            let every = self.keeper.and_then(|keeper| keeper.every);
            if every.is_some_and(|every| self.left(every).is_zero()) {
                self.keep(state);
            }
        }
    }

    /// The time until the next checkpoint.
    fn left(&self, every: Duration) -> Duration {
        every.saturating_sub(lock(&self.kept).elapsed())
    }

    /// Writes a checkpoint. Where that fails the picture is worth more than it.
    fn keep(&self, state: &impl Keep) {
        if let Some(keeper) = self.keeper
            && let Err(error) = self.checkpoint(keeper, state)
        {
            (keeper.tell)(&error);
        }
        *lock(&self.kept) = Instant::now();
    }

    fn checkpoint(&self, keeper: &Keeper, state: &impl Keep) -> Result<(), CheckpointError> {
        let head = self.head(keeper, false);
        match head.taken < keeper.standing {
            true => Ok(()),
            false => checkpoint::write(&keeper.path, &head, |body| state.save(body)),
        }
    }

    /// Writes down how it ended: a checkpoint where it is not complete, and otherwise the part that
    /// is asked for. A picture that took long has a checkpoint with all of its samples too, until
    /// it stands in its file.
    pub fn end(&self, state: &impl Keep, complete: bool) -> Result<(), CheckpointError> {
        let Some(keeper) = self.keeper else { return Ok(()) };
        match (complete, &keeper.part) {
            (false, _) if keeper.every.is_some() => self.checkpoint(keeper, state),
            (true, Some(part)) => {
                let head = self.head(keeper, true);
                let written = checkpoint::write(part, &head, |body| state.save(body));
                if written.is_err() && keeper.every.is_some() {
                    self.keep(state);
                }
                written
            }
            (true, None)
                if keeper.every.is_some_and(|every| self.begun.elapsed() >= every.min(WORTH)) =>
            {
                self.keep(state);
                Ok(())
            }
            _ => Ok(()),
        }
    }

    fn head(&self, keeper: &Keeper, complete: bool) -> Head {
        let taken = self.taken.load(Ordering::Relaxed);
        Head { complete, taken, stats: self.stats(), ..keeper.head.clone() }
    }

    /// What all of them have done.
    pub fn stats(&self) -> Stats {
        let mut stats = Stats::default();
        self.booked.iter().for_each(|booked| stats.add(&lock(booked)));
        stats
    }
}

/// Lets the writer go, also when a worker panics.
struct End<'a> {
    ended: &'a AtomicBool,
    writer: &'a Thread,
}

impl Drop for End<'_> {
    fn drop(&mut self) {
        self.ended.store(true, Ordering::Relaxed);
        self.writer.unpark();
    }
}
