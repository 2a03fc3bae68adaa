//! ZoomPositions positions of CODE V files: `ZOO n`, then `THI S3 a b c`.

use super::CodeVWord;
use crate::report::ReadReport;
use petzval_lens::INFINITE;
use petzval_lens::LensError;
use petzval_lens::{Configuration, Quantity, Setting};

/// Zoomed values.
#[derive(Default)]
pub(super) struct ZoomPositions<'a> {
    positions: usize,
    /// Keyword, surface and values.
    values: Vec<(String, usize, Vec<CodeVWord<'a>>)>,
}

impl<'a> ZoomPositions<'a> {
    /// Reads a command; returns whether it states a value for each zoom position.
    pub fn read(
        &mut self,
        keyword: &str,
        surface: Option<usize>,
        values: &[CodeVWord<'a>],
    ) -> Result<bool, LensError> {
        // "ZOO 3" states the number of positions, "ZOO THI S3 a b c" zooms a value.
        if keyword == "ZOO" {
            if let [word] = values
                && let Ok(positions) = word.text.parse::<usize>()
            {
                self.positions = positions.min(1000);
            } else if let [command, place, rest @ ..] = values
                && let Some(surface) =
                    super::surface_place(&place.text.to_ascii_uppercase()).flatten()
            {
                let keyword = command.text.to_ascii_uppercase();
                self.values.push((keyword, surface, rest.to_vec()));
            } else if let [command, rest @ ..] = values {
                self.values.push((command.text.to_ascii_uppercase(), 0, rest.to_vec()));
            }
            return Ok(true);
        }
        let zoomed = self.positions > 1
            && values.len() == self.positions
            && matches!(keyword, "THI" | "RDY" | "CUY" | "CIR" | "EPD" | "FNO" | "NA" | "NAO");
        if zoomed {
            self.values.push((keyword.to_owned(), surface.unwrap_or(0), values.to_vec()));
        }
        Ok(zoomed)
    }

    /// Returns the zoom positions.
    pub fn configurations(
        &self,
        places: &[Option<usize>],
        unit: f64,
        report: &mut ReadReport,
    ) -> Result<Vec<Configuration>, LensError> {
        if self.positions < 2 {
            return Ok(Vec::new());
        }
        let state =
            |number: usize| Configuration { name: number.to_string(), ..Configuration::default() };
        let mut states: Vec<Configuration> = (1..=self.positions).map(state).collect();
        for (keyword, surface, values) in &self.values {
            let row = places.get(*surface).copied().flatten();
            for (state, word) in states.iter_mut().zip(values) {
                if keyword.len() == 3 && keyword.ends_with('C') {
                    continue;
                }
                let mut set = |quantity: Quantity, value: f64| {
                    state.settings.extend(row.map(|row| Setting { row, quantity, value }));
                };
                match keyword.as_str() {
                    "THI" if *surface == 0 => {
                        let distance = word.number()?;
                        let near = distance.abs() < INFINITE;
                        state.object_distance =
                            Some(if near { distance * unit } else { f64::INFINITY });
                    }
                    "THI" => set(Quantity::Thickness, word.number()? * unit),
                    "CUY" => set(Quantity::Curvature, word.number()? / unit),
                    "RDY" => {
                        let radius = word.number()?;
                        let curvature = if radius == 0.0 { 0.0 } else { radius.recip() };
                        set(Quantity::Curvature, curvature / unit);
                    }
                    "CIR" => set(Quantity::Diameter, 2.0 * word.number()? * unit),
                    "FNO" => state.f_number = Some(word.number()?),
                    _ => report.note(format!("zoom positions: {keyword} is not changed")),
                }
            }
        }
        Ok(states)
    }
}
