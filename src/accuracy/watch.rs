//! Watching a climb, and stopping it.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use crate::render::Progress;

/// How far a climb has come; shared with whoever watches it or stops it.
#[derive(Debug, Default)]
pub struct Watch {
    pub(super) progress: Progress,
    interrupted: AtomicBool,
    doing: Mutex<String>,
}

impl Watch {
    /// Ends the climb at the next wave; false where that was asked for before.
    pub fn interrupt(&self) -> bool {
        self.progress.stop.store(true, Ordering::Relaxed);
        !self.interrupted.swap(true, Ordering::Relaxed)
    }

    /// Whether somebody asked it to end.
    pub fn interrupted(&self) -> bool {
        self.interrupted.load(Ordering::Relaxed)
    }

    /// Whether it ends, for whatever reason.
    pub fn stopped(&self) -> bool {
        self.progress.stop.load(Ordering::Relaxed)
    }

    /// What it is rendering.
    pub fn doing(&self) -> String {
        self.doing.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    pub(super) fn does(&self, what: String) {
        *self.doing.lock().unwrap_or_else(PoisonError::into_inner) = what;
    }

    /// Does something that is stopped at this time, if it takes so long.
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
            let answer = work();
            done.store(true, Ordering::Relaxed);
            timer.thread().unpark();
            answer
        })
    }
}
