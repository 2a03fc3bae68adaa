//! Private glasses of CODE V files: `PRV ... END`.

use super::super::glass_name::GlassNames;
use super::super::report::ReadReport;
use super::statement::CodeVWord;
use petzval_lens::LensError;
use petzval_spectrum::{Formula, Glass};

/// Range of wavelengths of a formula whose file states none (nm).
const ANY: [f64; 2] = [300.0, 2500.0];

/// State of a private catalogue.
#[derive(Default)]
pub(super) struct GlassTable {
    /// Wavelengths of the indices (nm).
    wavelengths: Vec<f64>,
}

impl GlassTable {
    /// Reads the wavelengths, or a glass by its indices or a Laurent series.
    pub fn read(
        &mut self,
        command: &CodeVWord,
        values: &[CodeVWord],
        glasses: &mut GlassNames,
        report: &mut ReadReport,
    ) -> Result<(), LensError> {
        if command.text.eq_ignore_ascii_case("PWL") {
            self.wavelengths = values.iter().map(CodeVWord::number).collect::<Result<_, _>>()?;
            return Ok(());
        }
        let name = command.text.trim_matches(['\'', '"']);
        let kind = values.first().map_or("", |word| word.text);
        if kind.parse::<f64>().is_err() {
            let numbers: Vec<f64> = values[1.min(values.len())..]
                .iter()
                .map(CodeVWord::number)
                .collect::<Result<_, _>>()?;
            let coefficient = |i: usize| numbers.get(i).copied().unwrap_or(0.0);
            // Laurent: n^2 = a0 + a1 L^2 + a2 L^-2 + ... as Schott's.
            if kind.eq_ignore_ascii_case("LAU") {
                let formula = Formula::Schott(std::array::from_fn(coefficient));
                glasses.define(name, Glass::formula(name, formula, Some(ANY)));
            } else if kind.eq_ignore_ascii_case("GMS") || kind.eq_ignore_ascii_case("SEL") {
                let pairs = numbers.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect();
                let formula = Formula::Sellmeier { a: 1.0, terms: pairs };
                glasses.define(name, Glass::formula(name, formula, Some(ANY)));
            } else {
                report.note(format!("the formula {kind} of the private glass {name} is not known"));
            }
            return Ok(());
        }
        let indices: Vec<f64> = values.iter().map(CodeVWord::number).collect::<Result<_, _>>()?;
        if indices.len() != self.wavelengths.len() {
            let found =
                format!("{} indices for {} wavelengths", indices.len(), self.wavelengths.len());
            return Err(command.error(found, "expected one index for each wavelength of PWL"));
        }
        let mut entries: Vec<[f64; 2]> =
            self.wavelengths.iter().zip(&indices).map(|(&nm, &n)| [nm, n]).collect();
        entries.sort_by(|a, b| a[0].total_cmp(&b[0]));
        if entries.windows(2).any(|pair| pair[0][0] == pair[1][0]) {
            return Err(command.error("a wavelength stated twice", "expected each once"));
        }
        glasses.define(name, Glass::Table(entries.into()));
        Ok(())
    }
}
