//! Warnings about media: refractive indices outside the range of their data, and invalid internal
//! transmittances.

use super::{Prescription, Row};
use petzval_spectrum::{D_LINE, Glass, IndexRangeError};

/// Tolerance of a range, because a line may be rounded to a nanometre (nm).
const ROUNDING: f64 = 1.0;

/// Highest index of a material that is transparent at the d line. Rutile has 2.6; germanium, opaque
/// there, has 4 in the infrared.
const MAX_VISIBLE_INDEX: f64 = 2.7;

/// Shortest and longest wavelength (nm).
#[derive(Clone, Copy)]
struct Range([f64; 2]);

impl Range {
    fn covers(self, other: Self) -> bool {
        let (Self([low, high]), Self([from, to])) = (self, other);
        low - ROUNDING <= from && to <= high + ROUNDING
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        // One decimal: two digits less than lines are stated with.
        let Self([low, high]) = self;
        let [low_text, high_text] = [low, high].map(|nm| format!("{}", (nm * 10.0).round() / 10.0));
        if low == high {
            write!(f, "{low_text} nm")
        } else {
            write!(f, "{low_text} to {high_text} nm")
        }
    }
}

impl Prescription {
    /// Checks that the data of every medium cover the wavelengths from `used[0]` to `used[1]` (nm),
    /// but for a small tolerance of which [`Self::index_warnings`] warns.
    ///
    /// # Errors
    /// Returns an error for the first medium whose data do not.
    pub fn check_wavelengths(&self, used: [f64; 2]) -> Result<(), IndexRangeError> {
        for (number, row) in (1..).zip(&self.rows) {
            for nm in used {
                let surface = Some(number);
                row.glass.check(nm).map_err(|error| IndexRangeError { surface, ..error })?;
            }
        }
        Ok(())
    }

    /// Returns warnings about the media of the lens for light from `used[0]` to `used[1]` (nm):
    /// one sentence for each kind of data that does not cover it, with the surfaces, the range of
    /// the data and what is used instead.
    pub fn index_warnings(&self, used: [f64; 2]) -> Vec<String> {
        let mut groups: Vec<([String; 2], Vec<String>)> = Vec::new();
        for (number, row) in (1..).zip(&self.rows) {
            let warnings = [index_warning(row, Range(used)), absorption_warning(row)];
            for warning in warnings.into_iter().flatten() {
                match groups.iter_mut().find(|(other, _)| *other == warning) {
                    Some((_, surfaces)) => surfaces.push(number.to_string()),
                    None => groups.push((warning, vec![number.to_string()])),
                }
            }
        }
        let sentence = |([data, instead], surfaces): ([String; 2], Vec<String>)| {
            let plural = if surfaces.len() == 1 { "" } else { "s" };
            format!("behind surface{plural} {} {data}; {instead}", surfaces.join(", "))
        };
        groups.into_iter().map(sentence).collect()
    }

    /// Returns whether no medium has known dispersion.
    pub fn is_monochromatic(&self) -> bool {
        !self.rows.iter().any(|row| row.glass.disperses())
    }
}

/// Returns two clauses: the invalid internal transmittances of a catalogue, and what is used instead. `None`
/// if there are none.
fn absorption_warning(row: &Row) -> Option<[String; 2]> {
    let Glass::Catalogue(glass) = &row.glass else { return None };
    let [line, count] = glass.absorption.unusable?;
    let lines = match count {
        1 => format!("the IT line {line} of {} states", glass.full_name()),
        _ => format!("{count} IT lines of {}, the first in line {line}, state", glass.full_name()),
    };
    Some([
        format!("{lines} no valid transmittance (expected um, a share from 0 to 1, mm)"),
        match glass.absorption.measured().is_empty() {
            true => "no absorption is known".to_owned(),
            false => "the absorption is that of the other IT lines".to_owned(),
        },
    ])
}

/// Returns two clauses: the range that the data of a medium covers, and the index used beyond it.
/// `None` if the data covers the light in use.
fn index_warning(row: &Row, used: Range) -> Option<[String; 2]> {
    if row.glass == Glass::Constant && row.index == 1.0 {
        return None;
    }
    let known = row.glass.range().map(Range);
    if known.is_some_and(|known| known.covers(used)) {
        let constant = row.glass == Glass::Constant;
        return (constant && row.index > MAX_VISIBLE_INDEX).then(|| {
            [
                format!("the index {} is taken at the d line, {}", row.index, Range([D_LINE; 2])),
                "nothing transparent has it in visible light: for an infrared material all figures \
                 hold at the wavelength of its index, and pictures are wrong"
                    .to_owned(),
            ]
        });
    }
    let known = known?;
    Some(match &row.glass {
        Glass::Constant => [
            format!("the file states no dispersion, only the index at {known}"),
            format!("at {used} the index is the same"),
        ],
        Glass::Abbe { .. } => [
            format!("the Abbe number describes the index from {known}"),
            format!("at {used} the index is extrapolated"),
        ],
        Glass::Table(_) => [
            format!("the table of indices covers {known}"),
            format!("at {used} the index of its nearest end is used"),
        ],
        Glass::Catalogue(glass) => [
            format!("{} is known from {known}", glass.name),
            format!("at {used} the index is extrapolated or that of the nearest end"),
        ],
    })
}
