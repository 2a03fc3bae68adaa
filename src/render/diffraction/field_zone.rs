//! Field zones: the parts of the film that have a point spread of their own.

use rayon::prelude::*;

use crate::film::Frame;
use petzval_lens::{ExitPupil, RealLens, RealRayFocus, Wavefront, WavefrontFit};

/// Nodes along each side of the finest grid.
const FINE_NODES: usize = 5;
/// Directions in which the widths of pupils are compared.
const DIRECTIONS: usize = 12;
/// Largest relative difference of pupil widths at which one zone serves the whole film. The Airy
/// radius differs by the same ratio.
const UNIFORM_DIFFERENCE: f64 = 0.05;
/// Largest relative difference of neighbouring nodes of the coarse grid; beyond it the fine grid is
/// used. Half-way between such nodes, the mean of two discs that are 15 % too wide and too narrow
/// puts the light within 1 % of the total at any radius.
const COARSE_DIFFERENCE: f64 = 0.3;

/// Root mean square path differences (mm) between which neither a flat wavefront nor rays alone
/// serve: a fourteenth of a wave of green light (Marechal 1943), and two waves.
const ABERRATED: std::ops::Range<f64> = 0.55e-3 / 14.0..1.1e-3;

/// A pupil, its wavefront and its weight over the picture: 1 at a node of a grid, decreasing linearly to 0 at the
/// neighbouring nodes. The weights of all zones add up to 1.
#[derive(Clone, Debug)]
pub(super) struct FieldZone {
    pub pupil: ExitPupil,
    /// That of a point in the plane of focus; `None` if film or elements
    /// are tilted or decentred.
    pub wavefront: Option<WavefrontFit>,
    node: [usize; 2],
    /// Nodes along each side of the grid.
    nodes: usize,
}

impl FieldZone {
    /// Returns the weight of the zone at a pixel of a picture.
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

/// Returns the zones of the rendered part of a film: 1, 9 or 25, depending on how much the widths
/// of the pupil differ, and at least 9 if a wavefront is aberrated; none if all of it is dark.
pub(super) fn field_zones(lens: &RealLens, film: [f64; 2], frame: &Frame) -> Vec<FieldZone> {
    let at = |share: [f64; 2]| {
        let place = |i: usize| {
            let pixel = f64::from(frame.low[i]) + share[i] * f64::from(frame.size()[i]);
            film[i] * (pixel / f64::from(frame.resolution[i]) - 0.5)
        };
        [-place(0), place(1)]
    };
    // A film too close for any focus is closest to that of distant points.
    let focus = RealRayFocus::new(&lens.prescription)
        .object_distance(lens.film_distance)
        .unwrap_or(f64::INFINITY);
    let Some(middle) = nearest_lit_zone(lens, focus, &at, [0.5; 2]) else { return Vec::new() };
    let share = |k: usize| k as f64 / (FINE_NODES - 1) as f64;
    let nodes = (0..FINE_NODES * FINE_NODES)
        .into_par_iter()
        .map(|i| [share(i % FINE_NODES), share(i / FINE_NODES)]);
    let pupils: Vec<(ExitPupil, Option<Wavefront>)> = nodes
        .map(|share| nearest_lit_zone(lens, focus, &at, share).unwrap_or_else(|| middle.clone()))
        .collect();
    let widths: Vec<[f64; DIRECTIONS]> = pupils.iter().map(|(pupil, _)| widths(pupil)).collect();
    let aberrated = pupils.iter().flat_map(|(_, front)| front).any(|w| ABERRATED.contains(&w.rms));
    let most = |pairs: &mut dyn Iterator<Item = (usize, usize)>| {
        pairs.map(|(a, b)| largest_difference(&widths[a], &widths[b])).fold(0.0, f64::max)
    };
    let central = FINE_NODES * FINE_NODES / 2;
    let nodes = if most(&mut (0..FINE_NODES * FINE_NODES).map(|i| (central, i)))
        <= UNIFORM_DIFFERENCE
        && !aberrated
    {
        1
    } else {
        let is_even = |n: usize| n.is_multiple_of(2);
        let coarse = (0..FINE_NODES * FINE_NODES)
            .filter(|i| is_even(i % FINE_NODES) && is_even(i / FINE_NODES));
        let mut pairs = coarse.flat_map(|i| {
            let right = (i % FINE_NODES + 2 < FINE_NODES).then_some((i, i + 2));
            let below = (i / FINE_NODES + 2 < FINE_NODES).then_some((i, i + 2 * FINE_NODES));
            right.into_iter().chain(below)
        });
        if most(&mut pairs) <= COARSE_DIFFERENCE { 3 } else { FINE_NODES }
    };
    let grid = (0..nodes * nodes).map(|i| [i % nodes, i / nodes]);
    grid.map(|node| {
        let place = match nodes {
            1 => central,
            _ => {
                let step = (FINE_NODES - 1) / (nodes - 1);
                node[1] * step * FINE_NODES + node[0] * step
            }
        };
        let (pupil, wavefront) = &pupils[place];
        let wavefront = wavefront.as_ref().and_then(WavefrontFit::new);
        FieldZone { pupil: pupil.clone(), wavefront, node, nodes }
    })
    .collect()
}

/// Returns the pupil and the wavefront at a position in the picture; if it is dark, of the nearest
/// lit position towards the centre.
fn nearest_lit_zone(
    lens: &RealLens,
    focus: f64,
    at: &(impl Fn([f64; 2]) -> [f64; 2] + Sync),
    share: [f64; 2],
) -> Option<(ExitPupil, Option<Wavefront>)> {
    const STEPS: usize = 12;
    (0..=STEPS).find_map(|step| {
        let rest = 1.0 - step as f64 / STEPS as f64;
        let film = at(share.map(|v| 0.5 + rest * (v - 0.5)));
        let pupil = ExitPupil::trace(lens, film)?;
        let wavefront = Wavefront::from_distance(lens, film, &pupil, focus);
        Some((pupil, wavefront))
    })
}

fn widths(pupil: &ExitPupil) -> [f64; DIRECTIONS] {
    std::array::from_fn(|i| pupil.width(std::f64::consts::PI * i as f64 / DIRECTIONS as f64))
}

/// Returns the largest ratio of widths, minus 1.
fn largest_difference(a: &[f64; DIRECTIONS], b: &[f64; DIRECTIONS]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a / b).max(b / a) - 1.0).fold(0.0, f64::max)
}
