//! Geometry of shapes: triangle meshes, bilinear patches, curves and quadrics, and the tessellation
//! of other shapes into meshes.

mod bilinear;
mod curve;
mod displacement;
mod mesh;
mod patch;
mod patch_mesh;
mod quadric;
mod subdivision;
mod surface_packet;
mod surface_point;
mod triangle;

pub use bilinear::split_patches;
pub use curve::{
    CubicPoints, CurveCrossing, CurveKind, CurvePiece, CurveRay, CurveSegment, CurveSet,
    PieceBounds, tessellate_curve,
};
pub use mesh::Mesh;
pub use patch_mesh::PatchMesh;
pub(super) use quadric::{DiskPacket, QuadricSurface};
pub use quadric::{Quadric, QuadricForm, Sphere};
pub use subdivision::{SubdivisionError, subdivide};
pub use surface_packet::{SurfaceDerivativesPacket, SurfacePacket};
pub use surface_point::{SurfaceDerivatives, SurfacePoint, gamma};
pub(super) use triangle::{ShadingTriangle, TriangleLanes};

use glam::DVec3;

use petzval_base::rays::Hit;

/// A point of a ray, and the ray's direction.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RayPoint {
    /// Position.
    pub position: DVec3,
    /// Direction, of any length.
    pub direction: DVec3,
}

/// Triangles, bilinear patches, curves or a quadric.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// Triangles.
    Mesh(Mesh),
    /// Bilinear patches.
    Patches(PatchMesh),
    /// Curves with a width.
    Curves(CurveSet),
    /// A sphere, cylinder, disk or cone.
    Quadric(Quadric),
}

/// Most triangles of patches that emit light, unless there are more patches.
const MAX_EMITTERS: u64 = 1 << 20;

impl Geometry {
    /// Returns a shape that can emit light: patches and curves become triangles.
    pub fn into_emitter(self) -> Self {
        match self {
            Self::Patches(patches) => Self::Mesh(patches.tessellate(MAX_EMITTERS)),
            Self::Curves(curves) => Self::Mesh(curves.tessellate()),
            Self::Mesh(_) | Self::Quadric(_) => self,
        }
    }

    /// Returns whether it is a mesh for which [`Mesh::is_smooth`] holds.
    pub fn is_smooth(&self) -> bool {
        match self {
            Self::Mesh(mesh) => mesh.is_smooth(),
            Self::Patches(_) | Self::Curves(_) | Self::Quadric(_) => false,
        }
    }

    /// Returns the colour of the vertices at a hit, linear RGB and opacity, if they have one.
    pub fn vertex_colour(&self, hit: &Hit) -> Option<[f32; 4]> {
        match self {
            Self::Mesh(mesh) => mesh.colour(hit),
            Self::Patches(_) | Self::Curves(_) | Self::Quadric(_) => None,
        }
    }

    /// Returns the surface point at a hit, object space. Only quadrics and curves call `near`,
    /// which returns the point that was hit to rounding, and the ray's direction, object space.
    pub(super) fn point(&self, hit: &Hit, near: impl FnOnce() -> RayPoint) -> SurfacePoint {
        match self {
            Self::Mesh(mesh) => mesh.point(hit),
            Self::Patches(patches) => patches.point(hit),
            Self::Curves(curves) => curves.point(hit, &near()),
            Self::Quadric(quadric) => quadric.point(near().position),
        }
    }

    /// Returns the surface derivatives at a hit, object space; see [`Self::point`].
    pub(super) fn derivatives(
        &self,
        hit: &Hit,
        near: impl FnOnce() -> RayPoint,
    ) -> SurfaceDerivatives {
        match self {
            Self::Mesh(mesh) => mesh.derivatives(hit),
            Self::Patches(patches) => patches.derivatives(hit),
            Self::Curves(curves) => curves.derivatives(hit, &near()),
            Self::Quadric(quadric) => quadric.derivatives(near().position),
        }
    }
}
