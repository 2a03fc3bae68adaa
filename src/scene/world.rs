//! Hierarchies over the shapes of an object, and over the static shapes and instances of the world.

use super::bvh::{PlacedQuadric, PrimitiveGroup, PrimitiveList};
use super::transform::{round_outward, to_f64, transform_box};
use super::{Bvh, Geometry, Instance, Shape};
use petzval_base::rays::NO_INDEX;

/// Builds the hierarchy over the shapes of an object.
pub(super) fn build_object(shapes: &[Shape], included: &[u32]) -> Bvh {
    build(shapes, included, PrimitiveList::default())
}

/// Builds the hierarchy over the static shapes and instances.
///
/// An instance of a single quadric becomes a quadric of the world: its rays need neither a
/// transform nor a hierarchy of their own.
pub(super) fn build_world(
    shapes: &[Shape],
    included: &[u32],
    objects: &[Bvh],
    instances: &[Instance],
) -> Bvh {
    let mut primitives = PrimitiveList::default();
    for (number, instance) in instances.iter().enumerate() {
        let (number, object) = (number as u32, &objects[instance.object as usize]);
        // In f32 like the surface points of the instance, so that rays meet those very points.
        let matrix = to_f64(&instance.pose.world_from_object);
        let placed = object.only_quadric().and_then(|shape| {
            let quadric = shapes[shape as usize].quadric()?;
            Some((shape, quadric.instanced(&matrix)?))
        });
        if let Some((shape, (surface, bounds))) = placed {
            let quadric = PlacedQuadric { surface, shape, instance: number, alpha_tested: false };
            primitives.push_quadric(quadric, round_outward(bounds));
        } else if let Some([low, high]) = object.bounds {
            let bounds = transform_box([low.as_dvec3(), high.as_dvec3()], &matrix);
            primitives.push(PrimitiveGroup::Instance(number, bounds));
        }
    }
    build(shapes, included, primitives)
}

/// Builds the hierarchy over some of the shapes and the given primitives.
fn build<'a>(shapes: &'a [Shape], included: &[u32], mut primitives: PrimitiveList<'a>) -> Bvh {
    for &shape in included {
        let Shape { geometry, alpha, .. } = &shapes[shape as usize];
        let alpha_tested = alpha.is_some();
        match geometry {
            Geometry::Mesh(mesh) => {
                primitives.push(PrimitiveGroup::Mesh { shape, mesh, alpha_tested });
            }
            Geometry::Patches(patches) => {
                primitives.push(PrimitiveGroup::Patches { shape, patches, alpha_tested });
            }
            Geometry::Curves(curves) => {
                primitives.push(PrimitiveGroup::Curves { shape, curves, alpha_tested });
            }
            Geometry::Quadric(quadric) => {
                let (surface, instance) = (quadric.surface(), NO_INDEX);
                let placed = PlacedQuadric { surface, shape, instance, alpha_tested };
                primitives.push_quadric(placed, round_outward(quadric.bounds()));
            }
        }
    }
    Bvh::new(primitives)
}
