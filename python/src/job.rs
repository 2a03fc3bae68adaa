//! Jobs: scenes that are ready to be rendered.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::Ordering;

use petzval::{Picture, Prepared, Progress, RenderError, RenderOptions, RenderOutput};
use petzval_image::{ImageLayer, Note, Notes};
use petzval_render::{Convergence, render_resumable};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyList};

use crate::checkpoint::{self, JobInputs};
use crate::error::{prepare_error, render_error, value_error};
use crate::image::Image;
use crate::memory::{self, MemorySetting};
use crate::passes::Passes;
use crate::scene::Scene;
use crate::settings::Settings;
use crate::worker;

/// Checks a number of threads.
pub fn check_threads(threads: usize) -> PyResult<()> {
    match threads > 4096 {
        true => Err(value_error(format!("threads={threads}: expected 0 to 4096"))),
        false => Ok(()),
    }
}

/// A scene with lens, focus and plan of effects, ready to be rendered.
#[pyclass(frozen, module = "petzval")]
pub struct Job {
    pub(crate) job: Arc<petzval::Job>,
    notes: Notes,
    warnings: Vec<String>,
    inputs: JobInputs,
}

/// Prepares a scene: adds the lens, its focus and the plan of effects. Ctrl-C ends the wait at once; what was begun ends in the background.
#[pyfunction]
pub fn prepare(py: Python<'_>, scene: &Scene, settings: Settings) -> PyResult<Job> {
    let description = settings.describe(&scene.description);
    let Settings { changes, recorded, .. } = settings;
    let work = move || petzval::prepare(description, &changes);
    let prepared = worker::run_or_abandon(py, || (), work)?;
    let Prepared { job, notes, warnings } = prepared.map_err(|error| prepare_error(&error))?;
    let job = Arc::new(job);
    let warnings = warnings.iter().map(ToString::to_string).collect();
    let scene = scene.file().unwrap_or(Path::new("")).to_owned();
    let inputs = JobInputs { scene, settings: recorded };
    Ok(Job { job, notes, warnings, inputs })
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
        metadata(py, &self.notes)
    }

    /// Renders the picture, on `threads` threads; 0 is one for each core.
    ///
    /// `progress`, if given, is called some 20 times a second with the share of the samples that are
    /// done, from 0 to 1. Ctrl-C ends the render.
    ///
    /// `checkpoint` names a file for the state of the render: it is written every
    /// `checkpoint_interval` seconds and when the render is ended, and removed when the picture is
    /// finished. With `resume`, the render goes on from there, to the same picture bit for bit.
    /// `memory` is the most that the render may take (bytes, or a text such as "8GiB"): one that is
    /// expected to take more raises `MemoryError`.
    #[pyo3(signature = (
        threads = 0, progress = None, checkpoint = None, checkpoint_interval = 60.0, resume = false,
        memory = None
    ))]
    #[expect(clippy::too_many_arguments, reason = "they are keywords")]
    fn render(
        &self,
        py: Python<'_>,
        threads: usize,
        progress: Option<Py<PyAny>>,
        checkpoint: Option<PathBuf>,
        checkpoint_interval: f64,
        resume: bool,
        memory: Option<MemorySetting>,
    ) -> PyResult<Image> {
        check_threads(threads)?;
        if let Some(limit) = &memory {
            memory::check(&self.job, threads, limit)?;
        }
        let (checkpointer, saved) = match checkpoint {
            None if resume => return Err(value_error("resume=True: name the file by checkpoint")),
            None => (None, None),
            Some(path) => {
                let engine: PathBuf =
                    py.import("petzval._petzval")?.getattr("__file__")?.extract()?;
                let (job, inputs) = (&self.job, &self.inputs);
                let (checkpointer, saved) =
                    checkpoint::open(path, checkpoint_interval, resume, job, inputs, &engine)?;
                (Some(checkpointer), saved)
            }
        };
        let state = Progress::default();
        let earlier = saved.as_ref().map_or(0, |saved| saved.head.film_samples);
        state.samples.store(earlier, Ordering::Relaxed);
        let pulse = |py: Python<'_>| match &progress {
            Some(call) => call.call1(py, (self.share(&state),)).map(|_| ()),
            None => Ok(()),
        };
        let work = || {
            let options =
                RenderOptions { threads, progress: Some(&state), ..RenderOptions::default() };
            let output = render_resumable(&self.job, options, checkpointer.as_ref(), saved)?;
            if output.partial_mean_spp.is_some() {
                return Err(RenderError::Stopped);
            }
            let more = sample_notes(&output);
            let (picture, layers) = output.into_picture_with_layers(&self.job);
            Ok((picture, layers, more))
        };
        let rendered = worker::run(py, &state.stop, pulse, work)?;
        let (picture, layers, more) = rendered.map_err(|error| render_error(&error))?;
        checkpointer.iter().for_each(checkpoint::clear);
        if let Some(call) = &progress {
            call.call1(py, (1.0,))?;
        }
        self.image(py, &picture, layers, more)
    }

    /// Renders step by step: an iterator over pictures of 1, 2, 4, 8 ... samples a pixel, without
    /// layers and diffraction.
    #[pyo3(signature = (threads = 0))]
    fn passes(slf: Bound<'_, Self>, threads: usize) -> PyResult<Passes> {
        check_threads(threads)?;
        Passes::new(slf.unbind(), threads)
    }
}

impl Job {
    /// Makes the image of a picture. `more` are notes besides those of the job.
    pub fn image(
        &self,
        py: Python<'_>,
        picture: &Picture,
        mut layers: Vec<ImageLayer>,
        more: Notes,
    ) -> PyResult<Image> {
        let mut notes = self.notes.clone();
        notes.retain(|(name, _)| more.iter().all(|(other, _)| other != name));
        notes.extend(more);
        notes.extend(layers.iter_mut().flat_map(|layer| std::mem::take(&mut layer.notes)));
        let metadata = metadata(py, &notes)?.unbind();
        let (window, inputs) = (self.job.frame.window(), self.job.files.clone());
        let raw = self.job.raw_format();
        Image::new(py, picture, raw, layers, metadata, notes, window, inputs)
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

fn metadata<'py>(py: Python<'py>, notes: &Notes) -> PyResult<Bound<'py, PyDict>> {
    let data = PyDict::new(py);
    for (name, note) in notes {
        match note {
            Note::Text(text) => data.set_item(name, text)?,
            Note::Number(number) => data.set_item(name, number)?,
        }
    }
    Ok(data)
}

/// Returns notes on the noise, and on samples that were dropped.
fn sample_notes(output: &RenderOutput) -> Notes {
    let dropped = Some(output.film.dropped.count()).filter(|&count| count > 0);
    let dropped = dropped.map(|count| ("droppedSamples", Note::Number(count as f64)));
    output.convergence.iter().flat_map(Convergence::notes).chain(dropped).collect()
}
