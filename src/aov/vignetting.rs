//! The layer that says where in the lens the light of every pixel ends. It is worked out for the
//! centres of pixels, after the render.

use rayon::prelude::*;

use crate::film::Frame;
use crate::image::Layer;
use crate::lens::{Ledger, Of, RealLens};

/// Radii of the film of a round lens that have a ledger each.
const RADII: usize = 512;
/// Cells along each side of any other film; their corners have a ledger each.
const CELLS: [usize; 2] = [96, 64];
/// Rays for each radius, and for each corner, of which there are more.
const RAYS: [u32; 2] = [1 << 14, 1 << 12];

/// Where the light of every pixel goes: of what would pass the stop if no other rim were in its
/// way, `pass` is the share that leaves the lens and `surfaceNN` what row NN, from 01 at the
/// scene side, takes of it. They add up to 1. Rows that take nothing from any point of the film
/// have no channel. Where the stop is not to be seen at all, the rear row takes everything.
///
/// `film` is the width and height of the whole film, mm.
pub fn vignetting(lens: &RealLens, film: [f64; 2], frame: &Frame) -> Layer {
    let round = lens.is_round();
    let rays = RAYS[usize::from(!round)];
    let ledgers = lens.vignetting(rays);
    let shares = |point: [f64; 2]| shares(ledgers.ledger(point, Of::Stop), lens);
    let field = match round {
        true => {
            let step = film[0].hypot(film[1]) / 2.0 / (RADII - 1) as f64;
            let nodes = (0..RADII).into_par_iter().map(|i| shares([step * i as f64, 0.0]));
            Field { nodes: nodes.collect(), counts: [RADII, 1] }
        }
        false => {
            let [columns, rows] = CELLS.map(|cells| cells + 1);
            let place = |axis: usize, i: usize| film[axis] * (i as f64 / CELLS[axis] as f64 - 0.5);
            let nodes = (0..columns * rows).into_par_iter();
            let nodes = nodes.map(|i| shares([place(0, i % columns), place(1, i / columns)]));
            Field { nodes: nodes.collect(), counts: [columns, rows] }
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
    Layer { name: "vignetting".to_owned(), channels: values.collect() }
}

/// The share that passes and what each row takes.
fn shares(ledger: Option<Ledger>, lens: &RealLens) -> Vec<f32> {
    let mut shares = vec![0.0; lens.prescription.rows.len() + 1];
    match ledger {
        None => shares[lens.prescription.rows.len()] = 1.0,
        Some(ledger) => {
            shares[0] = ledger.pass as f32;
            for (share, row) in shares[1..].iter_mut().zip(&ledger.rows) {
                *share = row.share() as f32;
            }
        }
    }
    shares
}

/// The value of every pixel that is rendered, by where among the nodes its centre lies, from 0
/// to 1 along both sides of their grid.
fn pixels(
    lens: &RealLens,
    film: [f64; 2],
    frame: &Frame,
    value: impl Fn([f64; 2]) -> f32,
) -> Vec<f32> {
    let round = lens.is_round();
    let mut values = Vec::with_capacity(frame.size().map(|n| n as usize).iter().product());
    for y in frame.low[1]..frame.high[1] {
        for x in frame.low[0]..frame.high[0] {
            let share =
                |v: u32, axis: usize| (f64::from(v) + 0.5) / f64::from(frame.resolution[axis]);
            // The picture on the film is upside down: its right lies at negative x, its lower
            // edge at positive y.
            let place = [1.0 - share(x, 0), share(y, 1)];
            values.push(value(match round {
                true => {
                    let [x, y] = [0, 1].map(|axis| (place[axis] - 0.5) * film[axis]);
                    [x.hypot(y) / (film[0].hypot(film[1]) / 2.0), 0.0]
                }
                false => place,
            }));
        }
    }
    values
}

/// Shares at the nodes of a grid.
struct Field {
    nodes: Vec<Vec<f32>>,
    counts: [usize; 2],
}

impl Field {
    /// Between four nodes, in proportion.
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
