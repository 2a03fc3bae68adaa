//! Why a lens file was refused.

use std::path::PathBuf;

use crate::source::shown;

/// Why a lens file was refused.
#[derive(Debug, thiserror::Error)]
pub enum LensError {
    /// The file could not be opened or read.
    #[error("cannot read the lens {}: {source}", shown(path))]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A line is not what a lens file may hold.
    #[error("{}:{line}{}: {found}; {expected}", shown(path), behind(*column))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The column, from 1, in characters; of a file whose columns are keys and values.
        column: Option<usize>,
        /// What stands there.
        found: String,
        /// What was expected, or what to try.
        expected: String,
    },
}

/// What stands behind the line in an error.
fn behind(column: Option<usize>) -> String {
    column.map_or_else(String::new, |column| format!(":{column}"))
}
