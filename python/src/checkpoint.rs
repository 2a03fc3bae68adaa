//! Checkpoints of a render: where it resumes from, and what it leaves.

use std::collections::BTreeMap;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;

use petzval_base::io::{FileLog, OutputFile};
use petzval_render::Checkpointer;
use petzval_render::checkpoint::{CheckpointError, Head, Inputs, SavedRender};
use pyo3::exceptions::{PyOSError, PyRuntimeWarning};
use pyo3::prelude::*;

use crate::error::{checkpoint_error, value_error};

/// Name of the file of a lens that was given as a table, which has another name in each process.
const TABLE: &str = "petzval-lens-";

/// What determines the samples of a job, as far as Python knows it.
#[derive(Clone, Debug, Default)]
pub struct JobInputs {
    /// The scene file.
    pub scene: PathBuf,
    /// The settings that were given, by name.
    pub settings: BTreeMap<String, String>,
}

impl JobInputs {
    /// Returns everything that determines the samples of a job.
    fn of(&self, job: &petzval::Job) -> Result<Inputs, String> {
        let mut options = self.settings.clone();
        let mut set = |name: &str, value: String| options.insert(name.to_owned(), value);
        let frame = &job.frame;
        set("the number of samples", job.samples.len().to_string());
        set("the seed", job.seed.to_string());
        set("the resolution", format!("{}x{}", frame.resolution[0], frame.resolution[1]));
        let [[x0, y0], [x1, y1]] = [frame.low, frame.high];
        set("the rendered part", format!("{x0},{y0},{x1},{y1}"));
        set("the list of layers", format!("{:?}", job.layers).to_lowercase());
        let inputs = Inputs::of(&self.scene, job.files.clone(), options);
        let mut inputs = inputs.map_err(|error| error.to_string())?;
        let named = |(name, digest): (String, String)| match name.starts_with(TABLE) {
            true => ("the lens".to_owned(), digest),
            false => (name, digest),
        };
        inputs.files = std::mem::take(&mut inputs.files).into_iter().map(named).collect();
        Ok(inputs)
    }
}

/// The checkpoint of a render.
pub struct Checkpoint {
    pub checkpointer: Checkpointer,
}

impl Checkpoint {
    /// Opens the checkpoint of a job, and returns the state to resume from if that is asked for and
    /// there is one. `engine` is the file of this module.
    pub fn open(
        path: PathBuf,
        interval: f64,
        resume: bool,
        job: &petzval::Job,
        inputs: &JobInputs,
        engine: &Path,
    ) -> PyResult<(Self, Option<SavedRender>)> {
        if !(interval > 0.0 && interval < 1e9) {
            return Err(value_error(format!(
                "checkpoint_interval={interval}: expected seconds above 0"
            )));
        }
        let failed = |source| CheckpointError::Io { verb: "write", path: path.clone(), source };
        petzval_base::io::check_writable(&path)
            .map_err(|source| checkpoint_error(&failed(source)))?;
        let path = OutputFile::new(&path, &job.files).map_err(value_error)?;
        let mut inputs = inputs.of(job).map_err(PyOSError::new_err)?;
        // The program's own file is that of the interpreter.
        inputs.build = digest(engine);
        let samples = job.samples.clone();
        let head = Head {
            command_line: vec!["petzval.render".to_owned()],
            inputs,
            total_samples: samples.end - samples.start,
            samples,
            ..Head::default()
        };
        let mut checkpoint = Self {
            checkpointer: Checkpointer {
                path,
                interval: Some(Duration::from_secs_f64(interval)),
                part_path: None,
                head,
                existing_samples: 0,
                on_error: warn,
            },
        };
        let saved = checkpoint.saved(resume)?;
        Ok((checkpoint, saved))
    }

    fn saved(&mut self, resume: bool) -> PyResult<Option<SavedRender>> {
        let path = &self.checkpointer.path;
        let found = match SavedRender::open(path.path()) {
            Err(CheckpointError::Io { source, .. }) if source.kind() == io::ErrorKind::NotFound => {
                return Ok(None);
            }
            // It is replaced.
            Err(_) if !resume => return Ok(None),
            found => found.map_err(|error| checkpoint_error(&error))?,
        };
        let changes = self.changes(&found.head);
        match (changes.is_empty() && !found.head.complete, resume) {
            (true, true) => Ok(Some(found)),
            (true, false) => {
                // A checkpoint with more samples stays until this render has as many.
                self.checkpointer.existing_samples = found.head.film_samples;
                Ok(None)
            }
            (false, true) => {
                let path = path.display();
                let changes = match changes.is_empty() {
                    true => "it is a finished part of a picture".to_owned(),
                    false => changes.join("; "),
                };
                let advice = "without resume=True the render starts again";
                Err(value_error(format!("cannot resume from {path}: {changes}; {advice}")))
            }
            (false, false) => Ok(None),
        }
    }

    fn changes(&self, head: &Head) -> Vec<String> {
        let own = &self.checkpointer.head;
        let mut changes = head.inputs.differences(&own.inputs);
        if head.samples != own.samples {
            changes.push("its samples are others".to_owned());
        }
        changes
    }

    /// Removes the checkpoint of a finished render.
    pub fn clear(&self) {
        let path = &self.checkpointer.path;
        let own = |saved: SavedRender| self.changes(&saved.head).is_empty();
        if SavedRender::open(path.path()).is_ok_and(own) {
            // A file that cannot be removed is harmless.
            let _ = path.remove();
        }
    }
}

/// Returns the digest of a file; empty if it cannot be read.
fn digest(path: &Path) -> String {
    let mut files = FileLog::default();
    files.add(path, None);
    let read = files.fill_digests().is_ok();
    let digest = files.iter().next().and_then(|(_, digest)| digest);
    if read { digest.unwrap_or_default().to_owned() } else { String::new() }
}

/// Warns that a checkpoint could not be written.
fn warn(error: &CheckpointError) {
    let text = std::ffi::CString::new(format!("{error}; the render continues").replace('\0', " "));
    let Ok(text) = text else { return };
    Python::attach(|py| {
        let category = py.get_type::<PyRuntimeWarning>();
        // A filter may make it an error, which has nowhere to go.
        let _ = PyErr::warn(py, &category, &text, 0);
    });
}
