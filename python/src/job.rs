//! Jobs: scenes that are ready to be rendered.

use std::sync::Mutex;
use std::sync::atomic::Ordering;
use std::sync::mpsc;
use std::time::Duration;

use petzval::io::image::{ImageLayer, Note, Notes};
use petzval::{Picture, Progress, RenderOptions, render};
use pyo3::exceptions::PyRuntimeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::error::{prepare_error, value_error};
use crate::image::Image;
use crate::scene::Scene;
use crate::settings::Settings;

/// How often a render looks for Ctrl-C and reports its progress.
const PULSE: Duration = Duration::from_millis(50);
/// Stack of the thread that renders: that of a program's main thread.
const STACK: usize = 8 << 20;

/// A scene with lens, focus and plan of effects, ready to be rendered.
#[pyclass(frozen, module = "petzval")]
pub struct Job {
    job: petzval::Job,
    notes: Notes,
    warnings: Vec<String>,
}

/// Prepares a scene: adds the lens, its focus and the plan of effects.
#[pyfunction]
pub fn prepare(py: Python<'_>, scene: &Scene, settings: Settings<'_>) -> PyResult<Job> {
    let changes = settings.changes()?;
    let description = scene.description.clone();
    let prepared = py.detach(|| petzval::prepare(description, &changes));
    let (job, notes, warnings) = prepared.map_err(|error| prepare_error(&error))?;
    Ok(Job { job, notes, warnings: warnings.iter().map(ToString::to_string).collect() })
}

/// Result of the thread that renders.
struct Rendered {
    picture: Picture,
    layers: Vec<ImageLayer>,
}

#[pymethods]
impl Job {
    /// The decisions about effects: a list of dictionaries with effect, on, by and reason.
    #[getter]
    fn plan<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyList>> {
        let decisions = PyList::empty(py);
        for decision in &self.job.plan.effects {
            let row = PyDict::new(py);
            row.set_item("effect", decision.effect.name())?;
            row.set_item("on", decision.on)?;
            row.set_item("by", decision.by.name())?;
            row.set_item("reason", &decision.reason)?;
            decisions.append(row)?;
        }
        Ok(decisions)
    }

    /// Whether light paths from lamps and caustics are traced, and why.
    #[getter]
    fn light_paths(&self) -> String {
        self.job.plan.light_paths.to_string()
    }

    /// What was doubtful in the scene or the lens.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.warnings.clone()
    }

    /// Data of the picture: lens, focus, exposure and the like, by name.
    #[getter]
    fn metadata<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyDict>> {
        let data = PyDict::new(py);
        for (name, note) in &self.notes {
            match note {
                Note::Text(text) => data.set_item(name, text)?,
                Note::Number(number) => data.set_item(name, number)?,
                _ => {}
            }
        }
        Ok(data)
    }

    /// Renders the picture, on `threads` threads; 0 is one for each core.
    ///
    /// `progress`, if given, is called some 20 times a second with the share of the samples that are
    /// done, from 0 to 1. Ctrl-C ends the render.
    #[pyo3(signature = (threads = 0, progress = None))]
    fn render(
        &self,
        py: Python<'_>,
        threads: usize,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Image> {
        if threads > 4096 {
            return Err(value_error(format!("threads={threads}: expected 0 to 4096")));
        }
        let state = Progress::default();
        let interrupt: Mutex<Option<PyErr>> = Mutex::new(None);
        let rendered = py.detach(|| {
            self.run(threads, &state, || {
                let outcome = Python::attach(|py| {
                    py.check_signals()?;
                    match &progress {
                        Some(call) => call.call1(py, (self.share(&state),)).map(|_| ()),
                        None => Ok(()),
                    }
                });
                if let Err(error) = outcome {
                    state.stop.store(true, Ordering::Relaxed);
                    interrupt
                        .lock()
                        .unwrap_or_else(|poisoned| poisoned.into_inner())
                        .get_or_insert(error);
                }
            })
        });
        if let Some(error) = interrupt.into_inner().unwrap_or_else(|poisoned| poisoned.into_inner())
        {
            return Err(error);
        }
        let Rendered { picture, layers } = rendered?;
        if let Some(call) = &progress {
            call.call1(py, (1.0,))?;
        }
        let window = self.job.frame.window();
        let metadata = self.metadata(py)?.unbind();
        Image::new(py, &picture, layers, metadata, self.notes.clone(), window)
    }
}

impl Job {
    /// Renders on a thread of its own, and calls `pulse` now and then until that has ended.
    fn run(&self, threads: usize, state: &Progress, pulse: impl Fn()) -> PyResult<Rendered> {
        let (done, wait) = mpsc::channel::<()>();
        std::thread::scope(|scope| {
            let work = || {
                // The sender is dropped with the thread, also by a panic.
                let _done = done;
                let options =
                    RenderOptions { threads, progress: Some(state), ..RenderOptions::default() };
                let output = render(&self.job, options)?;
                let layers = output.layers(&self.job);
                Ok::<_, petzval::RenderError>(Rendered {
                    picture: output.into_picture(&self.job),
                    layers,
                })
            };
            let worker = std::thread::Builder::new().stack_size(STACK).spawn_scoped(scope, work)?;
            while let Err(mpsc::RecvTimeoutError::Timeout) = wait.recv_timeout(PULSE) {
                pulse();
            }
            match worker.join() {
                Ok(rendered) => {
                    rendered.map_err(|error| PyRuntimeError::new_err(error.to_string()))
                }
                Err(_) => Err(PyRuntimeError::new_err(
                    "the render failed: an error in petzval; please report it",
                )),
            }
        })
    }

    /// Returns the share of the samples that are taken.
    fn share(&self, state: &Progress) -> f64 {
        let frame = &self.job.frame;
        let pixels: u64 = (0..2).map(|i| u64::from(frame.high[i] - frame.low[i])).product();
        let of_job = pixels * u64::from(self.job.samples.end - self.job.samples.start);
        let expected = match state.expected.load(Ordering::Relaxed) {
            0 => of_job,
            expected => expected,
        };
        (state.samples.load(Ordering::Relaxed) as f64 / expected.max(1) as f64).min(1.0)
    }
}
