//! Errors of lens files and prescriptions.

use std::path::PathBuf;

use crate::io::path_excerpt;

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
