//! Decision about the iris, from the difference between its shape and a circle.

use super::{DecidedBy, Effect, Finding, OmissionError, PlanInput};
use petzval_lens::{ApertureShape, RealLens, Row};

/// Points along each side of the grid over the stop that its light is integrated on.
const GRID: i32 = 512;
/// Error of a share of the light by the resolution of the grid (percent).
const ROUNDING: f64 = 0.1;

pub(super) fn find(input: &PlanInput, lens: &RealLens) -> Finding {
    let rows = &lens.prescription.rows;
    let shaped: Vec<&Row> = rows.iter().filter(|row| !row.is_unobstructed()).collect();
    // If the effect is excluded, the camera already has a round stop.
    let possible = !shaped.is_empty() || input.selection.of(Effect::Iris) == Some(false);
    if shaped.is_empty() {
        return Finding {
            possible,
            ..Finding::unavailable(DecidedBy::Lens, "the stop is a circle")
        };
    }
    let share = |part: fn(&Row) -> f64| shaped.iter().map(|row| part(row)).product::<f64>();
    let taken = 100.0 * (1.0 - share(transmission));
    let dimmed = 100.0 * (1.0 - share(clipped_transmission));
    let reason = if taken < ROUNDING {
        format!("the stop is not a circle: {dimmed:.1} % of the light comes elsewhere through it")
    } else {
        format!("the stop is not a circle: its shape takes {taken:.1} % of the light")
    };
    Finding {
        error: Some(OmissionError::Signal(dimmed)),
        possible,
        by_default: true,
        ..Finding::unavailable(DecidedBy::Lens, &reason)
    }
}

/// Returns the light through a shape, relative to that through a round opening; 1 for pbrt's masks.
fn transmission(row: &Row) -> f64 {
    over_the_stop(row, |light, _| light)
}

/// Returns the same without the light by which any point exceeds a round opening.
fn clipped_transmission(row: &Row) -> f64 {
    over_the_stop(row, f64::min)
}

/// Returns the integral over a stop of `count(transmission of its shape, that of a round opening)`,
/// relative to the area of the round opening.
fn over_the_stop(row: &Row, count: impl Fn(f64, f64) -> f64) -> f64 {
    let shape = ApertureShape::<f64>::new::<f64>(&row.iris, row.diameter);
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
        let passes = row.apertures.iter().all(|aperture| aperture.transmits(x, y));
        let blocked = h < row.obstruction / 2.0 || !passes;
        let open = if blocked { 0.0 } else { shape.transmission(x, y) };
        light += count(open, round);
    }
    light / all
}
