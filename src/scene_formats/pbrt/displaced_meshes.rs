//! PLY meshes that a texture displaces when they are read.

use glam::{DAffine3, Vec3};

use super::memory::{MeshSize, require_memory};
use super::params::Params;
use super::reader::SceneReader;
use super::{SceneError, meshes};
use crate::ply::PlyMeshes;
use petzval_scene::{Mesh, PatchMesh, TexturePoint};

/// Limit of the vertices of a displaced mesh, whatever the memory.
const MAX_VERTICES: u64 = 1 << 28;

impl SceneReader {
    /// Makes the mesh of a plymesh, or its triangles and patches if nothing displaces it.
    pub(super) fn ply_shape(
        &mut self,
        name: &str,
        params: &Params,
    ) -> Result<(Mesh, PatchMesh), SceneError> {
        if params.find("displacement").is_none() {
            let PlyMeshes { mut flat, mut curved } = meshes::ply_mesh(params)?;
            self.drop_non_finite(name, params, &mut flat, &mut curved);
            return Ok((flat, curved));
        }
        let mut mesh = meshes::ply_triangles(params)?;
        self.drop_non_finite(name, params, &mut mesh, &mut PatchMesh::default());
        self.displace(params, &mut mesh)?;
        Ok((mesh, PatchMesh::default()))
    }

    /// Refines and displaces a mesh in the space of its shape.
    fn displace(&mut self, params: &Params, mesh: &mut Mesh) -> Result<(), SceneError> {
        let edge = ["displacement.edgelength", "edgelength"]
            .into_iter()
            .find(|name| params.find(name).is_some())
            .unwrap_or("edgelength");
        let longest = params.positive(edge, 1.0)? * self.displacement_edge_scale;
        if mesh.uvs.is_empty() {
            let found = "a displaced mesh without texture coordinates";
            return Err(params.refuse("displacement", found, "expected u and v in the PLY file"));
        }
        let Some(texture) = self.library.number_or_texture(params, "displacement")? else {
            return Ok(());
        };
        if let Some(missing) = self.library.missing.take() {
            let found =
                format!("no texture \"{}\" before the mesh that it displaces", missing.name);
            return Err(SceneError::at(missing.at, found, "define it before this Shape"));
        }
        // The heights are needed at once.
        for error in self.library.image_files.read(&self.context) {
            self.report(error);
        }
        // The mesh claims its own memory once it is whole.
        let mut held = None;
        let world_from_shape: DAffine3 = self.state.ctm[0];
        let world = |p: Vec3| world_from_shape.transform_point3(p.as_dvec3());
        mesh.refine(
            |a, b| world(a).distance(world(b)),
            longest,
            |count| {
                let vertices = count as u64;
                if vertices > MAX_VERTICES {
                    let found = format!("a displaced mesh of more than {MAX_VERTICES} vertices");
                    return Err(params.refuse(edge, found, "expected a greater edge length"));
                }
                // There are twice as many triangles, and an entry for each edge that is split.
                let size = MeshSize { vertices: 3 * vertices, triangles: 2 * vertices };
                let what = format!("a displaced mesh of {vertices} vertices");
                held = None;
                held = Some(require_memory(params, &what, size)?);
                Ok(())
            },
        )?;
        let to_normal = world_from_shape.matrix3.inverse().transpose();
        mesh.displace(|p, normal, uv| {
            let normal = (to_normal * normal.as_dvec3()).normalize_or_zero();
            texture.scalar(&TexturePoint {
                uv,
                position: world(p).as_vec3().to_array(),
                normal: normal.as_vec3().to_array(),
                ..TexturePoint::default()
            })
        });
        if mesh.positions.iter().flatten().all(|v| v.is_finite()) {
            return Ok(());
        }
        let found = "a displacement that is not a finite number";
        Err(params.refuse("displacement", found, "check the texture"))
    }
}
