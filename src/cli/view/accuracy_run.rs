//! Accuracy run: measures the error of the camera models against time, as `petzval accuracy` does,
//! while the page draws it.

use std::sync::Arc;
use std::sync::atomic::Ordering;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::thread;
use std::time::{Duration, Instant};

use petzval_scene_formats::pbrt::Description;
use petzval_tools::accuracy::{
    Budget, Ladder, LadderRun, Machine, Point, RunEnd, RunMonitor, run_ladder,
};
use serde_json::{Map, Value, json};

use super::background::Background;
use super::settings::ViewSettings;
use super::state::ViewState;
use crate::cli::Failure;
use crate::cli::accuracy::DEFAULT_SAMPLES;
use petzval_report::accuracy::AccuracyReport;

/// Time between two reports of the progress.
const INTERVAL: Duration = Duration::from_millis(100);
/// Shortest and longest budget of a page (s).
const BUDGETS: [f64; 2] = [2.0, 3600.0];

/// Pauses the refinement of the view while it exists.
struct Paused<'a>(&'a ViewState);

impl<'a> Paused<'a> {
    fn new(state: &'a ViewState) -> Self {
        state.refining_paused.store(true, Ordering::Relaxed);
        Self(state)
    }
}

impl Drop for Paused<'_> {
    fn drop(&mut self) {
        self.0.refining_paused.store(false, Ordering::Relaxed);
    }
}

/// Measures pictures.
pub(super) struct AccuracyRun {
    pub description: Description,
    pub state: Arc<ViewState>,
    pub background: Arc<Background>,
}

impl AccuracyRun {
    /// Starts to measure the picture of these settings, for a time (s).
    ///
    /// # Errors
    /// Returns a message if the time is refused, or other work is in progress.
    pub fn start(&self, seconds: f64, settings: &ViewSettings) -> Result<(), String> {
        let [least, most] = BUDGETS;
        if !(least..=most).contains(&seconds) {
            return Err(format!("a budget of {seconds} s: expected {least} to {most} s"));
        }
        let changes = settings.changes()?;
        let budget = Budget {
            begun: Instant::now(),
            time: Duration::from_secs_f64(seconds),
            samples: changes.samples.unwrap_or(DEFAULT_SAMPLES),
        };
        let monitor = Arc::new(RunMonitor::default());
        let (description, state) = (self.description.clone(), self.state.clone());
        let stop = monitor.clone();
        let work = move || {
            let _paused = Paused::new(&state);
            let result = (|| {
                let new = || Ladder::new(&description, &changes, &monitor);
                let ladder = monitor.until(budget.begun + budget.time, new)?;
                measure(ladder, &budget, &monitor, &state)
            })();
            result.unwrap_or_else(|failure| {
                let status = if monitor.interrupted() { "cancelled" } else { "failed" };
                message(status, Map::from_iter([("problem".into(), json!(failure.to_string()))]))
            })
        };
        self.background.start(
            move || {
                stop.interrupt();
            },
            work,
        )
    }
}

fn message(status: &str, more: Map<String, Value>) -> Value {
    let mut message = json!({ "type": "accuracy", "status": status });
    if let Some(message) = message.as_object_mut() {
        message.extend(more);
    }
    message
}

/// Measures a ladder, and tells the clients about it. Returns the last message.
fn measure(
    mut ladder: Ladder,
    budget: &Budget,
    monitor: &RunMonitor,
    state: &ViewState,
) -> Result<Value, Failure> {
    let names: Vec<String> = ladder.rungs.iter().map(|rung| rung.name.clone()).collect();
    let progress = |points: &[Point]| {
        let mut message = Map::new();
        message.insert("models".into(), json!(names));
        message.insert("points".into(), points.iter().map(point_json).collect());
        message.insert("seconds".into(), json!(budget.begun.elapsed().as_secs_f64()));
        message.insert("budget".into(), json!(budget.time.as_secs_f64()));
        message
    };
    let (ended, end) = channel::<()>();
    let run = thread::scope(|scope| {
        // The reports end when this one is dropped.
        let _ended = ended;
        scope.spawn(move || {
            while end.recv_timeout(INTERVAL) == Err(RecvTimeoutError::Timeout) {
                let mut running = progress(&monitor.points());
                running.insert("activity".into(), json!(monitor.activity()));
                state.publish_work(&message("running", running));
            }
        });
        run_ladder(&mut ladder, budget, monitor)
    })?;
    let mut points = progress(&run.points);
    let status = if run.end == RunEnd::Interrupted { "cancelled" } else { "finished" };
    points.extend(verdicts(&ladder, &run, budget));
    Ok(message(status, points))
}

fn point_json(point: &Point) -> Value {
    json!({
        "model": point.rung,
        "samples": point.samples,
        "seconds": point.seconds,
        "error": 100.0 * point.error.max(0.0).sqrt(),
        "best": point.on_frontier,
    })
}

/// Returns the verdicts on the models, and the recommendation.
fn verdicts(ladder: &Ladder, run: &LadderRun, budget: &Budget) -> Map<String, Value> {
    let report = AccuracyReport {
        scene: String::new(),
        command: String::new(),
        ladder,
        run,
        budget: budget.time,
        machine: Machine::this(),
    };
    let one = |verdict: &petzval_report::accuracy::Verdict| json!({ "model": verdict.rung, "sentence": verdict.sentence });
    let verdicts: Value = report.verdicts().iter().map(one).collect();
    Map::from_iter([
        ("verdicts".into(), verdicts),
        ("recommendation".into(), json!(report.recommendation())),
        ("partial".into(), json!(report.partial())),
    ])
}
