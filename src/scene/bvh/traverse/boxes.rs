//! Ray-box tests: one ray with the eight boxes of a node, and the rays of a wave with one box.

use glam::Vec3;

use super::ray::TraversalRay;
use crate::bvh::Node;
use petzval_base::lanes::Real;
use petzval_base::rays::RayBatch;

/// Returns the boxes that a ray enters before `t_max`, as a bit mask, and writes the entry distance
/// of each box. Rounding may add boxes to the mask but never drops one.
#[inline(always)]
pub(super) fn intersect_boxes<R: Real<Scalar = f32>>(
    node: &Node,
    ray: &TraversalRay,
    t_max: f32,
    enters: &mut [f32; 8],
) -> u32 {
    let mut mask = 0;
    let [bx, by, bz] = ray.backward;
    let (bx, by, bz) = (bx & 1, by & 1, bz & 1);
    for lane in (0..8).step_by(R::LANES) {
        let at = |side: usize, axis: usize, [factor, term]: [f32; 2]| {
            R::load(&node.bounds[axis][side][lane..]).mul_add(R::splat(factor), R::splat(term))
        };
        let ([nx, ny, nz], [fx, fy, fz]) = (ray.entry, ray.exit);
        let near = at(bx, 0, nx).max(at(by, 1, ny)).max(at(bz, 2, nz).max(R::constant(0.0)));
        let far = at(1 - bx, 0, fx).min(at(1 - by, 1, fy));
        let far = far.min(at(1 - bz, 2, fz).min(R::splat(t_max)));
        mask |= R::bits(near.le(far)) << lane;
        near.store(&mut enters[lane..]);
    }
    mask
}

/// Relative slack of a comparison: more than three roundings on either side.
const SLACK: f64 = 1e-6;

/// Returns which of the [`Real::LANES`] rays from `first` on may hit a box before they end, as a
/// bit mask. Rays that hit it are always included, and so are rays with NaNs.
#[inline(always)]
pub(crate) fn may_hit_box<R: Real<Scalar = f32>>(
    rays: &RayBatch,
    first: usize,
    [low, high]: [Vec3; 2],
) -> u32 {
    let mut enters = R::constant(0.0);
    let mut leaves = R::load(&rays.t_max[first..]);
    for axis in 0..3 {
        let origin = R::load(&rays.origin[axis][first..]);
        let inverse = R::constant(1.0) / R::load(&rays.direction[axis][first..]);
        let a = (R::splat(low[axis]) - origin) * inverse;
        let b = (R::splat(high[axis]) - origin) * inverse;
        // A ray within the plane of a side has NaNs on this axis, which does not limit it.
        let known = a.equals(a) & b.equals(b);
        enters = R::select(known, a.min(b), enters).max(enters);
        leaves = R::select(known, a.max(b), leaves).min(leaves);
    }
    let leaves = leaves * R::constant(1.0 + 2.0 * SLACK);
    !R::bits(leaves.lt(enters)) & ((1 << R::LANES) - 1)
}
