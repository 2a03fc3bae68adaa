//! Progress bars, on a terminal only.

use std::io::IsTerminal;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use indicatif::{ProgressBar, ProgressStyle};
use petzval_render::Progress;
use petzval_render::film::Tile;
use petzval_render::job::Job;
use petzval_tools::accuracy::RunMonitor;

use super::screen::is_quiet;

/// Time between two drawings of a bar.
const INTERVAL: Duration = Duration::from_millis(100);

/// Time after which the bar of steps appears: commands that are done by then stay silent.
const PATIENCE: Duration = Duration::from_secs(1);

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
        Self::start_after(Duration::ZERO, length, draw)
    }

    /// Draws the bar from a time after now on.
    fn start_after(
        patience: Duration,
        length: u64,
        draw: impl Fn(&ProgressBar) + Send + 'static,
    ) -> Self {
        let bar = ProgressBar::new(length);
        if let Ok(style) = ProgressStyle::with_template("{wide_bar} {percent:>3}%  {msg}") {
            bar.set_style(style);
        }
        let done = Arc::new(AtomicBool::new(false));
        let (shown, ended) = (bar.clone(), done.clone());
        let begun = Instant::now();
        let watcher = std::thread::spawn(move || {
            while !ended.load(Ordering::Relaxed) {
                let early = patience.saturating_sub(begun.elapsed());
                if early > Duration::ZERO {
                    std::thread::park_timeout(early);
                    continue;
                }
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

/// Bar of an analysis: the step in progress, its time, and how many steps of how many are done. It
/// appears if the analysis takes more than a second, and ends with it.
pub(super) struct StepBar {
    state: Arc<StepState>,
    shown: Option<DrawnBar>,
}

/// Steps of an analysis, shared with the thread that draws.
#[derive(Default)]
struct StepState {
    step: Mutex<String>,
    done: AtomicU64,
    /// Number of steps; 0 if it is unknown.
    all: AtomicU64,
}

impl StepBar {
    /// Shows the bar if stderr is a terminal. `step` names what is computed.
    pub(super) fn start(step: &str) -> Self {
        let state = Arc::new(StepState::default());
        let (seen, begun) = (state.clone(), Instant::now());
        let draw = move |bar: &ProgressBar| {
            let all = seen.all.load(Ordering::Relaxed);
            bar.set_length(all.max(1));
            bar.set_position(seen.done.load(Ordering::Relaxed).min(all));
            let step = seen.step.lock().unwrap_or_else(PoisonError::into_inner).clone();
            bar.set_message(format!("{step}, {:.0} s", begun.elapsed().as_secs_f64()));
        };
        let shown = is_shown().then(|| DrawnBar::start_after(PATIENCE, 1, draw));
        let bar = Self { state, shown };
        bar.begin(step, 0);
        bar
    }

    /// Names what is computed now, and its number of steps; 0 if it is unknown.
    pub(super) fn begin(&self, step: &str, steps: usize) {
        step.clone_into(&mut self.state.step.lock().unwrap_or_else(PoisonError::into_inner));
        self.state.done.store(0, Ordering::Relaxed);
        self.state.all.store(steps as u64, Ordering::Relaxed);
    }

    /// Counts a step as done.
    pub(super) fn advance(&self) {
        self.state.done.fetch_add(1, Ordering::Relaxed);
    }
}

impl Drop for StepBar {
    /// Removes the bar.
    fn drop(&mut self) {
        if let Some(shown) = self.shown.take() {
            shown.finish();
        }
    }
}

/// Returns the film samples of a job, if their number ends it.
pub(super) fn film_samples(job: &Job) -> u64 {
    let count = |tile: &Tile| job.sampler(tile, job.samples.clone()).count();
    job.tiles().iter().map(count).sum()
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
