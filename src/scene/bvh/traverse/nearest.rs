//! Nearest hit of a ray so far, and its update by a packet of triangles.

use super::LeafIntersector;
use super::ray::TraversalRay;
use super::triangles::{intersect_triangles, is_ahead};
use crate::bvh::{Bvh, PrimitiveId};
use petzval_base::lanes::Real;
use petzval_base::rays::{Hit, NO_INDEX};

/// Nearest hit so far during a traversal. The id of its triangle is looked up at the end.
#[derive(Clone, Copy, Debug)]
pub(crate) struct NearestHit {
    /// Distance of the hit, or the end of the ray if there is none.
    pub(crate) t: f32,
    /// Barycentric weights of the second and the third corner.
    pub(super) weights: [f32; 2],
    /// Eight times the index of the triangle's packet, plus its lane; [`NO_INDEX`] if no triangle
    /// of this hierarchy was hit.
    pub(super) triangle_slot: u32,
    /// Shape, primitive and instance of a hit on a patch, on a curve, on a quadric or in an
    /// instance; otherwise [`NO_INDEX`].
    non_triangle: [u32; 3],
}

impl NearestHit {
    /// Starts without a hit on a ray that ends at `t_max`.
    #[inline(always)]
    pub(crate) fn new(t_max: f32) -> Self {
        Self { t: t_max, weights: [0.0; 2], triangle_slot: NO_INDEX, non_triangle: [NO_INDEX; 3] }
    }

    /// Returns the hit that the traversal of `bvh` has found.
    #[inline(always)]
    pub(crate) fn hit(&self, bvh: &Bvh) -> Hit {
        let [shape, primitive, instance] = match self.triangle_slot {
            NO_INDEX => self.non_triangle,
            slot => {
                let PrimitiveId { shape, triangle } = primitive_id(bvh, slot);
                [shape, triangle, NO_INDEX]
            }
        };
        let [u, v] = self.weights;
        Hit { t: self.t, u, v, shape, primitive, instance, ..Hit::MISS }
    }

    /// Returns whether a patch or a segment of a curve is nearer. At equal distances the one with the
    /// lower id wins, as for triangles.
    #[inline(always)]
    pub(super) fn is_beyond_patch(&self, t: f32, id: PrimitiveId) -> bool {
        let [shape, triangle, _] = self.non_triangle;
        t < self.t || t == self.t && shape != NO_INDEX && id < PrimitiveId { shape, triangle }
    }

    /// Takes over a hit on a patch, on a curve, on a quadric or in an instance.
    #[inline(always)]
    pub(crate) fn replace(&mut self, hit: &Hit) {
        self.t = hit.t;
        self.weights = [hit.u, hit.v];
        self.triangle_slot = NO_INDEX;
        self.non_triangle = [hit.shape, hit.primitive, hit.instance];
    }
}

/// Returns the id of the triangle in a slot.
#[inline(always)]
fn primitive_id(bvh: &Bvh, slot: u32) -> PrimitiveId {
    bvh.primitive_ids[slot as usize / 8].0[slot as usize % 8]
}

/// Intersects a ray with a packet of opaque triangles. Returns whether it found a nearer hit.
#[inline(always)]
pub(super) fn intersect_packet<R: Real<Scalar = f32>, const ANY: bool>(
    bvh: &Bvh,
    number: u32,
    ray: &TraversalRay,
    nearest: &mut NearestHit,
) -> bool {
    let packet = &bvh.packets[number as usize];
    let hits = intersect_triangles::<R>(packet, ray, nearest.t);
    let (mut mask, mut found) = (hits.mask, false);
    while mask != 0 {
        let lane = mask.trailing_zeros();
        mask &= mask - 1;
        let t = hits.distance(lane as usize);
        let slot = number * 8 + lane;
        if is_nearer(bvh, t, slot, nearest) && is_ahead(packet, lane as usize, ray, t) {
            if ANY {
                return true;
            }
            (nearest.t, nearest.triangle_slot) = (t, slot);
            nearest.weights = hits.weights(lane as usize);
            found = true;
        }
    }
    found
}

/// Returns whether a triangle is nearer than the nearest hit. At equal distances the triangle with
/// the lower id wins, so the result does not depend on the order of traversal.
#[inline(always)]
pub(super) fn is_nearer(bvh: &Bvh, t: f32, slot: u32, nearest: &NearestHit) -> bool {
    t < nearest.t
        || t == nearest.t
            && nearest.triangle_slot != NO_INDEX
            && primitive_id(bvh, slot) < primitive_id(bvh, nearest.triangle_slot)
}

/// Intersects a ray with a packet of triangles that need an alpha test, like [`intersect_packet`].
#[cold]
#[inline(never)]
pub(super) fn intersect_alpha_tested<R: Real<Scalar = f32>>(
    bvh: &Bvh,
    number: u32,
    leaves: &impl LeafIntersector,
    ray: &TraversalRay,
    nearest: &mut NearestHit,
) -> bool {
    let packet = &bvh.packets[number as usize];
    let hits = intersect_triangles::<R>(packet, ray, nearest.t);
    let (mut mask, mut found) = (hits.mask, false);
    while mask != 0 {
        let lane = mask.trailing_zeros();
        mask &= mask - 1;
        let (t, weights) = (hits.distance(lane as usize), hits.weights(lane as usize));
        let slot = number * 8 + lane;
        if is_nearer(bvh, t, slot, nearest)
            && is_ahead(packet, lane as usize, ray, t)
            && leaves.passes_alpha_test(ray, &alpha_hit(bvh, slot, weights))
        {
            (nearest.t, nearest.triangle_slot, nearest.weights) = (t, slot, weights);
            found = true;
        }
    }
    found
}

/// Returns the hit of an alpha test, without its distance: no alpha of a triangle depends on it.
fn alpha_hit(bvh: &Bvh, slot: u32, [u, v]: [f32; 2]) -> Hit {
    let PrimitiveId { shape, triangle: primitive } = primitive_id(bvh, slot);
    Hit { t: 0.0, u, v, shape, primitive, ..Hit::MISS }
}
