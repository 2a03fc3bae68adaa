//! A lens whose rims are out of the way.

use crate::lens::iris::Iris;
use crate::lens::prescription::{Prescription, Row};

/// How many times the widest clear diameter of a lens a rim is opened at most.
const WIDEST: f64 = 4.0;
/// How much wider and steeper than inside its rim an asphere is opened: beyond, polynomials turn
/// and cross.
const ASPHERE: f64 = 1.25;

/// Which rims stay.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Keep {
    /// That of the stop, and its shape.
    Stop,
    /// None.
    Nothing,
}

/// The lens with all other rims opened as far as their surfaces go, and no obstructions.
pub(super) fn widened(lens: &Prescription, keep: Keep) -> Prescription {
    let mut lens = lens.clone();
    let most = WIDEST * lens.rows.iter().map(|row| row.diameter).fold(0.0, f64::max);
    for row in &mut lens.rows {
        if row.stop && keep == Keep::Stop {
            continue;
        }
        row.diameter = row.diameter.max(edge(row, most));
        row.obstruction = 0.0;
        row.iris = Iris::Round;
    }
    lens
}

/// The diameter at which a surface ends, or `most`.
fn edge(row: &Row, most: f64) -> f64 {
    if !row.asphere.is_empty() {
        return asphere_edge(row);
    }
    // A cylinder ends where it is curved; a circle around the axis stays inside.
    let bend = row.curvature().abs() * (1.0 + row.conic).max(0.0).sqrt();
    if bend > 0.0 { most.min(2.0 / bend) } else { most }
}

fn asphere_edge(row: &Row) -> f64 {
    let half = row.diameter / 2.0;
    let steps = 64;
    let inside = (0..=steps).map(|i| row.slope(half * f64::from(i) / f64::from(steps)).abs());
    let steepest = ASPHERE * inside.fold(0.0, f64::max);
    let wider =
        (1..=steps).map(|i| half * (1.0 + (ASPHERE - 1.0) * f64::from(i) / f64::from(steps)));
    2.0 * wider.take_while(|&h| row.slope(h).abs() <= steepest).last().unwrap_or(half)
}
