//! A pupil of partial transmission: cells, and the edges between them.

use super::sight::Sight;
use super::{Edge, ExitPupil};
use crate::lens::outline::Frame;

/// Cells along each side: as many as a mask with a name has.
const GRID: usize = 256;
/// A cell is the mean of this many by this many rays.
const RAYS: usize = 3;
/// The most cells that an edge goes along: T is nearly, not quite, an even function of the point.
const LONGEST: usize = 16;
/// Steps of the amplitude that are left out.
const SMALL: f64 = 1e-3;

pub(super) fn pupil(sight: &mut Sight, frame: Frame) -> Option<ExitPupil> {
    let cell = frame.size().map(|size| size / GRID as f64);
    let low = frame.corner();
    let fine = |i: usize, k: usize| (i * RAYS + k) as f64 / RAYS as f64 + 0.5 / RAYS as f64;
    // With a rim of dark cells around, so that every edge has two sides.
    let mut amplitude = vec![0.0; (GRID + 2) * (GRID + 2)];
    for row in 0..GRID {
        let light = sight.light(GRID * RAYS * RAYS, |i| {
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
        sight.direction([low[0] + cell[0] * column as f64, low[1] + cell[1] * row as f64])
    };
    let mut edges = Vec::new();
    for line in 0..=GRID {
        // Upwards, its left at smaller u; to the right, its left at larger v.
        let upwards = |k: usize| at(line, k + 1) - at(line + 1, k + 1);
        runs(upwards, |from, to, step| {
            edges.push(Edge { from: corner(line, from), to: corner(line, to), step });
        });
        let rightwards = |k: usize| at(k + 1, line + 1) - at(k + 1, line);
        runs(rightwards, |from, to, step| {
            edges.push(Edge { from: corner(from, line), to: corner(to, line), step });
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

/// Cells of the same step, one after another along a line of the grid, make one edge.
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
