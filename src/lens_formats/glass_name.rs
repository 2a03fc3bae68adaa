//! Glasses of lens files by name, code or figures.

use std::collections::HashMap;

use super::report::ReadReport;
use super::text::Line;
use petzval_base::io::excerpt;
use petzval_lens::LensError;
use petzval_lens::system::MediumBehind;
use petzval_spectrum::Glass;

/// Figures that a file states beside the name of a glass.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ModelFigures {
    /// Index at the d line.
    pub nd: f64,
    /// Abbe number; 0 for a constant index.
    pub vd: f64,
    /// Deviation of the partial dispersion PgF.
    pub dpgf: f64,
}

impl ModelFigures {
    /// Returns the model glass.
    pub fn medium(self) -> MediumBehind {
        match (2.0..=1000.0).contains(&self.vd) {
            true => MediumBehind::Glass(Glass::model(self.nd, self.vd, self.dpgf)),
            false => MediumBehind::Index(self.nd),
        }
    }
}

/// Glasses that a file may name.
#[derive(Default)]
pub(crate) struct GlassNames {
    makers: Vec<String>,
    private: HashMap<String, Glass>,
}

impl GlassNames {
    /// Sets the preferred makers, the first one before all others.
    pub fn prefer<'a>(&mut self, makers: impl Iterator<Item = &'a str>) {
        self.makers = makers.map(str::to_owned).collect();
    }

    /// Adds a glass of the file itself.
    pub fn define(&mut self, name: &str, glass: Glass) {
        self.private.insert(name.to_uppercase(), glass);
    }

    /// Returns the glass of a name or a code.
    ///
    /// # Errors
    /// Returns an error with a suggestion if it is not known and the reader may not replace it by
    /// the figures beside it, or if a catalogue of the user cannot be read.
    pub fn resolve(
        &self,
        line: &Line,
        word: &str,
        figures: Option<ModelFigures>,
        report: &mut ReadReport,
    ) -> Result<MediumBehind, LensError> {
        let name = word.trim_matches(['\'', '"']);
        if let Some(glass) = self.private.get(&name.to_uppercase()) {
            return Ok(MediumBehind::Glass(glass.clone()));
        }
        let makers: Vec<&str> = self.makers.iter().map(String::as_str).collect();
        let library = report.glasses()?.clone();
        if let Some(fault) = library.fault(name) {
            let found = format!("the glass \"{}\" cannot be used", excerpt(name));
            return Err(line.error(word, found, fault));
        }
        if let Some(found) = library.resolve(name, &makers) {
            let glass = found.glass.clone();
            found.warnings().for_each(|warning| report.note(warning));
            return Ok(MediumBehind::Glass(glass));
        }
        let near = library.suggest(name);
        let near = near.map_or_else(String::new, |near| format!(" (did you mean {near}?)"));
        let what = format!("the glass \"{}\"{near}", excerpt(name));
        let Some(figures) = figures else {
            return Err(line.error(
                word,
                format!("{what} is not known"),
                "expected a glass of a catalogue; add its AGF file with 'catalogue'",
            ));
        };
        let ModelFigures { nd, vd, .. } = figures;
        report.unsimulated(
            line,
            word,
            format!("{what} is in no catalogue and"),
            &format!("with the figures beside the name, nd {nd} and Vd {vd}"),
        )?;
        Ok(figures.medium())
    }
}
