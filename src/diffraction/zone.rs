//! Field zones: where on the film the spread is worked out.

use rayon::prelude::*;

use crate::film::Frame;
use crate::lens::{ExitPupil, RealLens};

/// Nodes along each side of the finest grid.
const MOST: usize = 5;
/// Directions in which pupils are compared.
const DIRECTIONS: usize = 12;
/// Pupils whose widths differ by no more than this spread light alike: the share of the Airy
/// radius is that of the width.
const ALIKE: f64 = 0.05;
/// Between nodes that differ by more than this, more nodes are put: half-way, the mean of two discs
/// that are 15 % too wide and too narrow holds its light within 1 % of all at any radius.
const APART: f64 = 0.3;

/// A pupil and where in the picture it counts: fully at a node of a grid, and less and less
/// towards its neighbours. All zones together count 1 everywhere.
#[derive(Clone, Debug)]
pub(super) struct Zone {
    pub pupil: ExitPupil,
    node: [usize; 2],
    /// Nodes along each side of the grid.
    nodes: usize,
}

impl Zone {
    /// What the zone counts at a pixel of a picture.
    pub fn weight(&self, pixel: [usize; 2], size: [usize; 2]) -> f64 {
        if self.nodes == 1 {
            return 1.0;
        }
        let axis = |i: usize| {
            let place = (pixel[i] as f64 + 0.5) / size[i] as f64 * (self.nodes - 1) as f64;
            (1.0 - (place - self.node[i] as f64).abs()).max(0.0)
        };
        axis(0) * axis(1)
    }
}

/// The zones of the part of a film that is rendered: 1, 9 or 25 of them, by how much the widths of
/// the pupil differ. None where all of it is dark.
pub(super) fn zones(lens: &RealLens, film: [f64; 2], frame: &Frame) -> Vec<Zone> {
    let at = |share: [f64; 2]| {
        let place = |i: usize| {
            let pixel = f64::from(frame.low[i]) + share[i] * f64::from(frame.size()[i]);
            film[i] * (pixel / f64::from(frame.resolution[i]) - 0.5)
        };
        [-place(0), place(1)]
    };
    let Some(middle) = nearest(lens, &at, [0.5; 2]) else { return Vec::new() };
    let share = |k: usize| k as f64 / (MOST - 1) as f64;
    let nodes = (0..MOST * MOST).into_par_iter().map(|i| [share(i % MOST), share(i / MOST)]);
    let pupils: Vec<ExitPupil> =
        nodes.map(|share| nearest(lens, &at, share).unwrap_or_else(|| middle.clone())).collect();
    let widths: Vec<[f64; DIRECTIONS]> = pupils.iter().map(widths).collect();
    let most = |pairs: &mut dyn Iterator<Item = (usize, usize)>| {
        pairs.map(|(a, b)| difference(&widths[a], &widths[b])).fold(0.0, f64::max)
    };
    let central = MOST * MOST / 2;
    let nodes = if most(&mut (0..MOST * MOST).map(|i| (central, i))) <= ALIKE {
        1
    } else {
        let even = |n: usize| n.is_multiple_of(2);
        let coarse = (0..MOST * MOST).filter(|i| even(i % MOST) && even(i / MOST));
        let mut pairs = coarse.flat_map(|i| {
            let right = (i % MOST + 2 < MOST).then_some((i, i + 2));
            let below = (i / MOST + 2 < MOST).then_some((i, i + 2 * MOST));
            right.into_iter().chain(below)
        });
        if most(&mut pairs) <= APART { 3 } else { MOST }
    };
    let grid = (0..nodes * nodes).map(|i| [i % nodes, i / nodes]);
    grid.map(|node| {
        let place = match nodes {
            1 => central,
            _ => {
                let step = (MOST - 1) / (nodes - 1);
                node[1] * step * MOST + node[0] * step
            }
        };
        Zone { pupil: pupils[place].clone(), node, nodes }
    })
    .collect()
}

/// The pupil of a place of the picture, or where that is dark of one nearer to its middle.
fn nearest(
    lens: &RealLens,
    at: &(impl Fn([f64; 2]) -> [f64; 2] + Sync),
    share: [f64; 2],
) -> Option<ExitPupil> {
    const STEPS: usize = 12;
    (0..=STEPS).find_map(|step| {
        let rest = 1.0 - step as f64 / STEPS as f64;
        ExitPupil::seen(lens, at(share.map(|v| 0.5 + rest * (v - 0.5))))
    })
}

fn widths(pupil: &ExitPupil) -> [f64; DIRECTIONS] {
    std::array::from_fn(|i| pupil.width(std::f64::consts::PI * i as f64 / DIRECTIONS as f64))
}

/// The largest ratio of widths, less 1.
fn difference(a: &[f64; DIRECTIONS], b: &[f64; DIRECTIONS]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a / b).max(b / a) - 1.0).fold(0.0, f64::max)
}
