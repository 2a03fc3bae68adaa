//! Traversal by a single ray.

use super::boxes::intersect_boxes;
use super::curves::intersect_curves;
use super::nearest::{NearestHit, intersect_alpha_tested, intersect_packet};
use super::patches::intersect_patches;
use super::quadrics::intersect_quadric;
use super::ray::TraversalRay;
use crate::bvh::{Bvh, Child, Node, PackedChild};
use crate::geometry::CurveSet;
use petzval_base::lanes::Real;
use petzval_base::rays::Hit;

/// Stack of the children that a ray has yet to visit. Each worker reuses one.
#[derive(Clone, Debug, Default)]
pub struct TraversalStack(Vec<u64>);

impl TraversalStack {
    /// Returns at least `count` slots for sort keys of children.
    #[inline(always)]
    pub(crate) fn slots(&mut self, count: usize) -> &mut [u64] {
        if self.0.len() < count {
            self.0.resize(count, 0);
        }
        &mut self.0
    }
}

/// Callback for what a hierarchy does not know.
pub(crate) trait LeafIntersector {
    /// Intersects a ray with an instance. Returns whether it found a nearer hit. `pending` is the
    /// free part of the stack.
    fn intersect_instance<R: Real<Scalar = f32>, const ANY: bool>(
        &self,
        instance: u32,
        ray: &TraversalRay,
        nearest: &mut NearestHit,
        pending: &mut [u64],
    ) -> bool;

    /// Returns the curves of a shape, if it has any.
    fn curves(&self, shape: u32) -> Option<&CurveSet>;

    /// Returns whether the alpha test keeps a hit.
    fn passes_alpha_test(&self, ray: &TraversalRay, hit: &Hit) -> bool;
}

/// Traverses a hierarchy below one of its children. With `ANY`, it stops at the first hit. Returns
/// whether it found a nearer hit.
#[inline(always)]
pub(crate) fn traverse<R: Real<Scalar = f32>, const ANY: bool>(
    bvh: &Bvh,
    leaves: &impl LeafIntersector,
    from: PackedChild,
    ray: &TraversalRay,
    nearest: &mut NearestHit,
    pending: &mut [u64],
) -> bool {
    let mut found = false;
    let mut top = 0;
    let mut packed = from;
    loop {
        let entered = match packed.node() {
            Some(i) => {
                intersect_children::<R, ANY>(&bvh.nodes[i], ray, nearest.t, pending, &mut top)
            }
            None => {
                let is_hit = match packed.unpack() {
                    Child::Triangles(i) => intersect_packet::<R, ANY>(bvh, i, ray, nearest),
                    Child::AlphaTestedTriangles(i) => {
                        intersect_alpha_tested::<R>(bvh, i, leaves, ray, nearest)
                    }
                    Child::Quadric(i) => intersect_quadric(bvh, i, leaves, ray, nearest),
                    Child::Instance(i) => {
                        leaves.intersect_instance::<R, ANY>(i, ray, nearest, &mut pending[top..])
                    }
                    Child::Patches(i) => intersect_patches::<R, ANY>(bvh, i, leaves, ray, nearest),
                    Child::Curves(i) => intersect_curves::<R, ANY>(bvh, i, leaves, ray, nearest),
                    // Found above.
                    Child::Node(_) => false,
                };
                found |= is_hit;
                if ANY && is_hit {
                    return true;
                }
                None
            }
        };
        packed = match entered {
            Some(packed) => packed,
            None => {
                // Keys sort by distance: greater keys are beyond the nearest hit.
                let farthest = u64::from(nearest.t.to_bits()) << 32 | u64::from(u32::MAX);
                loop {
                    if top == 0 {
                        return found;
                    }
                    top -= 1;
                    let key = pending[top];
                    if key <= farthest {
                        break PackedChild::from_key(key);
                    }
                }
            }
        };
    }
}

/// Intersects a ray with the boxes of a node. Returns the nearest child that it enters, if any;
/// pushes the others onto the stack, the nearest on top.
#[inline(always)]
fn intersect_children<R: Real<Scalar = f32>, const ANY: bool>(
    node: &Node,
    ray: &TraversalRay,
    t_max: f32,
    pending: &mut [u64],
    top: &mut usize,
) -> Option<PackedChild> {
    let mut enters = [0.0; 8];
    let mut mask = intersect_boxes::<R>(node, ray, t_max, &mut enters);
    if mask == 0 {
        return None;
    }
    let mut next = || {
        let i = mask.trailing_zeros() as usize & 7;
        mask &= mask - 1;
        (node.children[i].key(enters[i]), mask != 0)
    };
    let (mut nearest, mut more) = next();
    let bottom = *top;
    while more {
        let key;
        (key, more) = next();
        push_child::<ANY>(key.max(nearest), bottom, pending, top);
        nearest = key.min(nearest);
    }
    Some(PackedChild::from_key(nearest))
}

/// Pushes a child onto the stack. The children of a node stay sorted, the nearest on top, unless
/// any hit will do.
#[inline(always)]
pub(super) fn push_child<const ANY: bool>(
    key: u64,
    bottom: usize,
    pending: &mut [u64],
    top: &mut usize,
) {
    let mut slot = *top;
    if !ANY {
        // Insertion sort, since a ray enters few children.
        while slot > bottom && pending[slot - 1] < key {
            pending[slot] = pending[slot - 1];
            slot -= 1;
        }
    }
    pending[slot] = key;
    *top += 1;
}
