//! Accuracy against time of models of a lens.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;
use std::time::{Duration, Instant};

use petzval::{PrepareError, RenderError};
use petzval_tools::accuracy::{
    Budget, Ladder, LadderError, LadderRun, Point, RunMonitor, run_ladder,
};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::error::{prepare_error, render_error, value_error};
use crate::scene::Scene;
use crate::settings::Settings;
use crate::worker;

/// How often the run is asked whether Ctrl-C ends it.
const PULSE: Duration = Duration::from_millis(20);

/// Why models could not be compared.
enum Failure {
    Prepare(PrepareError),
    Run(LadderError),
}

/// Photographs a scene by models of its lens, from the pinhole to every surface in f64, each with more
/// and more samples, within `budget` seconds, and measures each picture against the richest model.
/// Returns a list of dictionaries, one for each picture.
#[pyfunction]
pub fn lens_models<'py>(
    py: Python<'py>,
    scene: &Scene,
    settings: Settings,
    budget: f64,
    samples: u32,
    progress: Option<Py<PyAny>>,
) -> PyResult<Bound<'py, PyList>> {
    let begun = Instant::now();
    if !(budget > 0.0 && budget <= 7.0 * 24.0 * 3600.0) {
        return Err(value_error(format!("budget={budget}: expected seconds, a week at most")));
    }
    let time = Duration::from_secs_f64(budget);
    let (description, changes) = (settings.describe(&scene.description), settings.changes);
    let (monitor, stop) = (RunMonitor::default(), AtomicBool::new(false));
    let pulse = |py: Python<'_>| {
        let share = (begun.elapsed().as_secs_f64() / budget).min(1.0);
        progress.as_ref().map_or(Ok(()), |call| call.call1(py, (share,)).map(|_| ()))
    };
    let work = || {
        let watched = || -> Result<(Ladder, LadderRun), Failure> {
            let ladder =
                monitor.until(begun + time, || Ladder::new(&description, &changes, &monitor));
            let mut ladder = ladder.map_err(Failure::Prepare)?;
            let budget = Budget { begun, time, samples };
            let run = run_ladder(&mut ladder, &budget, &monitor).map_err(Failure::Run)?;
            Ok((ladder, run))
        };
        let (done, wait) = mpsc::channel::<()>();
        std::thread::scope(|scope| {
            // Ctrl-C sets `stop`, of which the monitor does not know.
            let (stop, monitor) = (&stop, &monitor);
            scope.spawn(move || {
                while let Err(mpsc::RecvTimeoutError::Timeout) = wait.recv_timeout(PULSE) {
                    if stop.load(Ordering::Relaxed) {
                        monitor.interrupt();
                        break;
                    }
                }
            });
            // The sender is dropped with the work, also by a panic.
            let _done = done;
            watched()
        })
    };
    let over = || {
        PyRuntimeError::new_err(format!(
            "the budget of {budget} s was over before the first comparison; give a longer budget"
        ))
    };
    let (ladder, run) = match worker::run(py, &stop, pulse, work)? {
        Ok(run) => run,
        Err(Failure::Prepare(PrepareError::Pilot(RenderError::Stopped))) => return Err(over()),
        Err(Failure::Prepare(error)) => return Err(prepare_error(&error)),
        Err(Failure::Run(LadderError::Render(error))) => return Err(render_error(&error)),
        Err(Failure::Run(error)) => return Err(value_error(error)),
    };
    if run.points.is_empty() {
        return Err(over());
    }
    let rows = PyList::empty(py);
    for point in &run.points {
        rows.append(row(py, &ladder, point)?)?;
    }
    Ok(rows)
}

/// Returns the dictionary of a picture.
fn row<'py>(py: Python<'py>, ladder: &Ladder, point: &Point) -> PyResult<Bound<'py, PyDict>> {
    let rung = &ladder.rungs[point.rung];
    let row = PyDict::new(py);
    row.set_item("model", &rung.name)?;
    row.set_item("description", &rung.sentence)?;
    row.set_item("spp", point.samples)?;
    row.set_item("seconds", point.seconds)?;
    row.set_item("film_error", rung.film.rms_um)?;
    row.set_item("error", point.error.max(0.0).sqrt())?;
    row.set_item("noise", point.noise.max(0.0).sqrt())?;
    row.set_item("own_error", point.bias.map(|bias| bias.size()))?;
    row.set_item("own_error_at_most", point.bias.map(|bias| bias.at_most()))?;
    row.set_item("mse", point.mse)?;
    row.set_item("relmse", point.relmse)?;
    row.set_item("flip", point.flip)?;
    row.set_item("adds", rung.adds.map(|effect| effect.name()))?;
    row.set_item("best", point.on_frontier)?;
    Ok(row)
}
