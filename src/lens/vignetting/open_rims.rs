//! A lens with its rims opened.

use crate::prescription::{Prescription, Row};

/// Largest diameter of an opened rim, relative to the largest clear diameter of the lens.
const WIDEST: f64 = 4.0;
/// Largest increase of the diameter and of the slope of an opened asphere: farther out, polynomials
/// turn back and surfaces cross.
const ASPHERE: f64 = 1.25;

/// Rims that are kept.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum KeptRims {
    /// The rim and the shape of the stop.
    Stop,
    /// No rim.
    None,
}

/// Returns the lens with all other rims opened as far as their surfaces extend, and without
/// obstructions and other apertures.
pub fn open_rims(lens: &Prescription, keep: KeptRims) -> Prescription {
    let mut lens = lens.clone();
    let most = WIDEST * lens.rows.iter().map(|row| row.diameter).fold(0.0, f64::max);
    for row in &mut lens.rows {
        if row.stop && keep == KeptRims::Stop {
            continue;
        }
        row.diameter = row.diameter.max(max_diameter(row, most));
        row.open_all();
    }
    lens
}

/// Returns the diameter at which a surface ends, at most `most`.
fn max_diameter(row: &Row, most: f64) -> f64 {
    if !row.asphere.is_empty() || row.across.is_some() {
        return max_asphere_diameter(row);
    }
    // A cylinder ends in its curved direction; a circle of this diameter is inside.
    let bend = row.curvature().abs() * (1.0 + row.conic).max(0.0).sqrt();
    if bend > 0.0 { most.min(2.0 / bend) } else { most }
}

fn max_asphere_diameter(row: &Row) -> f64 {
    let half = row.diameter / 2.0;
    let steps = 64;
    let inside = (0..=steps).map(|i| row.slope(half * f64::from(i) / f64::from(steps)).abs());
    let steepest = ASPHERE * inside.fold(0.0, f64::max);
    let wider =
        (1..=steps).map(|i| half * (1.0 + (ASPHERE - 1.0) * f64::from(i) / f64::from(steps)));
    2.0 * wider.take_while(|&h| row.slope(h).abs() <= steepest).last().unwrap_or(half)
}
