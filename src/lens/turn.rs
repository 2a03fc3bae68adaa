//! From the frame of one surface to that of the next, where they do not stand square to each other.
//!
//! It is a stage of its own between the surfaces, so their kernels know nothing of it, and surfaces
//! that move as one body need none between them.

use glam::DAffine3;

use super::refract::{Crossed, Kernel, LensRay};
use crate::lanes::Real;

/// A turn and a shift: mm, +z along the direction of travel in both frames.
#[derive(Clone, Debug, PartialEq)]
pub struct Turn<T> {
    /// By column: where the old axes point in the new frame.
    columns: [[T; 3]; 3],
    /// Where the old origin stands in the new frame.
    shift: [T; 3],
}

impl<T: Copy> Turn<T> {
    /// Takes points of the old frame to the new one.
    pub(super) fn new<R: Real<Scalar = T>>(motion: &DAffine3) -> Self {
        Self {
            columns: motion.matrix3.to_cols_array_2d().map(|column| column.map(R::scalar)),
            shift: motion.translation.to_array().map(R::scalar),
        }
    }
}

/// A turn, in every lane.
#[derive(Clone, Copy)]
pub(super) struct TurnLanes<R> {
    columns: [[R; 3]; 3],
    shift: [R; 3],
}

impl<R: Real> TurnLanes<R> {
    #[inline(always)]
    pub fn of(turn: &Turn<R::Scalar>) -> Self {
        let splat = |v: [R::Scalar; 3]| [R::splat(v[0]), R::splat(v[1]), R::splat(v[2])];
        let [x, y, z] = turn.columns;
        Self { columns: [splat(x), splat(y), splat(z)], shift: splat(turn.shift) }
    }

    #[inline(always)]
    fn turned(&self, [x, y, z]: [R; 3]) -> [R; 3] {
        let [[xx, xy, xz], [yx, yy, yz], [zx, zy, zz]] = self.columns;
        [
            xx.mul_add(x, yx.mul_add(y, zx * z)),
            xy.mul_add(x, yy.mul_add(y, zy * z)),
            xz.mul_add(x, yz.mul_add(y, zz * z)),
        ]
    }
}

impl<R: Real> Kernel<R> for TurnLanes<R> {
    const REFRACTS: bool = false;

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> Crossed<R> {
        let [x, y, z] = self.turned(ray.p);
        let [dx, dy, dz] = self.shift;
        let (x, y, z) = (x + dx, y + dy, z + dz);
        let t = self.turned(ray.t);
        let known = x.same(x) & y.same(y) & z.same(z);
        Crossed { ray: LensRay { p: [x, y, z], t, ..ray }, met: known, inside: known, incidence: x }
    }
}
