//! Progress of a ladder's run, and its two ways to stop: the user and the time limit.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use super::point::Point;
use petzval_render::Progress;

/// Progress and stop switch of a run, shared with its observers.
#[derive(Debug, Default)]
pub struct RunMonitor {
    pub(super) progress: Progress,
    interrupted: AtomicBool,
    activity: Mutex<String>,
    points: Mutex<Vec<Point>>,
}

impl RunMonitor {
    /// Ends the run at the next wave. Returns false if this was requested before.
    pub fn interrupt(&self) -> bool {
        self.progress.stop.store(true, Ordering::Relaxed);
        !self.interrupted.swap(true, Ordering::Relaxed)
    }

    /// Returns whether the user asked the run to end.
    pub fn interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    /// Returns whether the run ends, for whatever reason.
    pub fn stopped(&self) -> bool {
        self.progress.stop.load(Ordering::Relaxed)
    }

    /// Returns the picture in progress, for a progress bar.
    pub fn activity(&self) -> String {
        self.activity.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(super) fn set_activity(&self, activity: String) {
        *self.activity.lock().unwrap_or_else(PoisonError::into_inner) = activity;
    }

    /// Returns the points that are measured so far, in the order of their measurement. The frontier
    /// is not known yet.
    pub fn points(&self) -> Vec<Point> {
        self.points.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(super) fn add_point(&self, point: Point) {
        self.points.lock().unwrap_or_else(PoisonError::into_inner).push(point);
    }

    /// Does work, and sets the stop switch if the work lasts until `end`.
    pub fn until<T>(&self, end: Instant, work: impl FnOnce() -> T) -> T {
        let done = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let timer = scope.spawn(|| {
                while !done.load(Ordering::Relaxed) {
                    let left = end.saturating_duration_since(Instant::now());
                    if left == Duration::ZERO {
                        self.progress.stop.store(true, Ordering::Relaxed);
                        break;
                    }
                    std::thread::park_timeout(left);
                }
            });
            let result = work();
            done.store(true, Ordering::Relaxed);
            timer.thread().unpark();
            result
        })
    }
}
