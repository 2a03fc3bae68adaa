//! Checkpoints of a render: where it resumes from, and what it leaves.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use petzval_base::io::{FileLog, OutputFile};
use petzval_render::checkpoint::{CheckpointError, Head, Inputs, SavedRender};
use petzval_render::{CheckpointNotice, Checkpointer, RenderStart, ResumeError};
use pyo3::exceptions::PyOSError;
use pyo3::prelude::*;

use crate::error::{checkpoint_error, value_error, warn};

/// What determines the samples of a job, as far as Python knows it.
#[derive(Clone, Debug, Default)]
pub struct JobInputs {
    /// The scene file; empty if there is none.
    pub scene: PathBuf,
    /// The settings that were given, by name.
    pub settings: BTreeMap<String, String>,
}

impl JobInputs {
    /// Returns everything that determines the samples of a job.
    fn of(&self, job: &petzval::Job) -> Result<Inputs, String> {
        let samples = job.samples.len() as u32;
        let inputs = Inputs::of_job(&self.scene, job, samples, self.settings.clone());
        inputs.map_err(|error| error.to_string())
    }
}

/// Opens the checkpoint of a job, and returns the state to resume from if that is asked for and there
/// is one. `engine` is the file of this module.
pub fn open(
    path: PathBuf,
    interval: f64,
    resume: bool,
    job: &petzval::Job,
    inputs: &JobInputs,
    engine: &Path,
) -> PyResult<(Checkpointer, Option<SavedRender>)> {
    if !(interval > 0.0 && interval < 1e9) {
        return Err(value_error(format!(
            "checkpoint_interval={interval}: expected seconds above 0"
        )));
    }
    let failed = |source| CheckpointError::Io { verb: "write", path: path.clone(), source };
    petzval_base::io::check_writable(&path).map_err(|source| checkpoint_error(&failed(source)))?;
    let path = OutputFile::new(&path, &job.files).map_err(value_error)?;
    let mut inputs = inputs.of(job).map_err(PyOSError::new_err)?;
    // The program's own file is that of the interpreter.
    inputs.build = digest(engine);
    let head = Head {
        command_line: vec!["petzval.render".to_owned()],
        inputs,
        total_samples: job.samples.len() as u32,
        samples: job.samples.clone(),
        ..Head::default()
    };
    let mut checkpointer = Checkpointer {
        path,
        interval: Some(Duration::from_secs_f64(interval)),
        part_path: None,
        head,
        existing_samples: 0,
        on_error: |error| {
            // A filter may make it an error, which has nowhere to go.
            let _ = Python::attach(|py| warn(py, &format!("{error}; the render continues")));
        },
    };
    let start = checkpointer.start(resume).map_err(|error| match &error {
        ResumeError::Checkpoint(error) => checkpoint_error(error),
        other => value_error(other),
    })?;
    match start {
        RenderStart::Resumed(saved) => return Ok((checkpointer, Some(*saved))),
        // A loop asks for a resume each time.
        RenderStart::New(None | Some(CheckpointNotice::Missing { .. })) => {}
        RenderStart::New(Some(notice)) => {
            Python::attach(|py| warn(py, &notice.to_string()))?;
        }
        _ => {}
    }
    Ok((checkpointer, None))
}

/// Removes the checkpoint of a finished render.
pub fn clear(checkpointer: &Checkpointer) {
    if checkpointer.is_saved() {
        // A file that cannot be removed is harmless.
        let _ = checkpointer.path.remove();
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
