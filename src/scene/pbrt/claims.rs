//! Memory that a scene takes, claimed from the budget before it is allocated.

use glam::DAffine3;

use super::SceneError;
use super::reader::Reader;
use crate::memory::budget;
use crate::scene::{Geometry, Instance, Tree};
use crate::source::Location;

/// Refuses what takes more memory than there is.
pub(super) fn granted(
    at: &Location,
    what: &str,
    answer: Result<(), String>,
) -> Result<(), SceneError> {
    let expected = "expected less; a larger --memory or machine may have it";
    answer.map_err(|found| SceneError::at(at.clone(), format!("{what}: {found}"), expected))
}

/// Refuses a mesh that is still to be made, of so many vertices and triangles, where there is no
/// memory to make it and its tree.
pub(super) fn mesh_fits(at: &Location, what: &str, counts: [u64; 2]) -> Result<(), SceneError> {
    const VERTEX: u64 = size_of::<[f32; 8]>() as u64;
    const TRIANGLE: u64 = size_of::<[u32; 3]>() as u64 + Tree::ITEM + Tree::BUILD;
    let [vertices, triangles] = counts;
    let bytes = vertices.saturating_mul(VERTEX).saturating_add(triangles.saturating_mul(TRIANGLE));
    granted(at, what, budget::fits(bytes))
}

impl Reader {
    /// Claims the memory of a shape in an object, or in the world.
    pub(super) fn claim_shape(
        &mut self,
        name: &str,
        object: Option<u32>,
        geometry: &Geometry,
    ) -> Result<(), SceneError> {
        let (items, bytes) = match geometry {
            Geometry::Mesh(mesh) => (mesh.triangles.len() as u64, mesh.bytes()),
            Geometry::Quadric(quadric) => (1, size_of_val(quadric) as u64),
        };
        self.claim(&format!("a {name}"), object, items, bytes)
    }

    /// Claims the memory of copies of objects in the world.
    pub(super) fn claim_copies(&mut self, copies: u64) -> Result<(), SceneError> {
        const COPY: u64 = (size_of::<(u32, DAffine3)>() + size_of::<Instance>()) as u64;
        self.claim("a copy of an object", None, copies, copies.saturating_mul(COPY))
    }

    /// Claims bytes, and those of so many more items in a tree, whose building takes more for a time.
    fn claim(
        &mut self,
        what: &str,
        object: Option<u32>,
        items: u64,
        bytes: u64,
    ) -> Result<(), SceneError> {
        let of_tree = self.items.entry(object).or_default();
        *of_tree = of_tree.saturating_add(items);
        let build = of_tree.saturating_mul(Tree::BUILD);
        let bytes = bytes.saturating_add(items.saturating_mul(Tree::ITEM));
        let answer = budget::claim(bytes).and_then(|()| budget::fits(build));
        granted(&self.at, what, answer)
    }
}
