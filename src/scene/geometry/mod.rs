//! Geometry of shapes: triangle meshes and quadrics, and the tessellation of other shapes into
//! meshes.

mod bilinear;
mod curve;
mod mesh;
mod quadric;
mod subdivision;
mod surface_packet;
mod surface_point;
mod triangle;

pub use bilinear::tessellate_patches;
pub use curve::{CurveSegment, tessellate_curve};
pub use mesh::Mesh;
pub(super) use quadric::{DiskPacket, QuadricSurface};
pub use quadric::{Quadric, QuadricForm, Sphere};
pub use subdivision::{SubdivisionError, subdivide};
pub use surface_packet::{SurfaceDerivativesPacket, SurfacePacket};
pub use surface_point::{SurfaceDerivatives, SurfacePoint, gamma};
pub(super) use triangle::{ShadingTriangle, TriangleLanes};

use glam::DVec3;

use crate::rays::Hit;

/// Triangles or a quadric.
#[derive(Clone, Debug)]
pub enum Geometry {
    /// Triangles.
    Mesh(Mesh),
    /// A sphere, cylinder, disk or cone.
    Quadric(Quadric),
}

impl Geometry {
    /// Returns whether it is a mesh for which [`Mesh::is_smooth`] holds.
    pub fn is_smooth(&self) -> bool {
        match self {
            Self::Mesh(mesh) => mesh.is_smooth(),
            Self::Quadric(_) => false,
        }
    }

    /// Returns the surface point at a hit, object space. Only quadrics call `near`, which returns
    /// the point that was hit to rounding, object space.
    pub(super) fn point(&self, hit: &Hit, near: impl FnOnce() -> DVec3) -> SurfacePoint {
        match self {
            Self::Mesh(mesh) => mesh.point(hit),
            Self::Quadric(quadric) => quadric.point(near()),
        }
    }

    /// Returns the surface derivatives at a hit, object space; see [`Self::point`].
    pub(super) fn derivatives(
        &self,
        hit: &Hit,
        near: impl FnOnce() -> DVec3,
    ) -> SurfaceDerivatives {
        match self {
            Self::Mesh(mesh) => mesh.derivatives(hit),
            Self::Quadric(quadric) => quadric.derivatives(near()),
        }
    }
}
