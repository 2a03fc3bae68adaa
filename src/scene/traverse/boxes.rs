//! One ray against eight boxes.

use super::ray::Prepared;
use crate::lanes::Real;
use crate::scene::tree::Node;

/// Which boxes the ray meets before `t_max`, as bits, and where it enters each of the eight. Errs
/// on the side of a hit.
#[inline(always)]
pub(super) fn boxes<R: Real<Scalar = f32>>(
    node: &Node,
    ray: &Prepared,
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
        let ([nx, ny, nz], [fx, fy, fz]) = (ray.near, ray.far);
        let near = at(bx, 0, nx).max(at(by, 1, ny)).max(at(bz, 2, nz).max(R::constant(0.0)));
        let far = at(1 - bx, 0, fx).min(at(1 - by, 1, fy));
        let far = far.min(at(1 - bz, 2, fz).min(R::splat(t_max)));
        mask |= R::bits(near.le(far)) << lane;
        near.store(&mut enters[lane..]);
    }
    mask
}
