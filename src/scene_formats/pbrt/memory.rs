//! Memory that a scene takes, claimed from the budget before it is allocated.

use glam::DAffine3;

use super::SceneError;
use super::params::Params;
use super::reader::SceneReader;
use petzval_base::io::{HeldMemory, Location};
use petzval_scene::{Bvh, Geometry, Instance};

/// Turns a refusal of the budget into an error at a location.
pub(super) fn granted<T>(
    at: &Location,
    what: &str,
    answer: Result<T, String>,
) -> Result<T, SceneError> {
    let expected = "use a smaller scene, a larger 'memory' or a larger machine";
    answer.map_err(|found| SceneError::limit(at.clone(), format!("{what}: {found}"), expected))
}

/// Numbers of vertices and triangles.
#[derive(Clone, Copy)]
pub(super) struct MeshSize {
    pub(super) vertices: u64,
    pub(super) triangles: u64,
}

/// Holds the memory of a mesh that is still to be made, and its tree. The mesh claims its own once it is
/// there.
pub(super) fn require_memory(
    params: &Params,
    what: &str,
    size: MeshSize,
) -> Result<HeldMemory, SceneError> {
    const VERTEX: u64 = size_of::<[f32; 8]>() as u64;
    const TRIANGLE: u64 =
        size_of::<[u32; 3]>() as u64 + Bvh::BYTES_PER_PRIMITIVE + Bvh::BUILD_BYTES_PER_PRIMITIVE;
    let MeshSize { vertices, triangles } = size;
    let bytes = vertices.saturating_mul(VERTEX).saturating_add(triangles.saturating_mul(TRIANGLE));
    granted(&params.at, what, params.context.hold(bytes))
}

/// Memory of an instance: in the description, in the scene and in its tree (bytes).
pub(crate) const INSTANCE_BYTES: u64 =
    INSTANCE + Bvh::BYTES_PER_PRIMITIVE + Bvh::BUILD_BYTES_PER_PRIMITIVE;
const INSTANCE: u64 =
    (size_of::<(u32, DAffine3)>() + size_of::<Instance>()) as u64 + Bvh::BYTES_PER_QUADRIC;

impl SceneReader {
    /// Claims the memory of a shape in an object, or in the world.
    pub(super) fn claim_shape(
        &mut self,
        name: &str,
        object: Option<u32>,
        geometry: &Geometry,
    ) -> Result<(), SceneError> {
        let (items, bytes) = match geometry {
            Geometry::Mesh(mesh) => (mesh.triangles.len() as u64, mesh.bytes()),
            Geometry::Patches(mesh) => {
                let count = mesh.patches.len() as u64;
                (count, mesh.bytes() + count * Bvh::BYTES_PER_PATCH)
            }
            Geometry::Curves(curves) => (u64::from(curves.piece_count()), curves.bytes()),
            Geometry::Quadric(quadric) => (1, size_of_val(quadric) as u64 + Bvh::BYTES_PER_QUADRIC),
        };
        self.claim(&format!("a {name}"), object, items, bytes)
    }

    /// Claims the memory of instances in the world.
    pub(super) fn claim_instances(&mut self, count: u64) -> Result<(), SceneError> {
        self.claim("an instance of an object", None, count, count.saturating_mul(INSTANCE))
    }

    /// Claims `bytes`, and those of so many more items in a tree. Requires that the memory which
    /// the building of the tree needs for a time is there, too.
    fn claim(
        &mut self,
        what: &str,
        object: Option<u32>,
        items: u64,
        bytes: u64,
    ) -> Result<(), SceneError> {
        let count = self.primitive_counts.entry(object).or_default();
        *count = count.saturating_add(items);
        let build = count.saturating_mul(Bvh::BUILD_BYTES_PER_PRIMITIVE);
        let bytes = bytes.saturating_add(items.saturating_mul(Bvh::BYTES_PER_PRIMITIVE));
        // Trees are built one after another once all is read.
        let built = |()| self.context.hold(build).map(drop);
        granted(&self.at, what, self.context.claim(bytes).and_then(built))
    }
}
