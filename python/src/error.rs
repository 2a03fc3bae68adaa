//! Errors as Python exceptions.

use std::fmt::Display;
use std::io;
use std::path::Path;

use petzval::{ImageError, PrepareError, RenderError, SceneError, SceneErrors};
use petzval_base::io::ReadError;
use petzval_lens::LensError;
use petzval_render::checkpoint::CheckpointError;
use petzval_scene_formats::ply::PlyError;
use petzval_spectrum::GlassError;
use petzval_tools::dataset::DatasetError;
use pyo3::exceptions::{PyMemoryError, PyRuntimeError, PyRuntimeWarning, PyValueError};
use pyo3::prelude::*;

/// Returns the exception of a value that makes no sense.
pub fn value_error(problem: impl Display) -> PyErr {
    PyValueError::new_err(problem.to_string())
}

/// Issues a warning of Python.
///
/// # Errors
/// Returns the exception if a filter makes the warning an error.
pub fn warn(py: Python<'_>, message: &str) -> PyResult<()> {
    let text = std::ffi::CString::new(message.replace('\0', " ")).unwrap_or_default();
    PyErr::warn(py, &py.get_type::<PyRuntimeWarning>(), &text, 0)
}

/// Returns the subclass of `OSError` of an error of the system, with a message of ours. Errors that
/// come from the content of a file or from a memory limit are none of the system.
fn os_error(source: &io::Error, message: impl Display) -> PyErr {
    match source.kind() {
        io::ErrorKind::OutOfMemory => PyMemoryError::new_err(message.to_string()),
        io::ErrorKind::InvalidData | io::ErrorKind::InvalidInput | io::ErrorKind::UnexpectedEof => {
            value_error(message)
        }
        kind => io::Error::new(kind, message.to_string()).into(),
    }
}

/// Returns the exception of a file that cannot be read.
pub fn read_error(error: &ReadError) -> PyErr {
    os_error(&error.source, error)
}

/// Returns the exception of a lens that cannot be read or used.
pub fn lens_error(error: &LensError) -> PyErr {
    match error {
        LensError::Io { source, .. } | LensError::Glass(GlassError::Io { source, .. }) => {
            os_error(source, error)
        }
        _ => value_error(error),
    }
}

/// Returns the exception of a lens that was given as rows, which name themselves in place of the file
/// that holds them below a line of its own.
pub fn table_error(error: &LensError, file: &Path) -> PyErr {
    let text = error.to_string();
    let place = text.strip_prefix(&format!("{}:", file.display()));
    match place.and_then(|rest| rest.split_once(": ")) {
        Some((line, problem)) => match line.parse::<usize>().ok().and_then(|n| n.checked_sub(2)) {
            Some(row) => value_error(format!("rows[{row}]: {problem}")),
            None => value_error(format!("rows: {problem}")),
        },
        None => lens_error(error),
    }
}

/// Returns the exception of a scene that cannot be prepared.
pub fn prepare_error(error: &PrepareError) -> PyErr {
    match io_source(error) {
        Some(source) => os_error(source, error),
        None => value_error(error),
    }
}

/// Returns the error of the system if a lens file or a catalogue could not be read.
fn io_source(error: &PrepareError) -> Option<&io::Error> {
    match error {
        PrepareError::Lens(lens) | PrepareError::Unreadable { source: lens, .. } => match lens {
            LensError::Io { source, .. } | LensError::Glass(GlassError::Io { source, .. }) => {
                Some(source)
            }
            _ => None,
        },
        _ => None,
    }
}

/// Returns the exception of a scene that cannot be read: that of the system if a file is missing and
/// nothing else is wrong.
pub fn scene_error(errors: &SceneErrors) -> PyErr {
    match errors.faults() {
        [only] => match &only.error {
            SceneError::Unreadable(read) | SceneError::Include { source: read, .. } => {
                os_error(&read.source, errors)
            }
            SceneError::Image { source: ImageError::Io { source, .. }, .. } => {
                os_error(source, errors)
            }
            SceneError::Limit { .. } => PyMemoryError::new_err(errors.to_string()),
            // The reader of meshes keeps no more of an error of the system than its text.
            SceneError::Mesh { source: PlyError { path, .. }, .. } if !path.exists() => {
                os_error(&io::ErrorKind::NotFound.into(), errors)
            }
            _ => value_error(errors),
        },
        _ => value_error(errors),
    }
}

/// Returns the exception of a render that failed.
pub fn render_error(error: &RenderError) -> PyErr {
    match error {
        RenderError::Checkpoint(error) => checkpoint_error(error),
        _ => PyRuntimeError::new_err(error.to_string()),
    }
}

/// Returns the exception of a checkpoint that cannot be read.
pub fn checkpoint_error(error: &CheckpointError) -> PyErr {
    match error {
        CheckpointError::Io { source, .. } => os_error(source, error),
        _ => value_error(error),
    }
}

/// Returns the exception of a data set that cannot be made.
pub fn dataset_error(error: &DatasetError) -> PyErr {
    match error {
        DatasetError::Read(read) => read_error(read),
        DatasetError::Scene(errors) => scene_error(errors),
        DatasetError::Render(error) => render_error(error),
        DatasetError::Io { source, .. } => os_error(source, error),
        DatasetError::Image(error) => image_error(error),
        DatasetError::Prepare { source, .. } | DatasetError::OwnCamera { source, .. } => {
            match io_source(source) {
                Some(source) => os_error(source, error),
                None => value_error(error),
            }
        }
        _ => value_error(error),
    }
}

/// Returns the exception of a picture that cannot be written.
pub fn image_error(error: &ImageError) -> PyErr {
    match error {
        ImageError::Io { source, .. } => os_error(source, error),
        _ => value_error(error),
    }
}
