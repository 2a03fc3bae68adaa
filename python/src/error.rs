//! Errors as Python exceptions.

use std::fmt::Display;
use std::io;
use std::path::Path;

use petzval::lens::LensError;
use petzval::{ImageError, PrepareError};
use pyo3::PyErr;
use pyo3::exceptions::PyValueError;

/// Returns the exception of a value that makes no sense.
pub fn value_error(problem: impl Display) -> PyErr {
    PyValueError::new_err(problem.to_string())
}

/// Returns the subclass of `OSError` of an error of the system, with a message of ours.
fn os_error(source: &io::Error, message: impl Display) -> PyErr {
    io::Error::new(source.kind(), message.to_string()).into()
}

/// Returns the exception of a lens that cannot be read or used.
pub fn lens_error(error: &LensError) -> PyErr {
    match error {
        LensError::Io { source, .. } => os_error(source, error),
        _ => value_error(error),
    }
}

/// Returns the exception of a scene that cannot be prepared.
pub fn prepare_error(error: &PrepareError) -> PyErr {
    match error {
        PrepareError::Lens(lens @ LensError::Io { .. }) => lens_error(lens),
        PrepareError::Unreadable { source: LensError::Io { source, .. }, .. } => {
            os_error(source, error)
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

/// Checks that a file can be opened: the reader of scenes reports all its problems as text.
pub fn check_readable(path: &Path) -> Result<(), PyErr> {
    let opened = std::fs::File::open(path);
    opened.map(|_| ()).map_err(|source| {
        os_error(&source, format!("cannot read the scene {}: {source}", path.display()))
    })
}
