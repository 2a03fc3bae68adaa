//! The progress bar: on a terminal only.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use petzval::render::{Job, Progress};

/// Watches a render.
pub(super) struct Bar {
    shown: Option<(ProgressBar, Arc<AtomicBool>, JoinHandle<()>)>,
}

impl Bar {
    /// Begins to show how far a render has come, if anybody looks.
    pub(super) fn start(job: &Job, progress: Arc<Progress>) -> Self {
        if !std::io::stderr().is_terminal() {
            return Self { shown: None };
        }
        let tiles = job.frame.tiles();
        let count = |tile| job.sampler(tile, job.samples.clone()).count();
        let (most, evenly) = (tiles.iter().map(count).sum(), job.until.count_only());
        let bar = ProgressBar::new(most);
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {percent:>3}%  {msg}") {
            bar.set_style(style);
        }
        let done = Arc::new(AtomicBool::new(false));
        let (shown, ended) = (bar.clone(), done.clone());
        let start = Instant::now();
        let earlier = progress.samples.load(Ordering::Relaxed);
        let watcher = std::thread::spawn(move || {
            while !ended.load(Ordering::Relaxed) {
                let samples = progress.samples.load(Ordering::Relaxed);
                let expected = progress.expected.load(Ordering::Relaxed);
                let total = if expected > 0 { expected } else { most };
                let seconds = start.elapsed().as_secs_f64();
                let own = samples - earlier;
                let rate = own as f64 / seconds.max(1e-3);
                shown.set_length(total);
                shown.set_position(samples.min(total));
                if own > 0 {
                    let left = (total.saturating_sub(samples)) as f64 / rate;
                    // Nobody knows before the noise has been seen.
                    let left = match expected > 0 || evenly {
                        true => format!(", {left:.0} s left"),
                        false => String::new(),
                    };
                    shown.set_message(format!("{:.1} M rays/s{left}", rate / 1e6));
                }
                std::thread::park_timeout(Duration::from_millis(100));
            }
        });
        Self { shown: Some((bar, done, watcher)) }
    }

    /// Takes the bar away.
    pub(super) fn finish(self) {
        if let Some((bar, done, watcher)) = self.shown {
            done.store(true, Ordering::Relaxed);
            watcher.thread().unpark();
            // A bar that failed to draw is no reason to lose the picture.
            let _ = watcher.join();
            bar.finish_and_clear();
        }
    }
}
