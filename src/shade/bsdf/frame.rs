//! The frame in which surfaces scatter.

use super::vector::{cross, dot, scale, scale_add, select};
use crate::lanes::Real;

/// Three orthogonal unit vectors: the tangents x and y, and the shading normal z = x cross y.
#[derive(Clone, Copy, Debug)]
pub struct Frame<R: Real> {
    /// Along increasing u, as far as it is orthogonal to the normal.
    pub x: [R; 3],
    /// z cross x.
    pub y: [R; 3],
    /// The shading normal.
    pub z: [R; 3],
}

impl<R: Real<Scalar = f32>> Frame<R> {
    /// The frame about a unit normal whose x follows a tangent of any length. Where there is
    /// no tangent, or it runs along the normal, x is any (Duff et al. 2017, "Building an
    /// orthonormal basis, revisited").
    #[inline(always)]
    pub fn about(normal: [R; 3], tangent: [R; 3]) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let z = normal;
        // To unit size first: squares of a dp/du in odd units would leave the range of f32.
        let size = tangent[0].abs().max(tangent[1].abs()).max(tangent[2].abs());
        let some = zero.lt(size) & size.lt(R::splat(f32::INFINITY));
        let tangent = scale(tangent, one / R::select(some, size, one));
        let across = scale_add(z, -dot(tangent, z), tangent);
        let length2 = dot(across, across);
        // Below this the direction is mostly rounding.
        let some = some & R::splat(1e-10).lt(length2);
        let along = scale(across, one / R::select(some, length2, one).sqrt());

        let sign = R::select(z[2].lt(zero), -one, one);
        let a = -one / (sign + z[2]);
        let any = [(sign * z[0]).mul_add(z[0] * a, one), sign * z[0] * z[1] * a, -sign * z[0]];
        let x = select(some, along, any);
        Self { x, y: cross(z, x), z }
    }

    /// A vector of the world in this frame.
    #[inline(always)]
    pub fn local(&self, world: [R; 3]) -> [R; 3] {
        [dot(world, self.x), dot(world, self.y), dot(world, self.z)]
    }

    /// A vector of this frame in the world.
    #[inline(always)]
    pub fn world(&self, local: [R; 3]) -> [R; 3] {
        scale_add(self.z, local[2], scale_add(self.y, local[1], scale(self.x, local[0])))
    }
}
