//! Capacity of the hierarchies: the number of primitives that they can index.

use super::{Geometry, SceneBuilder};

/// Reason why a scene does not fit into the hierarchies. Primitives are triangles, patches, pieces of
/// curves, quadrics and instances.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum SceneTooLarge {
    /// More shapes than indices.
    #[error("the scene has {found} shapes, but at most {max} are possible: join meshes")]
    Shapes {
        /// Number of shapes.
        found: u64,
        /// Largest possible number.
        max: u64,
    },
    /// Too many primitives outside objects.
    #[error(
        "the world holds {found} triangles, quadrics and instances, but at most {max} are possible: \
         move shapes into objects, and place each as an instance"
    )]
    World {
        /// Number of primitives.
        found: u64,
        /// Largest possible number.
        max: u64,
    },
    /// Too many primitives in one object.
    #[error(
        "an object holds {found} triangles and quadrics, but at most {max} are possible: split it \
         into several objects"
    )]
    Object {
        /// Number of primitives.
        found: u64,
        /// Largest possible number.
        max: u64,
    },
}

impl SceneBuilder {
    /// Checks the numbers of shapes and primitives. The world counts its animated instances too,
    /// because `Scene::freeze` adds them to its hierarchy.
    pub(super) fn check_size(&self, max: u64) -> Result<(), SceneTooLarge> {
        let found = self.shapes.len() as u64;
        if found > max {
            return Err(SceneTooLarge::Shapes { found, max });
        }
        let count = |all: &[u32]| -> u64 {
            let primitives = |shape: &u32| match &self.shapes[*shape as usize].geometry {
                Geometry::Mesh(mesh) => mesh.triangles.len() as u64,
                Geometry::Patches(patches) => patches.patches.len() as u64,
                Geometry::Curves(curves) => u64::from(curves.piece_count()),
                Geometry::Quadric(_) => 1,
            };
            all.iter().map(primitives).sum()
        };
        if let Some(found) = self.objects.iter().map(|all| count(all)).find(|&found| found > max) {
            return Err(SceneTooLarge::Object { found, max });
        }
        let found = count(&self.world) + (self.instances.len() + self.animated.len()) as u64;
        if found > max {
            return Err(SceneTooLarge::World { found, max });
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::{Bvh, Material, Mesh, ShapeSpec};
    use petzval_base::rays::NO_INDEX;

    /// Returns a builder with two triangles in the world, one in an object, and one instance.
    fn small() -> SceneBuilder {
        let mut builder = SceneBuilder::default();
        let material = builder.add_material(Material::diffuse([0.5; 3]));
        let object = builder.add_object();
        for (object, triangles) in [(None, 2), (Some(object), 1)] {
            let positions = vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
            let mesh = Mesh { positions, triangles: vec![[0, 1, 2]; triangles], ..Mesh::default() };
            let geometry = Geometry::Mesh(mesh);
            builder.add_shape(ShapeSpec { object, ..ShapeSpec::new(geometry, material) });
        }
        builder.add_instance(object, DAffine3::IDENTITY);
        builder
    }

    #[test]
    fn a_scene_at_the_limit_is_accepted_and_one_primitive_more_is_refused() {
        let builder = small();
        assert_eq!(builder.check_size(3), Ok(()));
        assert_eq!(builder.check_size(2), Err(SceneTooLarge::World { found: 3, max: 2 }));
        assert_eq!(builder.check_size(1), Err(SceneTooLarge::Shapes { found: 2, max: 1 }));
    }

    #[test]
    fn an_object_above_the_limit_is_refused() {
        let mut builder = small();
        let large = vec![1; 4];
        builder.objects.push(large);
        assert_eq!(builder.check_size(3), Err(SceneTooLarge::Object { found: 4, max: 3 }));
    }

    #[test]
    fn the_largest_index_of_a_hierarchy_fits_into_a_triangle_slot() {
        assert!(Bvh::MAX_PRIMITIVES * 8 <= u64::from(NO_INDEX));
    }
}
