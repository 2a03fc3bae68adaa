//! Whether the stop is a circle.

use super::{By, Effect, Finding, Harm, Question};
use crate::lens::{Iris, RealLens, Row, Shape};

/// Points along each side of the grid over the stop that its light is counted on.
const GRID: i32 = 512;
/// Error of a share of the light by counting on the grid, percent.
const ROUNDING: f64 = 0.1;

pub(super) fn find(question: &Question, lens: &RealLens) -> Finding {
    let rows = &lens.prescription.rows;
    let shaped: Vec<&Row> =
        rows.iter().filter(|row| row.iris != Iris::Round || row.obstruction > 0.0).collect();
    // Where it is not wanted, the camera already has a round stop.
    let possible = !shaped.is_empty() || question.wanted.of(Effect::Iris) == Some(false);
    if shaped.is_empty() {
        return Finding { possible, ..Finding::not_called_for(By::Lens, "the stop is a circle") };
    }
    let share = |part: fn(&Row) -> f64| shaped.iter().map(|row| part(row)).product::<f64>();
    let taken = 100.0 * (1.0 - share(left));
    let dimmed = 100.0 * (1.0 - share(kept));
    let reason = if taken < ROUNDING {
        format!("the stop is not a circle: {dimmed:.1} % of the light comes elsewhere through it")
    } else {
        format!("the stop is not a circle: its shape takes {taken:.1} % of the light")
    };
    Finding {
        error: Some(Harm::Signal(dimmed)),
        possible,
        called_for: true,
        ..Finding::not_called_for(By::Lens, &reason)
    }
}

/// The light that a shape leaves, in units of that through a round opening; pbrt's masks leave all.
fn left(row: &Row) -> f64 {
    over_the_stop(row, |light, _| light)
}

/// The same without the light of places that are brighter than a round opening would make them.
fn kept(row: &Row) -> f64 {
    over_the_stop(row, f64::min)
}

/// The integral over a stop of `count(transmission of its shape, that of a round opening)`, in units
/// of the round opening's area.
fn over_the_stop(row: &Row, count: impl Fn(f64, f64) -> f64) -> f64 {
    let shape = Shape::<f64>::new::<f64>(&row.iris, row.diameter);
    let half = row.diameter / 2.0;
    let reach = half * row.iris.reach();
    let place = |i: i32| (2.0 * (f64::from(i) + 0.5) / f64::from(GRID) - 1.0) * reach;
    let (mut light, mut all) = (0.0, 0.0);
    for (x, y) in (0..GRID * GRID).map(|i| (place(i % GRID), place(i / GRID))) {
        let h = x.hypot(y);
        if h > reach {
            continue;
        }
        let round = f64::from(h <= half);
        all += round;
        let open = if h < row.obstruction / 2.0 { 0.0 } else { shape.transmission(x, y) };
        light += count(open, round);
    }
    light / all
}
