//! The progress bar: on a terminal only.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use petzval::accuracy::Watch;
use petzval::render::{Job, Progress};

/// How often a bar is drawn.
const EVERY: Duration = Duration::from_millis(100);

/// A bar that a thread of its own draws, where anybody looks.
struct Shown {
    bar: ProgressBar,
    done: Arc<AtomicBool>,
    watcher: JoinHandle<()>,
}

impl Shown {
    fn start(length: u64, draw: impl Fn(&ProgressBar) + Send + 'static) -> Self {
        let bar = ProgressBar::new(length);
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {percent:>3}%  {msg}") {
            bar.set_style(style);
        }
        let done = Arc::new(AtomicBool::new(false));
        let (shown, ended) = (bar.clone(), done.clone());
        let watcher = std::thread::spawn(move || {
            while !ended.load(Ordering::Relaxed) {
                draw(&shown);
                std::thread::park_timeout(EVERY);
            }
        });
        Self { bar, done, watcher }
    }

    /// Takes the bar away.
    fn finish(self) {
        self.done.store(true, Ordering::Relaxed);
        self.watcher.thread().unpark();
        // A bar that failed to draw is no reason to lose the picture.
        let _ = self.watcher.join();
        self.bar.finish_and_clear();
    }
}

/// Watches a climb: how much of its time is over, and what it does.
pub(super) struct TimeBar {
    shown: Option<Shown>,
}

impl TimeBar {
    /// Begins to show how much of a budget is over, if anybody looks.
    pub(super) fn start(begun: Instant, budget: Duration, watch: Arc<Watch>) -> Self {
        let all = budget.as_millis() as u64;
        let draw = move |bar: &ProgressBar| {
            bar.set_position((begun.elapsed().as_millis() as u64).min(all));
            bar.set_message(watch.doing());
        };
        Self { shown: std::io::stderr().is_terminal().then(|| Shown::start(all, draw)) }
    }

    /// Takes the bar away.
    pub(super) fn finish(self) {
        if let Some(shown) = self.shown {
            shown.finish();
        }
    }
}

/// Watches a render.
pub(super) struct Bar {
    shown: Option<Shown>,
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
        let start = Instant::now();
        let earlier = progress.samples.load(Ordering::Relaxed);
        let shown = Shown::start(most, move |bar| {
            let samples = progress.samples.load(Ordering::Relaxed);
            let expected = progress.expected.load(Ordering::Relaxed);
            let total = if expected > 0 { expected } else { most };
            let seconds = start.elapsed().as_secs_f64();
            let own = samples.saturating_sub(earlier);
            let rate = own as f64 / seconds.max(1e-3);
            bar.set_length(total);
            bar.set_position(samples.min(total));
            if own > 0 {
                let left = (total.saturating_sub(samples)) as f64 / rate;
                // Nobody knows before the noise has been seen.
                let left = match expected > 0 || evenly {
                    true => format!(", {left:.0} s left"),
                    false => String::new(),
                };
                bar.set_message(format!("{:.1} M rays/s{left}", rate / 1e6));
            }
        });
        Self { shown: Some(shown) }
    }

    /// Takes the bar away.
    pub(super) fn finish(self) {
        if let Some(shown) = self.shown {
            shown.finish();
        }
    }
}
