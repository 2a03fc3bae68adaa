//! The wavelengths at which the indices of a lens are known, and those at which they are used.

use super::glass::{D_LINE, Glass};
use super::prescription::{Prescription, Row};

/// Data may be stated for a line that is rounded to a nanometre.
const ROUNDING: f64 = 1.0;

/// No material that is clear at the d line has a higher index; rutile has 2.6, germanium, opaque
/// there, has 4 in the infrared.
const MOST_VISIBLE: f64 = 2.7;

/// Wavelengths in nm, the shortest and the longest.
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
        // Two digits less than a line has.
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
    /// Doubts about the indices of the lens in light from `used[0]` to `used[1]` nm: one sentence for
    /// each kind of data that does not cover it, with the surfaces, the range of the data and what
    /// is done instead.
    pub fn doubtful_indices(&self, used: [f64; 2]) -> Vec<String> {
        let mut groups: Vec<([String; 2], Vec<String>)> = Vec::new();
        for (number, row) in (1..).zip(&self.rows) {
            let Some(said) = doubtful(row, Range(used)) else { continue };
            match groups.iter_mut().find(|(one, _)| *one == said) {
                Some((_, surfaces)) => surfaces.push(number.to_string()),
                None => groups.push((said, vec![number.to_string()])),
            }
        }
        let sentence = |([data, instead], surfaces): ([String; 2], Vec<String>)| {
            let plural = if surfaces.len() == 1 { "" } else { "s" };
            format!("behind surface{plural} {} {data}; {instead}", surfaces.join(", "))
        };
        groups.into_iter().map(sentence).collect()
    }

    /// Whether an index at one wavelength is all that is known of every medium but air.
    pub fn is_monochromatic(&self) -> bool {
        !self.rows.iter().any(|row| row.glass.disperses())
    }
}

/// The range that the data of a medium cover, and the index that serves beyond it.
fn doubtful(row: &Row, used: Range) -> Option<[String; 2]> {
    if row.glass == Glass::Constant && row.index == 1.0 {
        return None;
    }
    let known = row.glass.range().map(Range);
    if known.is_some_and(|known| known.covers(used)) {
        let constant = row.glass == Glass::Constant;
        return (constant && row.index > MOST_VISIBLE).then(|| {
            [
                format!("the index {} is taken at the d line, {}", row.index, Range([D_LINE; 2])),
                "nothing transparent has it in visible light: for an infrared material all figures \
                 hold at the wavelength of its index, and no picture is right"
                    .to_owned(),
            ]
        });
    }
    let known = known?;
    Some(match &row.glass {
        Glass::Constant => [
            format!("the file says nothing of dispersion but the index at {known}"),
            format!("at {used} the index is the same"),
        ],
        Glass::Abbe { .. } => [
            format!("the Abbe number describes the index from {known}"),
            format!("at {used} the index is extrapolated"),
        ],
        Glass::Table(_) => [
            format!("the table of indices covers {known}"),
            format!("at {used} the index of its nearest end serves"),
        ],
        Glass::Catalogue(glass) => [
            format!("{} is known from {known}", glass.name),
            format!("at {used} the index is extrapolated or that of the nearest end"),
        ],
    })
}
