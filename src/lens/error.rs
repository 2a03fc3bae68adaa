//! Why a lens file was refused.

use std::path::PathBuf;

/// Why a lens file was refused.
#[derive(Debug, thiserror::Error)]
pub enum LensError {
    /// The file could not be opened or read.
    #[error("cannot read the lens {}: {source}", path.display())]
    Io {
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: std::io::Error,
    },
    /// A line is not what a lens file may hold.
    #[error("{}:{line}: {found}; {expected}", path.display())]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// What stands there.
        found: String,
        /// What was expected, or what to try.
        expected: String,
    },
}
