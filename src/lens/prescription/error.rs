//! Errors of lens files and prescriptions.

use std::path::PathBuf;

use super::configuration::ZoomError;
use petzval_base::io::path_excerpt;
use petzval_spectrum::{GlassError, IndexRangeError};

/// An error of a lens file or a prescription.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum LensError {
    /// The file could not be opened or read.
    #[error("cannot read the lens {}: {source}", path_excerpt(path))]
    Io {
        /// Path of the file.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A line of the file is invalid.
    #[error("{}:{line}{}: {found}; {expected}", path_excerpt(path), column_suffix(*column))]
    Malformed {
        /// Path of the file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Column, from 1, in characters; none in `.dat` tables.
        column: Option<usize>,
        /// Content of the line at fault.
        found: String,
        /// Expected content, or a remedy.
        expected: String,
    },
    /// The lens has no such zoom setting.
    #[error("'zoom': {}: {source}", path_excerpt(path))]
    Zoom {
        /// Path of the file.
        path: PathBuf,
        /// Setting that is asked for, and those of the file.
        source: ZoomError,
    },
    /// A medium has no index at a wavelength in use.
    #[error("{}: {source}; 'wavelengths' chooses others", path_excerpt(path))]
    Wavelength {
        /// Path of the file.
        path: PathBuf,
        /// Medium, and the range of its data.
        source: IndexRangeError,
    },
    /// A format cannot hold the lens.
    #[error("{}: {found}; {expected}", path_excerpt(path))]
    Unwritable {
        /// Path of the file to write.
        path: PathBuf,
        /// Property of the lens that the format does not have.
        found: String,
        /// Remedy.
        expected: String,
    },
    /// A glass catalogue cannot be read.
    #[error(transparent)]
    Glass(#[from] GlassError),
    /// A prescription has no rows.
    #[error("the lens has no surface; expected at least one row")]
    NoSurface,
    /// A prescription has no stop, or more than one.
    #[error("the lens has {0} stops; expected exactly one row with stop = true")]
    StopCount(usize),
}

/// Returns the part of a message that names the column.
fn column_suffix(column: Option<usize>) -> String {
    column.map_or_else(String::new, |column| format!(":{column}"))
}
