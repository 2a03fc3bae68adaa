//! Least edge thicknesses.

use crate::lens::prescription::Prescription;

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
        let rows = 0..lens.rows.len().saturating_sub(1);
        Self { least: rows.map(|i| least.min(edge_thickness(lens, i))).collect() }
    }

    /// Returns what each rim lacks (mm, times a factor), 0 for none.
    pub fn residuals<'a>(&'a self, lens: &'a Prescription) -> impl Iterator<Item = f64> + 'a {
        let lack = |(i, least): (usize, &f64)| FACTOR * (least - edge_thickness(lens, i)).max(0.0);
        self.least.iter().enumerate().map(lack)
    }
}

/// Returns the thickness behind a row at the smaller of both rims (mm).
fn edge_thickness(lens: &Prescription, i: usize) -> f64 {
    let [row, next] = [&lens.rows[i], &lens.rows[i + 1]];
    let half = row.diameter.min(next.diameter) / 2.0;
    lens.travel_before(i + 1) * (row.thickness + next.sag(half) - row.sag(half))
}
