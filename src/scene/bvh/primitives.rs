//! List of the primitives that a hierarchy is built over, by reference.

use glam::{DVec3, Vec3};

use super::PlacedQuadric;
use crate::geometry::{CurvePiece, CurveSet, Mesh, PatchMesh};
use crate::transform::round_outward;

/// The triangles or patches of a mesh, the pieces of curves, or one other primitive.
#[derive(Clone, Copy, Debug)]
pub(crate) enum PrimitiveGroup<'a> {
    /// The triangles of a mesh.
    Mesh {
        /// Index of the shape in the scene.
        shape: u32,
        /// Its triangles.
        mesh: &'a Mesh,
        /// Whether the shape has an alpha texture.
        alpha_tested: bool,
    },
    /// Bilinear patches.
    Patches {
        /// Index of the shape in the scene.
        shape: u32,
        /// Its patches.
        patches: &'a PatchMesh,
        /// Whether the shape has an alpha texture.
        alpha_tested: bool,
    },
    /// Curves.
    Curves {
        /// Index of the shape in the scene.
        shape: u32,
        /// Its curves.
        curves: &'a CurveSet,
        /// Whether the shape has an alpha texture.
        alpha_tested: bool,
    },
    /// A quadric: its index in [`PrimitiveList::quadrics`], and its box.
    Quadric(u32, [Vec3; 2]),
    /// An instance: its index, and its box.
    Instance(u32, [Vec3; 2]),
}

/// Primitives that share a packet.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum PacketKind {
    Triangles,
    Patches,
    Curves,
}

/// All primitives of a hierarchy, numbered in order: each triangle of a mesh is a
/// primitive, and so is each patch and each piece of a curve.
#[derive(Debug, Default)]
pub(crate) struct PrimitiveList<'a> {
    groups: Vec<PrimitiveGroup<'a>>,
    /// All quadrics of the list.
    pub(super) quadrics: Vec<PlacedQuadric>,
    /// Number of primitives up to the end of each group.
    ends: Vec<usize>,
}

impl<'a> PrimitiveList<'a> {
    /// Adds a group.
    pub(crate) fn push(&mut self, group: PrimitiveGroup<'a>) {
        let count = match group {
            PrimitiveGroup::Mesh { mesh, .. } => mesh.triangles.len(),
            PrimitiveGroup::Patches { patches, .. } => patches.patches.len(),
            PrimitiveGroup::Curves { curves, .. } => curves.piece_count() as usize,
            PrimitiveGroup::Quadric(..) | PrimitiveGroup::Instance(..) => 1,
        };
        self.ends.push(self.len() + count);
        self.groups.push(group);
    }

    /// Adds a quadric in a box.
    pub(crate) fn push_quadric(&mut self, quadric: PlacedQuadric, bounds: [Vec3; 2]) {
        self.push(PrimitiveGroup::Quadric(self.quadrics.len() as u32, bounds));
        self.quadrics.push(quadric);
    }

    /// Returns the number of primitives.
    pub(super) fn len(&self) -> usize {
        self.ends.last().copied().unwrap_or(0)
    }

    /// Returns the number of pieces of curves.
    pub(super) fn curve_piece_count(&self) -> usize {
        let count = |group: &PrimitiveGroup| match group {
            PrimitiveGroup::Curves { curves, .. } => curves.piece_count() as usize,
            _ => 0,
        };
        self.groups.iter().map(count).sum()
    }

    /// Returns the group of a primitive, and the primitive's index in it.
    pub(super) fn locate(&self, primitive: usize) -> (&PrimitiveGroup<'a>, u32) {
        let i = self.ends.partition_point(|&end| end <= primitive);
        let start = if i == 0 { 0 } else { self.ends[i - 1] };
        (&self.groups[i], (primitive - start) as u32)
    }

    /// Returns the kind of packet that holds a primitive, or `None` if it is a leaf of its own.
    pub(super) fn packet_kind(&self, primitive: usize) -> Option<PacketKind> {
        match self.locate(primitive).0 {
            PrimitiveGroup::Mesh { .. } => Some(PacketKind::Triangles),
            PrimitiveGroup::Patches { .. } => Some(PacketKind::Patches),
            PrimitiveGroup::Curves { .. } => Some(PacketKind::Curves),
            PrimitiveGroup::Quadric(..) | PrimitiveGroup::Instance(..) => None,
        }
    }

    /// Returns the index and the box of every primitive with finite bounds, but for triangles without an
    /// area. No ray hits the others.
    pub(super) fn finite_bounds(&self) -> impl Iterator<Item = (u32, [Vec3; 2])> {
        let starts = std::iter::once(0).chain(self.ends.iter().copied());
        let bounds = self.groups.iter().zip(starts).flat_map(|(group, start)| {
            let (mut mesh, mut patches, mut curves, mut single) = (None, None, None, None);
            match *group {
                PrimitiveGroup::Mesh { mesh: found, .. } => mesh = Some(found),
                PrimitiveGroup::Patches { patches: found, .. } => patches = Some(found),
                PrimitiveGroup::Curves { curves: found, .. } => curves = Some(found),
                PrimitiveGroup::Quadric(_, bounds) | PrimitiveGroup::Instance(_, bounds) => {
                    single = Some(bounds);
                }
            }
            let triangles = mesh.into_iter().flat_map(|mesh| {
                (0..mesh.triangles.len() as u32)
                    .map(|triangle| triangle_box(mesh.corners(triangle)))
            });
            let patches = patches.into_iter().flat_map(|mesh| {
                (0..mesh.patches.len() as u32).map(|patch| bounds_of(mesh.corners(patch)))
            });
            let pieces = curves
                .into_iter()
                .flat_map(|curves| curves.pieces().map(|piece| piece_box(curves, piece)));
            (start as u32..).zip(single.into_iter().chain(triangles).chain(patches).chain(pieces))
        });
        bounds.filter(|(_, [low, high])| low.is_finite() && high.is_finite())
    }
}

/// Returns the box around a piece of a curve.
fn piece_box(curves: &CurveSet, piece: CurvePiece) -> [Vec3; 2] {
    round_outward(curves.piece_bounds(piece).corners)
}

/// Returns the box around a triangle, or NaN if it is not finite or has no area: files hold many such
/// triangles in one place, and a ray that starts there would meet all of them.
fn triangle_box(corners: [Vec3; 3]) -> [Vec3; 2] {
    let [a, b, c] = corners.map(Vec3::as_dvec3);
    match (b - a).cross(c - a) == DVec3::ZERO {
        true => [Vec3::NAN; 2],
        false => bounds_of(corners),
    }
}

/// Returns the box around corners, or NaN if one is not finite.
fn bounds_of<const N: usize>(corners: [Vec3; N]) -> [Vec3; 2] {
    // The sum is finite only if all of its terms are.
    if corners.iter().sum::<Vec3>().is_finite() {
        corners.iter().fold([corners[0]; 2], |[low, high], &p| [low.min(p), high.max(p)])
    } else {
        [Vec3::NAN; 2]
    }
}
