//! Errors of glass: unreadable catalogues, and wavelengths outside the data.

use std::path::PathBuf;

use petzval_base::io::path_excerpt;

/// An error of a glass catalogue.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum GlassError {
    /// The file or folder could not be read.
    #[error("cannot read the glass catalogue {}: {source}", path_excerpt(path))]
    Io {
        /// Path of the file or folder.
        path: PathBuf,
        /// Error of the operating system.
        source: std::io::Error,
    },
    /// A line of the file is invalid.
    #[error("{}:{line}: {found}; {expected}", path_excerpt(path))]
    Malformed {
        /// Path of the file.
        path: PathBuf,
        /// Line, from 1.
        line: usize,
        /// Content of the line at fault.
        found: String,
        /// Expected content, or a remedy.
        expected: String,
    },
}

/// The index of a medium was asked for at a wavelength that its data do not cover.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error(
    "{}{glass} is known from {} to {} nm, not at {} nm; choose a wavelength in this range, or \
     state the medium by a glass or a table of indices that covers it",
    surface.map_or_else(String::new, |surface| format!("behind surface {surface}: ")),
    rounded(range[0]), rounded(range[1]), rounded(*wavelength)
)]
pub struct IndexRangeError {
    /// Number of the surface in front of the medium, from 1, if it is known.
    pub surface: Option<usize>,
    /// The medium: name of a glass, or description.
    pub glass: String,
    /// Shortest and longest wavelength of the data (nm).
    pub range: [f64; 2],
    /// The wavelength (nm).
    pub wavelength: f64,
}

/// Returns a wavelength to one decimal: two digits less than lines are stated with.
fn rounded(nm: f64) -> f64 {
    (nm * 10.0).round() / 10.0
}
