//! Whether the stop is a circle.

use super::{By, Effect, Finding, Harm, Question};
use crate::lens::{Iris, RealLens, Row, Shape};

/// Points along each side of the grid over the stop that its light is counted on.
const GRID: i32 = 512;

pub(super) fn find(question: &Question, lens: &RealLens) -> Finding {
    let rows = &lens.prescription.rows;
    let shaped: Vec<&Row> =
        rows.iter().filter(|row| row.iris != Iris::Round || row.obstruction > 0.0).collect();
    // Where it is not wanted, the camera already has a round stop.
    let possible = !shaped.is_empty() || question.wanted.of(Effect::Iris) == Some(false);
    if shaped.is_empty() {
        return Finding { possible, ..Finding::not_called_for(By::Lens, "the stop is a circle") };
    }
    let taken = 100.0 * (1.0 - shaped.iter().map(|row| open(row)).product::<f64>());
    Finding {
        error: Some(Harm::Signal(taken)),
        possible,
        called_for: true,
        ..Finding::not_called_for(
            By::Lens,
            &format!("the stop is not a circle: its shape takes {taken:.1} % of the light"),
        )
    }
}

/// The share of the light over a round opening that its shape leaves.
fn open(row: &Row) -> f64 {
    let shape = Shape::<f64>::new::<f64>(&row.iris, row.diameter);
    let half = row.diameter / 2.0;
    let place = |i: i32| (2.0 * (f64::from(i) + 0.5) / f64::from(GRID) - 1.0) * half;
    let (mut light, mut all) = (0.0, 0.0);
    for (x, y) in (0..GRID * GRID).map(|i| (place(i % GRID), place(i / GRID))) {
        let h = x.hypot(y);
        if h <= half {
            all += 1.0;
            light += if h < row.obstruction / 2.0 { 0.0 } else { shape.transmission(x, y) };
        }
    }
    light / all
}
