//! Columns of the path vertices of a wave, sorted by the kind of their material.

use std::ops::Range;

use super::bsdf::{Coated, Conductor, Diffuse};
use super::bsdf_kind::{BsdfKind, KIND_COUNT};
use super::bsdf_parameters::PARAMETER_COUNT;
use crate::rays::{Column, WAVE_SIZE};
use crate::scene::SurfacePoint;
use crate::stats::LaneOccupancy;

/// Entries of a column. Every kind begins at a whole packet.
const CAPACITY: usize = WAVE_SIZE + 8 * KIND_COUNT;

/// A column with room for the gaps between kinds.
pub(super) type VertexColumn<T> = Column<T, CAPACITY>;

/// A vector for every vertex.
pub(super) type VectorColumns = [VertexColumn<f32>; 3];

/// Path vertices of a wave: the surfaces that its rays hit, and the results of shading them.
#[derive(Clone, Debug, Default)]
pub(super) struct Vertices {
    /// Range of each kind in the columns.
    pub(super) ranges: [Range<usize>; KIND_COUNT],
    /// Kind and material index of every ray's hit, by ray.
    pub(super) kinds: Vec<(BsdfKind, u32)>,
    /// Index of the vertex's ray in the wave.
    pub(super) ray: Vec<u32>,
    /// Surface point, world space.
    pub(super) points: Vec<SurfacePoint>,
    /// Tangent along u, world space.
    pub(super) tangent: VectorColumns,
    /// Unit shading normal, world space.
    pub(super) normal: VectorColumns,
    /// Unit vector to where the path came from, world space.
    pub(super) wo: VectorColumns,
    /// Throughput of the path up to the vertex.
    pub(super) throughput: VectorColumns,
    /// Scale of the throughput for Russian roulette.
    pub(super) roulette_scale: VertexColumn<f32>,
    /// Index of the path's sample in the wave.
    pub(super) slot: Vec<u32>,
    /// Parameters of the BSDF, for kinds without a coat.
    pub(super) parameters: [VertexColumn<f32>; PARAMETER_COUNT],
    /// BSDFs of coated diffuse surfaces, in the order of their range.
    pub(super) coated_diffuse: Vec<Coated<Diffuse<f32>>>,
    /// BSDFs of coated conductors, in the order of their range.
    pub(super) coated_conductor: Vec<Coated<Conductor<f32>>>,
    /// Unit vector to the sampled light, world space.
    pub(super) wi: VectorColumns,
    /// Radiance from the sampled light over the density of the sample; 0 if there is none.
    pub(super) light: VectorColumns,
    /// Density of the light sample, by solid angle; infinite if no other ray can hit the light.
    pub(super) light_pdf: VertexColumn<f32>,
    /// Direction and `t_max` of the shadow ray.
    pub(super) shadow: Vec<([f32; 3], f32)>,
    /// Radiance that the sampled light contributes to the sample if nothing occludes it.
    pub(super) contribution: VectorColumns,
    /// Random numbers for the next direction: two choose the direction, one the lobe.
    pub(super) bsdf_random: VectorColumns,
    /// Random number for Russian roulette.
    pub(super) roulette: Vec<f32>,
    /// Seed of random walks inside the surface.
    pub(super) seeds: Vec<u32>,
    /// Next direction, world space.
    pub(super) next: VectorColumns,
    /// Throughput along the next direction; 0 if the path ends.
    pub(super) next_throughput: VectorColumns,
    /// Density of the next direction, by solid angle; infinite if it is specular.
    pub(super) next_pdf: VertexColumn<f32>,
    /// Squared ratio of refractive indices, see [`super::bsdf::BsdfSample::eta2`].
    pub(super) next_eta2: VertexColumn<f32>,
}

impl Vertices {
    /// Returns the lane occupancy of the kinds that are shaded in packets.
    pub(super) fn occupancy(&self) -> LaneOccupancy {
        let mut occupancy = LaneOccupancy::default();
        for (range, kind) in self.ranges.iter().zip(BsdfKind::ALL) {
            if !kind.is_coated() {
                occupancy.add(LaneOccupancy::packed(range.len()));
            }
        }
        occupancy
    }

    /// Returns the indices of all vertices in the columns.
    pub(super) fn indices(&self) -> impl Iterator<Item = usize> + use<> {
        self.ranges.clone().into_iter().flatten()
    }
}

/// Returns the i-th vector of columns.
#[inline(always)]
pub(super) fn vector(columns: &VectorColumns, i: usize) -> [f32; 3] {
    [columns[0][i], columns[1][i], columns[2][i]]
}

/// Sets the i-th vector of columns.
#[inline(always)]
pub(super) fn set(columns: &mut VectorColumns, i: usize, to: [f32; 3]) {
    for axis in 0..3 {
        columns[axis][i] = to[axis];
    }
}
