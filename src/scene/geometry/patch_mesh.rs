//! Bilinear patches over shared vertices.

use glam::{DAffine3, Vec3};

use super::mesh::Mesh;
use super::patch::ShadingPatch;
use super::surface_point::{SurfaceDerivatives, SurfacePoint};
use petzval_base::rays::Hit;

/// Bilinear patches over shared vertices, in the space of the object that they belong to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct PatchMesh {
    /// Vertices. This mesh has no triangles.
    pub vertices: Mesh,
    /// Indices of four vertices for each patch, at (u, v) = (0, 0), (1, 0), (0, 1) and (1, 1).
    pub patches: Vec<[u32; 4]>,
}

impl PatchMesh {
    /// Transforms the patches; see [`Mesh::transform`].
    pub fn transform(&mut self, matrix: &DAffine3, reversed: bool) {
        self.vertices.transform(matrix, reversed);
    }

    /// Removes the patches that have a vertex that is not finite and returns their number. Such
    /// vertices, normals and texture coordinates become 0.
    pub fn drop_non_finite(&mut self) -> usize {
        let all = self.patches.len();
        let positions = &self.vertices.positions;
        let finite = |&i: &u32| Vec3::from(positions[i as usize]).is_finite();
        self.patches.retain(|patch| patch.iter().all(finite));
        self.vertices.drop_non_finite();
        all - self.patches.len()
    }

    /// Returns the memory of vertices and indices (bytes).
    pub fn bytes(&self) -> u64 {
        self.vertices.bytes() + size_of_val(&self.patches[..]) as u64
    }

    /// Returns the corners of a patch.
    #[inline(always)]
    pub fn corners(&self, patch: u32) -> [Vec3; 4] {
        self.patches[patch as usize].map(|i| Vec3::from(self.vertices.positions[i as usize]))
    }

    /// Returns the vertex data of a patch.
    #[inline(always)]
    pub fn patch(&self, index: u32) -> ShadingPatch<f32> {
        let Mesh { positions, normals, uvs, flipped, .. } = &self.vertices;
        let corners = self.patches[index as usize];
        let mut patch = ShadingPatch {
            positions: corners.map(|i| positions[i as usize]),
            normals: [[0.0; 3]; 4],
            uvs: [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]],
            side: if *flipped { -1.0 } else { 1.0 },
        };
        if !normals.is_empty() {
            patch.normals = corners.map(|i| normals[i as usize]);
        }
        if !uvs.is_empty() {
            patch.uvs = corners.map(|i| uvs[i as usize]);
        }
        patch
    }

    /// Returns the point of the surface at a hit.
    pub fn point(&self, hit: &Hit) -> SurfacePoint {
        self.patch(hit.primitive).point(hit.u, hit.v).into()
    }

    /// Returns the texture coordinates at a hit, and the derivatives with respect to them.
    pub fn derivatives(&self, hit: &Hit) -> SurfaceDerivatives {
        self.patch(hit.primitive).derivatives(hit.u, hit.v).into()
    }
}
