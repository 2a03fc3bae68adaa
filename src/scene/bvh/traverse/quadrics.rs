//! Intersection of one ray with a quadric.

use super::LeafIntersector;
use super::nearest::NearestHit;
use super::ray::TraversalRay;
use crate::bvh::{Bvh, PlacedQuadric};
use petzval_base::rays::Hit;

impl PlacedQuadric {
    /// Returns a hit at a distance.
    #[inline(always)]
    pub(super) fn hit(&self, t: f32) -> Hit {
        let Self { shape, instance, .. } = *self;
        Hit { t, u: 0.0, v: 0.0, shape, primitive: 0, instance, ..Hit::MISS }
    }
}

/// Intersects a ray with a quadric. Returns whether it found a nearer hit.
#[inline(never)]
pub(super) fn intersect_quadric(
    bvh: &Bvh,
    number: u32,
    leaves: &impl LeafIntersector,
    ray: &TraversalRay,
    nearest: &mut NearestHit,
) -> bool {
    let quadric = &bvh.quadrics[number as usize];
    let [mut origin, direction] = [ray.origin, ray.direction].map(|v| v.map(f64::from));
    let mut start = 0.0;
    // A ray that fails the alpha test on the near side may hit the far side.
    loop {
        let t_max = f64::from(nearest.t) - start;
        let t = start + quadric.surface.intersect::<f64>(origin, direction, t_max);
        let hit = quadric.hit(t as f32);
        // False for a miss, which is NaN.
        let is_nearer = hit.t > 0.0 && hit.t < nearest.t;
        if !is_nearer {
            return false;
        }
        if !quadric.alpha_tested || leaves.passes_alpha_test(ray, &hit) {
            nearest.replace(&hit);
            return true;
        }
        start = t * (1.0 + 1e-9);
        for axis in 0..3 {
            origin[axis] = f64::from(ray.origin[axis]) + direction[axis] * start;
        }
    }
}
