//! Tangents that meshes bring along, and the materials to which they matter.

use glam::Vec3;

use super::{Geometry, Material, MaterialModel, Scene, Shape};
use petzval_base::rays::{Hit, NO_INDEX};

/// Removes the tangents of meshes on whose materials they have no effect. Returns whether any mesh
/// keeps its own.
pub(super) fn drop_unused_tangents(shapes: &mut [Shape], materials: &[Material]) -> bool {
    let mut any = false;
    for shape in shapes {
        let Geometry::Mesh(mesh) = &mut shape.geometry else { continue };
        if mesh.tangents.is_empty() {
            continue;
        }
        if needs_tangent(materials, shape.material) {
            any = true;
        } else {
            mesh.tangents = Vec::new();
        }
    }
    any
}

/// Returns whether the direction of the shading frame matters to a material or to those that it
/// mixes.
fn needs_tangent(materials: &[Material], index: u32) -> bool {
    let mut todo = vec![index as usize];
    // Mixtures may share materials.
    let mut seen = vec![false; materials.len()];
    while let Some(index) = todo.pop() {
        let Some(material) = materials.get(index) else { continue };
        if std::mem::replace(&mut seen[index], true) {
            continue;
        }
        if material.needs_shading_tangent() {
            return true;
        }
        if let MaterialModel::Mix { materials, .. } = &material.model {
            todo.extend(materials.map(|index| index as usize));
        }
    }
    false
}

impl Scene {
    /// Returns whether a mesh has tangents of its own.
    pub fn has_tangents(&self) -> bool {
        self.tangents
    }

    /// Returns the tangent of the shading frame at a hit, of any length, world space; `None` if it
    /// follows the texture coordinates.
    pub fn tangent(&self, hit: &Hit) -> Option<Vec3> {
        let Geometry::Mesh(mesh) = &self.shapes[hit.shape as usize].geometry else { return None };
        let along = mesh.tangent(hit)?;
        if hit.instance == NO_INDEX {
            return Some(along);
        }
        // In the tangent plane before the transform, as in pbrt-v4.
        let normal = mesh.point(hit).shading_normal;
        let along = along - normal * normal.dot(along);
        Some(self.pose(hit.instance, hit.time).world_from_object.transform_vector3(along))
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use super::*;
    use crate::{ImageMap, Mapping, Mesh, SceneBuilder, ShapeSpec, Texture, Wrap};
    use petzval_image::Picture;

    #[test]
    fn tangents_are_kept_only_where_the_frame_matters() {
        let mut builder = SceneBuilder::default();
        let grey = builder.add_material(Material::diffuse([0.5; 3]));
        let map = ImageMap {
            picture: Arc::new(Picture { size: [1, 1], pixels: vec![[0.5, 0.5, 1.0]] }),
            mapping: Mapping::default(),
            wrap: Wrap::Clamp,
            top_down: true,
            scale: 1.0,
            invert: false,
        };
        let mapped = Material { normal_map: Some(map), ..Material::diffuse([0.5; 3]) };
        let mapped = builder.add_material(mapped);
        let amount = Texture::Constant([0.5; 3]);
        let mix = MaterialModel::Mix { materials: [grey, mapped], amount };
        let mix = builder.add_material(Material::new(mix));
        for material in [grey, mapped, mix] {
            let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
            let tangents = vec![[0.0, 1.0, 0.0]; 3];
            let triangles = vec![[0, 1, 2]];
            let mesh = Mesh { positions, triangles, tangents, ..Mesh::default() };
            builder.add_shape(ShapeSpec::new(Geometry::Mesh(mesh), material));
        }
        let scene = builder.build().unwrap();
        assert!(scene.has_tangents());
        let tangent =
            |shape| scene.tangent(&Hit { shape, primitive: 0, u: 0.25, v: 0.5, ..Hit::MISS });
        assert_eq!([0, 1, 2].map(tangent), [None, Some(Vec3::Y), Some(Vec3::Y)]);
    }
}
