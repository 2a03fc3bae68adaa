//! The vertices of paths in a wave, sorted by the kind of their surface.

use std::ops::Range;

use super::bsdf::{Coated, Conductor, Diffuse};
use super::kind::{KINDS, Kind, NUMBERS};
use crate::rays::{Column, WAVE};
use crate::scene::SurfacePoint;
use crate::stats::Lanes;

/// Every kind begins at a whole packet.
const ROOM: usize = WAVE + 8 * KINDS;

/// A column with room for the gaps between kinds.
pub(super) type Sorted<T> = Column<T, ROOM>;

/// A vector a lane.
pub(super) type Vectors = [Sorted<f32>; 3];

/// What shading knows of the surfaces that the rays of a wave met, and what it makes of it.
#[derive(Clone, Debug, Default)]
pub(super) struct Vertices {
    /// Where each kind stands.
    pub(super) ranges: [Range<usize>; KINDS],
    /// Kind and material of every ray's hit.
    pub(super) kinds: Vec<(Kind, u32)>,
    /// Which ray of the wave a vertex belongs to.
    pub(super) ray: Vec<u32>,
    /// Where it is.
    pub(super) points: Vec<SurfacePoint>,
    /// Tangent along u and shading normal, world space.
    pub(super) tangent: Vectors,
    pub(super) normal: Vectors,
    /// Unit vector to where the path came from, world space.
    pub(super) wo: Vectors,
    /// What the path has left.
    pub(super) throughput: Vectors,
    pub(super) roulette_scale: Sorted<f32>,
    pub(super) slot: Vec<u32>,
    /// What the kind needs.
    pub(super) numbers: [Sorted<f32>; NUMBERS],
    pub(super) coated_diffuse: Vec<Coated<Diffuse<f32>>>,
    pub(super) coated_conductor: Vec<Coated<Conductor<f32>>>,
    /// A light: unit vector to it, its radiance over the density of the choice, and that
    /// density, 0 where no other ray can run into it.
    pub(super) wi: Vectors,
    pub(super) light: Vectors,
    pub(super) light_density: Sorted<f32>,
    /// The shadow ray to it: direction and end.
    pub(super) shadow: Vec<([f32; 3], f32)>,
    /// What it brings to the film if nothing is in its way.
    pub(super) brings: Vectors,
    /// Random numbers for the next direction: two for its place, one for its lobe.
    pub(super) dice: Vectors,
    pub(super) roulette: Vec<f32>,
    pub(super) seeds: Vec<u32>,
    /// The next direction, its throughput (0 for none), its density and its square of the index.
    pub(super) next: Vectors,
    pub(super) next_throughput: Vectors,
    pub(super) next_density: Sorted<f32>,
    pub(super) next_eta2: Sorted<f32>,
}

impl Vertices {
    /// How full the packets are of kinds that are shaded in packets.
    pub(super) fn lanes(&self) -> Lanes {
        let mut lanes = Lanes::default();
        for (range, kind) in self.ranges.iter().zip(Kind::ALL) {
            if !kind.coated() {
                lanes.add(Lanes::packed(range.len()));
            }
        }
        lanes
    }

    /// Where all vertices stand.
    pub(super) fn places(&self) -> impl Iterator<Item = usize> + use<> {
        self.ranges.clone().into_iter().flatten()
    }
}

/// The i-th vector of columns.
#[inline(always)]
pub(super) fn vector(columns: &Vectors, i: usize) -> [f32; 3] {
    [columns[0][i], columns[1][i], columns[2][i]]
}

/// Sets the i-th vector of columns.
#[inline(always)]
pub(super) fn set(columns: &mut Vectors, i: usize, to: [f32; 3]) {
    for axis in 0..3 {
        columns[axis][i] = to[axis];
    }
}
