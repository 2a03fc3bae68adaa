//! Field zones: the parts of the film that have a point spread of their own.

use glam::DMat2;
use rayon::prelude::*;

use super::mapped_spread::{Outline, PupilShape};
use crate::film::Frame;
use petzval_lens::{ExitPupil, RealLens, RealRayFocus, Wavefront, WavefrontFit};

/// Nodes along each side of the finest grid.
const FINE_NODES: usize = 5;
/// Nodes along each side of the grid of light that is spread far.
const FAR_NODES: usize = 3;
/// How much more than near the centre pupils may differ that share a table of light that is spread far.
const FAR_TOLERANCE: f64 = 6.0;
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

/// Place of a zone in a grid over the picture. Its weight is 1 at its node, and decreases linearly to 0 at the
/// neighbouring nodes: the weights of all zones add up to 1.
#[derive(Clone, Copy, Debug)]
pub(super) struct GridNode {
    node: [usize; 2],
    /// Nodes along each side of the grid.
    nodes: usize,
}

impl GridNode {
    /// Returns the nodes of a grid, row by row.
    fn all(nodes: usize) -> impl Iterator<Item = Self> {
        (0..nodes * nodes).map(move |i| Self { node: [i % nodes, i / nodes], nodes })
    }

    /// Returns its place in the finest grid; in the middle if there is only one node.
    fn in_fine_grid(self) -> usize {
        match self.nodes {
            1 => FINE_NODES * FINE_NODES / 2,
            _ => {
                let step = (FINE_NODES - 1) / (self.nodes - 1);
                self.node[1] * step * FINE_NODES + self.node[0] * step
            }
        }
    }

    /// Returns its place relative to the picture, from 0 to 1.
    pub fn place(self) -> [f64; 2] {
        match self.nodes {
            1 => [0.5; 2],
            _ => self.node.map(|i| i as f64 / (self.nodes - 1) as f64),
        }
    }

    /// Returns the weight of the zone at a place relative to the picture, from 0 to 1.
    pub fn weight_at(self, place: [f64; 2]) -> f64 {
        if self.nodes == 1 {
            return 1.0;
        }
        let axis = |i: usize| {
            let place = place[i] * (self.nodes - 1) as f64;
            (1.0 - (place - self.node[i] as f64).abs()).max(0.0)
        };
        axis(0) * axis(1)
    }

    /// Returns the weight of the zone at a pixel of a picture.
    pub fn weight(self, pixel: [usize; 2], size: [usize; 2]) -> f64 {
        self.weight_at([0, 1].map(|i| (pixel[i] as f64 + 0.5) / size[i] as f64))
    }

    /// Returns the pixels along an axis that the zone has light of.
    pub fn pixels(self, axis: usize, size: usize) -> std::ops::Range<usize> {
        if self.nodes == 1 {
            return 0..size;
        }
        let cell = size as f64 / (self.nodes - 1) as f64;
        let middle = cell * self.node[axis] as f64;
        let first = (middle - cell - 0.5).ceil().max(0.0) as usize;
        let end = (middle + cell - 0.5).floor() as usize + 1;
        first..end.min(size)
    }
}

/// A pupil and its wavefront, with its place over the picture.
#[derive(Clone, Debug)]
pub(super) struct FieldZone {
    pub pupil: ExitPupil,
    /// That of a point in the plane of focus; `None` if film or elements
    /// are tilted or decentred.
    pub wavefront: Option<WavefrontFit>,
    pub shape: PupilShape,
    pub grid: GridNode,
}

/// The zones of a picture.
#[derive(Clone, Debug, Default)]
pub(super) struct FieldZones {
    /// Zones of the light that is spread near.
    pub near: Vec<FieldZone>,
    /// Zones of the light that is spread far: fewer, since the far spread changes less.
    pub far: Vec<(PupilShape, GridNode)>,
    /// The pupils that have tables of their spread.
    pub bases: Vec<ExitPupil>,
    /// How many of them spread light far; the others come behind.
    pub far_bases: usize,
}

/// Returns the zones of the rendered part of a film: 1, 9 or 25 near, depending on how much the widths
/// of the pupil differ, and at least 9 if a wavefront is aberrated, and 9 far at most; none if all of it is
/// dark.
pub(super) fn field_zones(lens: &RealLens, film: [f64; 2], frame: &Frame) -> FieldZones {
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
    let Some(middle) = nearest_lit_zone(lens, focus, &at, [0.5; 2]) else {
        return FieldZones::default();
    };
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
    let outlines: Vec<Outline> = pupils.par_iter().map(|(pupil, _)| Outline::new(pupil)).collect();
    let mut shapes = Shapes::default();
    // The middle first: others are narrower, so that its table reaches far enough for them.
    shapes.of(&outlines[central], FAR_TOLERANCE);
    let far = GridNode::all(nodes.min(FAR_NODES))
        .map(|node| (shapes.of(&outlines[node.in_fine_grid()], FAR_TOLERANCE), node));
    let far: Vec<(PupilShape, GridNode)> = far.collect();
    let far_bases = shapes.bases.len();
    let near =
        GridNode::all(nodes).map(|node| (shapes.of(&outlines[node.in_fine_grid()], 1.0), node));
    let near: Vec<(PupilShape, GridNode)> = near.collect();
    let zone = |(shape, grid): (PupilShape, GridNode)| {
        let (pupil, wavefront) = &pupils[grid.in_fine_grid()];
        let wavefront = wavefront.as_ref().and_then(WavefrontFit::new);
        FieldZone { pupil: pupil.clone(), wavefront, shape, grid }
    };
    let near = near.into_par_iter().map(zone).collect();
    let bases = shapes.bases.iter().map(|outline| outline.pupil().clone()).collect();
    FieldZones { near, far, bases, far_bases }
}

/// Pupils that have tables of their spread.
#[derive(Default)]
struct Shapes<'a> {
    bases: Vec<&'a Outline<'a>>,
}

impl<'a> Shapes<'a> {
    /// Returns the shape of a pupil: the affine image of one that has a table, or one that now has its own.
    fn of(&mut self, pupil: &'a Outline<'a>, tolerance: f64) -> PupilShape {
        let images = self.bases.par_iter().map(|base| base.map_to(pupil, tolerance));
        let images: Vec<Option<DMat2>> = images.collect();
        let known = images.into_iter().enumerate();
        known.filter_map(|(base, map)| Some(PupilShape { base, map: map? })).next().unwrap_or_else(
            || {
                self.bases.push(pupil);
                PupilShape::own(self.bases.len() - 1)
            },
        )
    }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_add_up_to_one_within_the_pixels_of_their_zones() {
        for nodes in [1, 3, 5] {
            for size in (1..13).map(|n| [n, 2 * n]).chain([[600, 401]]) {
                for i in (0..size[0] * size[1]).step_by(1 + size[0] / 100) {
                    let pixel = [i % size[0], i / size[0]];
                    let mut sum = 0.0;
                    for node in GridNode::all(nodes) {
                        let weight = node.weight(pixel, size);
                        let covers = (0..2).all(|k| node.pixels(k, size[k]).contains(&pixel[k]));
                        assert!(weight == 0.0 || covers, "{nodes}, {size:?}: {pixel:?}");
                        sum += weight;
                    }
                    assert!((sum - 1.0).abs() < 1e-12, "{nodes}, {size:?}, {pixel:?}: {sum}");
                }
            }
        }
    }
}
