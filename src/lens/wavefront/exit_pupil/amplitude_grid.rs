//! Pupil of partial transmittance: a grid of amplitudes, and the edges between its cells.

use super::pupil_view::PupilView;
use super::{ExitPupil, PupilEdge};
use crate::pupil::outline::PupilBox;

/// Cells along each side: the resolution of the named masks.
const GRID: usize = 256;
/// A cell is the mean of this number of rays along each side.
const RAYS: usize = 3;
/// Most cells along one edge: T is nearly, but not quite, a linear function of the point.
const LONGEST: usize = 16;
/// Smallest step of the amplitude that makes an edge.
const SMALL: f64 = 1e-3;

pub(super) fn trace(view: &mut PupilView, pupil_box: PupilBox) -> Option<ExitPupil> {
    let cell = pupil_box.size().map(|size| size / GRID as f64);
    let low = pupil_box.corner();
    let fine = |i: usize, k: usize| (i * RAYS + k) as f64 / RAYS as f64 + 0.5 / RAYS as f64;
    // With a border of dark cells, so that every edge has two sides.
    let mut amplitude = vec![0.0; (GRID + 2) * (GRID + 2)];
    for row in 0..GRID {
        let light = view.light(GRID * RAYS * RAYS, |i| {
            let (column, k) = (i / (RAYS * RAYS), i % (RAYS * RAYS));
            let (x, y) = (fine(column, k % RAYS), fine(row, k / RAYS));
            [low[0] + x * cell[0], low[1] + y * cell[1]]
        });
        for (column, light) in light.chunks_exact(RAYS * RAYS).enumerate() {
            let sum: f64 = light.iter().map(|&light| f64::from(light).sqrt()).sum();
            amplitude[(row + 1) * (GRID + 2) + column + 1] = sum / (RAYS * RAYS) as f64;
        }
    }
    let at = |column: usize, row: usize| amplitude[row * (GRID + 2) + column];
    let corner = |column: usize, row: usize| {
        view.direction([low[0] + cell[0] * column as f64, low[1] + cell[1] * row as f64])
    };
    let mut edges = Vec::new();
    for line in 0..=GRID {
        // The left of an upward edge is at smaller u; the left of a rightward edge at larger v.
        let upwards = |k: usize| at(line, k + 1) - at(line + 1, k + 1);
        runs(upwards, |from, to, step| {
            edges.push(PupilEdge { from: corner(line, from), to: corner(line, to), step });
        });
        let rightwards = |k: usize| at(k + 1, line + 1) - at(k + 1, line);
        runs(rightwards, |from, to, step| {
            edges.push(PupilEdge { from: corner(from, line), to: corner(to, line), step });
        });
    }
    let size = |column: usize, row: usize| {
        let [a, b, c] = [corner(column, row), corner(column + 1, row), corner(column, row + 1)];
        (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
    };
    let cells = (0..GRID * GRID).map(|i| (i % GRID, i / GRID));
    let area = cells.map(|(i, j)| at(i + 1, j + 1).powi(2) * size(i, j)).sum();
    (area > 0.0).then_some(ExitPupil { edges, area })
}

/// Merges consecutive cells of the same step along a line of the grid into one edge.
fn runs(step: impl Fn(usize) -> f64, mut edge: impl FnMut(usize, usize, f64)) {
    let mut from = 0;
    for to in 1..=GRID {
        let same = to < GRID && (step(to) - step(from)).abs() < SMALL && to - from < LONGEST;
        if !same {
            if step(from).abs() > SMALL {
                edge(from, to, step(from));
            }
            from = to;
        }
    }
}
