//! Least edge thicknesses.

use petzval_lens::{Prescription, Row};

/// Factor of the missing thickness in the merit: a micrometre counts as ten of spot radius.
const FACTOR: f64 = 10.0;

/// Least thickness at the rim of each element and gap.
#[derive(Clone, Debug)]
pub(super) struct EdgeConstraint {
    /// Least thickness of each row (mm).
    least: Vec<f64>,
}

impl EdgeConstraint {
    /// Demands a thickness at all rims (mm), but no more than a lens has that is thinner already.
    pub fn new(lens: &Prescription, least: f64) -> Self {
        Self { least: edge_thicknesses(lens).map(|edge| least.min(edge)).collect() }
    }

    /// Returns what each rim lacks (mm, times a factor), 0 for none.
    pub fn residuals<'a>(&'a self, lens: &'a Prescription) -> impl Iterator<Item = f64> + 'a {
        let lack = |(least, edge): (&f64, f64)| FACTOR * (least - edge).max(0.0);
        self.least.iter().zip(edge_thicknesses(lens)).map(lack)
    }
}

/// Returns the thickness behind each row but the last at the smaller of both rims (mm).
fn edge_thicknesses(lens: &Prescription) -> impl Iterator<Item = f64> + '_ {
    let thickness = |(pair, travel): (&[Row], f64)| {
        let [row, next] = [&pair[0], &pair[1]];
        let half = row.diameter.min(next.diameter) / 2.0;
        travel * (row.thickness + next.sag(half) - row.sag(half))
    };
    lens.rows.windows(2).zip(lens.travels().into_iter().skip(1)).map(thickness)
}
