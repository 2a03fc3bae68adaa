//! Progress bars, on a terminal only.

use std::io::IsTerminal;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use petzval::accuracy::RunMonitor;
use petzval::film::Tile;
use petzval::job::Job;
use petzval::render::Progress;

use super::screen::is_quiet;

/// Time between two drawings of a bar.
const INTERVAL: Duration = Duration::from_millis(100);

/// Returns whether bars are drawn: on a terminal, unless --quiet is given.
fn is_shown() -> bool {
    !is_quiet() && std::io::stderr().is_terminal()
}

/// A bar that a thread of its own draws.
struct DrawnBar {
    bar: ProgressBar,
    done: Arc<AtomicBool>,
    watcher: JoinHandle<()>,
}

impl DrawnBar {
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
                std::thread::park_timeout(INTERVAL);
            }
        });
        Self { bar, done, watcher }
    }

    /// Removes the bar.
    fn finish(self) {
        self.done.store(true, Ordering::Relaxed);
        self.watcher.thread().unpark();
        // A failure to draw must not lose the picture.
        let _ = self.watcher.join();
        self.bar.finish_and_clear();
    }
}

/// Bar of a run with a time budget: elapsed time and current activity.
pub(super) struct TimeBar {
    shown: Option<DrawnBar>,
}

impl TimeBar {
    /// Shows the bar if stderr is a terminal.
    pub(super) fn start(begun: Instant, budget: Duration, monitor: Arc<RunMonitor>) -> Self {
        let all = budget.as_millis() as u64;
        let draw = move |bar: &ProgressBar| {
            bar.set_position((begun.elapsed().as_millis() as u64).min(all));
            bar.set_message(monitor.activity());
        };
        Self { shown: is_shown().then(|| DrawnBar::start(all, draw)) }
    }

    /// Removes the bar.
    pub(super) fn finish(self) {
        if let Some(shown) = self.shown {
            shown.finish();
        }
    }
}

/// Returns the film samples of a job, if their number ends it.
pub(super) fn film_samples(job: &Job) -> u64 {
    let count = |tile: &Tile| job.sampler(tile, job.samples.clone()).count();
    job.frame.tiles().iter().map(count).sum()
}

/// Bar of a render: completed samples, rate and remaining time.
pub(super) struct RenderBar {
    shown: Option<DrawnBar>,
}

impl RenderBar {
    /// Shows the bar if stderr is a terminal.
    pub(super) fn start(job: &Job, progress: Arc<Progress>) -> Self {
        if !is_shown() {
            return Self { shown: None };
        }
        let (most, uniform) = (film_samples(job), job.stop_criteria.count_only());
        let start = Instant::now();
        let earlier = progress.samples.load(Ordering::Relaxed);
        let shown = DrawnBar::start(most, move |bar| {
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
                // An adaptive render knows its total only after the pilot samples.
                let left = match expected > 0 || uniform {
                    true => format!(", {left:.0} s left"),
                    false => String::new(),
                };
                bar.set_message(format!("{:.1} M rays/s{left}", rate / 1e6));
            }
        });
        Self { shown: Some(shown) }
    }

    /// Removes the bar.
    pub(super) fn finish(self) {
        if let Some(shown) = self.shown {
            shown.finish();
        }
    }
}
