//! Vignetting layer: where in the lens the light of every pixel ends. It is computed for the
//! centres of pixels, after the render.

use rayon::prelude::*;

use crate::film::Frame;
use petzval_image::ImageLayer;
use petzval_lens::{FilmMap, LightBudget, Normalization, RealLens};

/// Film radii at which the light budget of a round lens is computed.
const RADII: usize = 512;
/// Cells along each side of the grid for any other lens or film; the budget is computed at their
/// corners.
const CELLS: [usize; 2] = [96, 64];
/// Rays for each radius of a round lens, and for each of the more numerous corners of the grid.
const RAYS: [u32; 2] = [1 << 14, 1 << 12];

/// Returns the vignetting layer.
///
/// The light is what would pass the stop if no other rim were in its way. `pass` is the share that
/// leaves the lens, and `surfaceNN` the share that row NN, from 01 at the scene side, blocks. They
/// add up to 1. Rows that block nothing from any point of the film have no channel. If the stop is
/// not visible at all, the rear row blocks everything.
///
/// `film` is the width and height of the whole film, mm.
pub fn vignetting(lens: &RealLens, film: [f64; 2], frame: &Frame) -> ImageLayer {
    let round = lens.is_round();
    let rays = RAYS[usize::from(!round)];
    let analysis = lens.vignetting(rays);
    let shares = |point: [f64; 2]| shares(analysis.budget(point, Normalization::Stop), lens);
    let field = match round {
        true => {
            let step = film[0].hypot(film[1]) / 2.0 / (RADII - 1) as f64;
            let nodes = (0..RADII).into_par_iter().map(|i| shares([step * i as f64, 0.0]));
            ShareGrid { nodes: nodes.collect(), counts: [RADII, 1] }
        }
        false => {
            let [columns, rows] = CELLS.map(|cells| cells + 1);
            let place = |axis: usize, i: usize| film[axis] * (i as f64 / CELLS[axis] as f64 - 0.5);
            let nodes = (0..columns * rows).into_par_iter();
            let nodes = nodes.map(|i| shares([place(0, i % columns), place(1, i / columns)]));
            ShareGrid { nodes: nodes.collect(), counts: [columns, rows] }
        }
    };
    let channels = (0..=lens.prescription.rows.len())
        .filter(|&channel| channel == 0 || field.nodes.iter().any(|node| node[channel] > 0.0));
    let values = channels.map(|channel| {
        let name = match channel {
            0 => "pass".to_owned(),
            row => format!("surface{row:02}"),
        };
        (name, pixels(lens, film, frame, |place| field.at(channel, place)))
    });
    ImageLayer::new("vignetting", values.collect())
}

/// Returns the share that passes, and the shares that the rows block.
fn shares(budget: Option<LightBudget>, lens: &RealLens) -> Vec<f32> {
    let mut shares = vec![0.0; lens.prescription.rows.len() + 1];
    match budget {
        None => shares[lens.prescription.rows.len()] = 1.0,
        Some(budget) => {
            shares[0] = budget.pass as f32;
            for (share, row) in shares[1..].iter_mut().zip(&budget.rows) {
                *share = row.share() as f32;
            }
        }
    }
    shares
}

/// Evaluates `value` at the centre of every rendered pixel, given its position in the grid of
/// nodes: 0 to 1 along both sides.
fn pixels(
    lens: &RealLens,
    film: [f64; 2],
    frame: &Frame,
    value: impl Fn([f64; 2]) -> f32,
) -> Vec<f32> {
    let (round, map) = (lens.is_round(), FilmMap::new(film, frame.resolution));
    let mut values = Vec::with_capacity(frame.size().map(|n| n as usize).iter().product());
    for y in frame.low[1]..frame.high[1] {
        for x in frame.low[0]..frame.high[0] {
            let [x, y] = map.film_point([x, y].map(|at| f64::from(at) + 0.5));
            values.push(value(match round {
                true => [x.hypot(y) / (film[0].hypot(film[1]) / 2.0), 0.0],
                false => [x / film[0] + 0.5, y / film[1] + 0.5],
            }));
        }
    }
    values
}

/// Shares at the nodes of a grid, interpolated bilinearly.
struct ShareGrid {
    nodes: Vec<Vec<f32>>,
    counts: [usize; 2],
}

impl ShareGrid {
    /// Returns the interpolated share of a channel.
    fn at(&self, channel: usize, place: [f64; 2]) -> f32 {
        let cell = |axis: usize| {
            let last = self.counts[axis] - 1;
            let at = (place[axis] * last as f64).clamp(0.0, last as f64);
            let low = (at as usize).min(last.saturating_sub(1));
            (low, (low + 1).min(last), (at - low as f64) as f32)
        };
        let ((left, right, s), (upper, lower, t)) = (cell(0), cell(1));
        let node = |column: usize, row: usize| self.nodes[row * self.counts[0] + column][channel];
        let row = |row: usize| node(left, row) * (1.0 - s) + node(right, row) * s;
        row(upper) * (1.0 - t) + row(lower) * t
    }
}
