//! Outline of a pupil of transmittance 0 or 1: marching squares over a grid (the two-dimensional
//! form of Lorensen & Cline 1987), with the crossings found by tracing.

use super::pupil_view::PupilView;
use super::{ExitPupil, PupilEdge, amplitude_integral};
use crate::pupil::outline::PupilBox;

/// Cells along each side of the grid. A chord of a circle that fills it deviates by 1/16000 of the
/// diameter.
const GRID: usize = 128;
/// Points on a side of a cell in each round of the search for the crossing.
const POINTS: usize = 8;
/// Rounds of the search: they reach 1/59049 of a cell, which is below the rounding of f32.
const ROUNDS: usize = 5;

/// Corners along each side of the grid.
const SIDE: usize = GRID + 1;

/// Traces the outline of the light above a level.
pub(super) fn trace(view: &mut PupilView, pupil_box: PupilBox, level: f32) -> Option<ExitPupil> {
    // No light was found beyond the box; one more cell closes every outline.
    let pupil_box = pupil_box.grown(pupil_box.size().map(|size| size / (GRID - 2) as f64));
    let cell = pupil_box.size().map(|size| size / GRID as f64);
    let corner = pupil_box.corner();
    let place = |i: usize| {
        [corner[0] + cell[0] * (i % SIDE) as f64, corner[1] + cell[1] * (i / SIDE) as f64]
    };
    let light = view.light(SIDE * SIDE, place);
    let inside = |i: usize| (1..GRID).contains(&(i % SIDE)) && (1..GRID).contains(&(i / SIDE));
    let lit: Vec<bool> = (0..SIDE * SIDE).map(|i| light[i] > level && inside(i)).collect();
    // By corner and axis: the index of the crossing on the cell side that starts there, if the
    // outline crosses it.
    let mut crossed = vec![usize::MAX; 2 * SIDE * SIDE];
    let mut spans = Vec::new();
    for i in 0..SIDE * SIDE {
        for (axis, next) in [(0, i + 1), (1, i + SIDE)] {
            let on = [i % SIDE, i / SIDE][axis] < GRID;
            if on && lit[i] != lit[next] {
                crossed[2 * i + axis] = spans.len();
                let (from, to) = if lit[i] { (i, next) } else { (next, i) };
                spans.push([place(from), place(to)]);
            }
        }
    }
    let points = crossings(view, spans, level);
    let mut edges = Vec::with_capacity(points.len());
    for i in (0..GRID * SIDE).filter(|i| i % SIDE < GRID) {
        // Counter-clockwise; a side leads from each corner to the next.
        let corners = [i, i + 1, i + 1 + SIDE, i + SIDE];
        let sides = [2 * i, 2 * (i + 1) + 1, 2 * (i + SIDE), 2 * i + 1];
        let is_lit = |k: usize| lit[corners[k % 4]];
        for out in (0..4).filter(|&k| is_lit(k) && !is_lit(k + 1)) {
            // The lit stretch that ends on this side began on the last earlier side with an
            // opposite crossing.
            let began = (1..4).map(|back| (out + 4 - back) % 4);
            let Some(into) = began.into_iter().find(|&k| !is_lit(k) && is_lit(k + 1)) else {
                continue;
            };
            let [from, to] = [out, into].map(|k| points[crossed[sides[k]]]);
            edges.push(PupilEdge { from, to, step: 1.0 });
        }
    }
    let area = amplitude_integral(&edges);
    (area > 0.0).then_some(ExitPupil { edges, area })
}

/// Returns where the light ends between a lit and a dark point, as T.
fn crossings(view: &mut PupilView, mut spans: Vec<[[f64; 2]; 2]>, level: f32) -> Vec<[f64; 2]> {
    let between = |[from, to]: [[f64; 2]; 2], k: usize| {
        let share = k as f64 / (POINTS + 1) as f64;
        [0, 1].map(|axis| from[axis] + share * (to[axis] - from[axis]))
    };
    for _ in 0..ROUNDS {
        let light =
            view.light(spans.len() * POINTS, |i| between(spans[i / POINTS], i % POINTS + 1));
        for (span, light) in spans.iter_mut().zip(light.chunks_exact(POINTS)) {
            let dark = light.iter().position(|&light| light <= level).unwrap_or(POINTS);
            *span = [between(*span, dark), between(*span, dark + 1)];
        }
    }
    let middle = |[from, to]: &[[f64; 2]; 2]| {
        view.direction([0, 1].map(|axis| (from[axis] + to[axis]) / 2.0))
    };
    spans.iter().map(middle).collect()
}
