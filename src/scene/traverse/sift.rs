//! Which rays of a wave come near to a box at all.

use glam::Vec3;

use crate::lanes::Real;
use crate::rays::RayBatch;

/// More than three roundings on either side of a comparison.
const SLACK: f64 = 1e-6;

/// Of the rays from `first` on, a packet of them, which may meet a box before they end, as bits:
/// for certain all that do. A NaN decides nothing.
#[inline(always)]
pub(in crate::scene) fn near<R: Real<Scalar = f32>>(
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
        // Along a side of the box itself, a ray that does not leave it or enter it has NaNs.
        let known = a.same(a) & b.same(b);
        enters = R::select(known, a.min(b), enters).max(enters);
        leaves = R::select(known, a.max(b), leaves).min(leaves);
    }
    let leaves = leaves * R::constant(1.0 + 2.0 * SLACK);
    !R::bits(leaves.lt(enters)) & ((1 << R::LANES) - 1)
}
