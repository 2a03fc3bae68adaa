//! Columns of the path vertices of a wave, sorted by the kind of their material.

use std::ops::Range;

use super::bsdf::{BsdfKind, KIND_COUNT, MisWeights};
use super::glossy_lobe::VertexLobes;
use super::kind_stage::ParameterColumns;
use super::sort::MaterialRun;
use petzval_base::rays::{PathFlags, SortedColumn};
use petzval_base::stats::LaneOccupancy;
use petzval_scene::{LightColumns, LightSamples, SurfaceColumns, VectorColumns};

/// Path vertices of a wave: the surfaces that its rays hit, and the results of shading them. Large parts
/// have boxes of their own, as those of a wave do.
#[derive(Clone, Debug, Default)]
pub(super) struct Vertices {
    /// Range of each kind in the columns.
    pub(super) ranges: [Range<usize>; KIND_COUNT],
    /// Ranges of the materials, in the order of the columns.
    pub(super) runs: Vec<MaterialRun>,
    /// Kind and material index of every ray's hit, by ray.
    pub(super) kinds: Vec<(BsdfKind, u32)>,
    /// Number of hits by material, while they are sorted; otherwise 0.
    pub(super) counts: Vec<u32>,
    /// Index of the vertex's ray in the wave; 0 in the gaps between kinds.
    pub(super) order: Vec<u32>,
    /// Surface points, world space.
    pub(super) surfaces: Box<SurfaceColumns>,
    /// Tangent along u, world space; 0 if any will do.
    pub(super) tangent: VectorColumns,
    /// Unit shading normal, world space.
    pub(super) normal: VectorColumns,
    /// Unit vector to where the path came from, world space.
    pub(super) wo: VectorColumns,
    /// Throughput of the path up to the vertex.
    pub(super) throughput: VectorColumns,
    /// Scale of the throughput for Russian roulette.
    pub(super) roulette_scale: SortedColumn<f32>,
    /// Flags that a path keeps from vertex to vertex.
    pub(super) flags: SortedColumn<PathFlags>,
    /// Index of the path's sample in the wave.
    pub(super) slot: SortedColumn<u32>,
    /// Parameters of the BSDFs.
    pub(super) parameters: Box<ParameterColumns>,
    /// Weights of the walks that evaluate coats.
    pub(super) coat_weights: MisWeights,
    /// Unit shading normal on the side from which light counts, world space; 0 if it counts from
    /// both sides.
    pub(super) facing: VectorColumns,
    /// Lobes of the glossy ones.
    pub(super) lobes: VertexLobes,
    /// Vertices whose BSDF is not singular.
    pub(super) lit: Vec<u32>,
    /// Work columns of light sampling.
    pub(super) light_columns: Box<LightColumns>,
    /// Sampled lights.
    pub(super) lights: Box<LightSamples>,
    /// Radiance that the sampled light contributes to the sample if nothing occludes it.
    pub(super) contribution: VectorColumns,
    /// Next direction, world space.
    pub(super) next: VectorColumns,
    /// Throughput along the next direction; 0 if the path ends.
    pub(super) next_throughput: VectorColumns,
    /// Density of the next direction, by solid angle; of no use if it is specular.
    pub(super) next_pdf: SortedColumn<f32>,
    /// Flags of the path along the next direction.
    pub(super) next_flags: SortedColumn<PathFlags>,
    /// Squared ratio of refractive indices, see [`super::bsdf::BsdfSample::eta2`].
    pub(super) next_eta2: SortedColumn<f32>,
}

impl Vertices {
    /// Memory of its boxes (bytes).
    pub(super) const BOXED_BYTES: usize = size_of::<SurfaceColumns>()
        + size_of::<ParameterColumns>()
        + size_of::<LightColumns>()
        + size_of::<LightSamples>();

    /// Returns the lane occupancy of the packets of all kinds.
    pub(super) fn occupancy(&self) -> LaneOccupancy {
        let mut occupancy = LaneOccupancy::default();
        for (range, _) in self.shaded_ranges() {
            occupancy.add(LaneOccupancy::packed(range.len()));
        }
        occupancy
    }

    /// Returns the range of every kind that scatters.
    pub(super) fn shaded_ranges(&self) -> impl Iterator<Item = (Range<usize>, BsdfKind)> + use<> {
        let ranges = self.ranges.clone().into_iter().zip(BsdfKind::ALL);
        ranges.filter(|(_, kind)| *kind != BsdfKind::Interface)
    }

    /// Returns the indices of all vertices of surfaces that scatter.
    pub(super) fn indices(&self) -> impl Iterator<Item = usize> + use<> {
        self.shaded_ranges().flat_map(|(range, _)| range)
    }

    /// Returns the first vertex that has a next direction. With `skip_mis`, diffuse surfaces have
    /// none.
    pub(super) fn first_spawning(&self, skip_mis: bool) -> usize {
        if skip_mis { self.ranges[BsdfKind::Diffuse as usize].end.next_multiple_of(8) } else { 0 }
    }

    /// Returns the end of the last packet.
    pub(super) fn end(&self) -> usize {
        let ends = self.ranges.iter().filter(|range| !range.is_empty());
        ends.map(|range| range.end.next_multiple_of(8)).max().unwrap_or(0)
    }
}

/// Returns the i-th vector of columns.
#[inline(always)]
pub(super) fn vector(columns: &VectorColumns, i: usize) -> [f32; 3] {
    [columns[0][i], columns[1][i], columns[2][i]]
}
