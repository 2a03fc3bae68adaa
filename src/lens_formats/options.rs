//! Choices of the user for a lens file: zoom setting, wavelengths, approximations.

use std::path::{Path, PathBuf};

use petzval_base::io::ReadContext;
use petzval_lens::{LensError, Prescription, Zoom};

use crate::read_at;

/// Choices for a lens file. The default takes all from the file.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LensOptions {
    /// Zoom setting, instead of the first of the file.
    pub zoom: Option<Zoom>,
    /// Wavelengths (nm), instead of those of the file; the middle one is the primary one.
    pub wavelengths: Vec<f64>,
    /// Glass catalogues: AGF files, or folders of them.
    pub catalogues: Vec<PathBuf>,
    /// Whether terms that are not simulated are left out with a note.
    pub approximate: bool,
}

impl LensOptions {
    /// Reads a lens. What was assumed or left out stands in the notes of its design.
    ///
    /// # Errors
    /// Returns an error if the file is not a lens, or has no such zoom setting.
    pub fn read(&self, path: &Path, context: &ReadContext) -> Result<Prescription, LensError> {
        let context = context
            .clone()
            .approximating(self.approximate)
            .with_catalogues(self.catalogues.iter().cloned());
        let mut lens = read_at(path, &self.wavelengths, &context)?;
        if let Some(zoom) = &self.zoom {
            let (zoomed, note) = lens
                .at_zoom(zoom)
                .map_err(|source| LensError::Zoom { path: path.to_owned(), source })?;
            lens = zoomed;
            lens.design.notes.extend(note);
        }
        Ok(lens)
    }
}
