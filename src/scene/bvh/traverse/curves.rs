//! Intersection of one ray with a packet of pieces of curves.
//!
//! The ray first tests the capsules around eight pieces at once. Most pieces are much thinner than
//! their boxes, so few remain for the exact test.

use super::LeafIntersector;
use super::nearest::NearestHit;
use super::ray::TraversalRay;
use crate::bvh::{Bvh, CurvePacket, PrimitiveId};
use crate::geometry::{CurvePiece, CurveRay};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{abs, cross, dot, splat};
use petzval_base::rays::Hit;

/// Bound on the rounding errors of [`CurvePacket::near_ray`], relative to the products of the
/// magnitudes: of the inputs (three roundings), the two products (five) and the comparison.
const ROUNDING: f32 = 16.0 * f32::EPSILON;

/// Intersects a ray with a packet of pieces of curves. Returns whether it found a nearer hit.
#[inline(never)]
pub(super) fn intersect_curves<R: Real<Scalar = f32>, const ANY: bool>(
    bvh: &Bvh,
    number: u32,
    leaves: &impl LeafIntersector,
    ray: &TraversalRay,
    nearest: &mut NearestHit,
) -> bool {
    let packet = &bvh.curves[number as usize];
    let mut left = packet.near_ray::<R>(ray);
    if left == 0 {
        return false;
    }
    let (curve_ray, mut found) = (CurveRay::new(ray.origin, ray.direction), false);
    while left != 0 {
        let lane = left.trailing_zeros() as usize & 7;
        left &= left - 1;
        let id = packet.ids.0[lane];
        let PrimitiveId { shape, triangle: segment } = id;
        let [part, parts] = packet.parts[lane];
        let piece = CurvePiece { segment, part, parts };
        let curves = leaves.curves(shape);
        let Some(crossing) = curves.and_then(|curves| curves.intersect(piece, &curve_ray)) else {
            continue;
        };
        let [t, u, v] = [crossing.t, crossing.u, crossing.v].map(|number| number as f32);
        let hit = Hit { t, u, v, shape, primitive: segment, ..Hit::MISS };
        let is_nearer = t > 0.0 && nearest.is_beyond_patch(t, id);
        if !is_nearer || packet.alpha_tested && !leaves.passes_alpha_test(ray, &hit) {
            continue;
        }
        nearest.replace(&hit);
        found = true;
        if ANY {
            return true;
        }
    }
    found
}

impl CurvePacket {
    /// Returns the pieces that a ray may hit, as a bit mask: the lines of the ray and of the chord
    /// pass each other within the radius.
    #[inline(always)]
    fn near_ray<R: Real<Scalar = f32>>(&self, ray: &TraversalRay) -> u32 {
        let mut mask = 0;
        let (origin, direction) = (splat::<R>(ray.origin), splat::<R>(ray.direction));
        let zero = R::splat(0.0);
        for lane in (0..8).step_by(R::LANES) {
            let (mut offset, mut chord, mut size) = ([zero; 3], [zero; 3], [zero; 3]);
            for axis in 0..3 {
                let start = R::load(&self.start[axis][lane..]);
                offset[axis] = start - origin[axis];
                size[axis] = start.abs() + origin[axis].abs();
                chord[axis] = R::load(&self.chord[axis][lane..]);
            }
            let across = cross(direction, chord);
            let sum = |v: [R; 3]| v[0].abs() + v[1].abs() + v[2].abs();
            let rounding = sum(size) * sum(chord) * sum(abs(direction)) * R::splat(ROUNDING);
            // The distance of the lines is this over the length of `across`.
            let volume = dot(offset, across).abs();
            let reach = R::load(&self.radius[lane..]).mul_add(dot(across, across).sqrt(), rounding);
            mask |= R::bits(volume.le(reach)) << lane;
        }
        mask
    }
}
