//! Arguments of every command that opens a lens file.

use std::path::PathBuf;

use petzval_base::io::{FileLog, Outputs};
use petzval_lens::Zoom;
use petzval_lens_formats::LensOptions;
use petzval_render::prepare::settings;

use super::values::{typed, wavelengths};

/// Choices for a lens file.
#[derive(Clone, Debug, Default, clap::Args)]
pub(in crate::cli) struct LensFileArguments {
    /// Zoom setting: a focal length between those of the lens file, or the name or number of one of
    /// its states
    #[arg(long, value_name = "MM|STATE", value_parser = typed(settings::zoom), help_heading = "Lens")]
    pub zoom: Option<Zoom>,
    /// Wavelengths of the lens, nm, instead of those of its file; figures are for the middle one
    #[arg(long, value_name = "NM,...", value_parser = wavelengths, help_heading = "Lens")]
    pub wavelengths: Option<std::sync::Arc<[f64]>>,
    /// Glass catalogue for the lens
    ///
    /// An AGF file (Zemax), or a folder of them; may be repeated, and the first that has a glass
    /// gives it
    #[arg(long, value_name = "PATH", help_heading = "Lens")]
    pub catalogue: Vec<PathBuf>,
    /// Leave out terms of the lens file that are not simulated (gratings, graded indices), with a
    /// warning
    #[arg(long, help_heading = "Lens")]
    pub approximate: bool,
}

impl LensFileArguments {
    /// Returns the choices.
    pub fn options(&self) -> LensOptions {
        LensOptions {
            zoom: self.zoom.clone(),
            wavelengths: self.wavelengths.as_deref().unwrap_or_default().to_vec(),
            catalogues: self.catalogue.clone(),
            approximate: self.approximate,
        }
    }

    /// Returns the outputs of a command with these inputs. Catalogues are inputs even if no glass of
    /// them was needed.
    pub fn outputs(&self, inputs: &FileLog) -> Outputs {
        let mut catalogues = FileLog::default();
        for path in &self.catalogue {
            catalogues.add(path, None);
            let entries = std::fs::read_dir(path).into_iter().flatten().flatten();
            let files = entries.map(|entry| entry.path()).filter(|file| {
                file.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("agf"))
            });
            files.for_each(|file| catalogues.add(&file, None));
        }
        let outputs = Outputs::beside(inputs);
        outputs.protect(&catalogues);
        outputs
    }
}
