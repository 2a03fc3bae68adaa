//! Shading frame: the coordinates in which BSDFs are defined.

use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{cross, dot, scale, scale_add, select};

/// Three orthogonal unit vectors: the tangents x and y, and the shading normal z = x cross y.
#[derive(Clone, Copy, Debug)]
pub struct ShadingFrame<R: Real> {
    /// Tangent: the direction of increasing u, made orthogonal to the normal.
    pub x: [R; 3],
    /// Bitangent: z cross x.
    pub y: [R; 3],
    /// The shading normal.
    pub z: [R; 3],
}

impl<R: Real<Scalar = f32>> ShadingFrame<R> {
    /// The frame about a unit normal, with x along a tangent of any length. If the tangent is 0 or
    /// parallel to the normal, x is arbitrary (Duff et al. 2017, "Building an orthonormal basis,
    /// revisited").
    #[inline(always)]
    pub fn about(normal: [R; 3], tangent: [R; 3]) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let z = normal;
        // Scaled to unit size first: squares of a dp/du in extreme units would leave f32's range.
        let size = tangent[0].abs().max(tangent[1].abs()).max(tangent[2].abs());
        let some = zero.lt(size) & size.lt(R::splat(f32::INFINITY));
        let tangent = scale(tangent, one / R::select(some, size, one));
        let across = scale_add(z, -dot(tangent, z), tangent);
        let length2 = dot(across, across);
        // Below this, rounding errors dominate the direction.
        let some = some & R::splat(1e-10).lt(length2);
        let along = scale(across, one / R::select(some, length2, one).sqrt());

        let sign = R::select(z[2].lt(zero), -one, one);
        let a = -one / (sign + z[2]);
        let any = [(sign * z[0]).mul_add(z[0] * a, one), sign * z[0] * z[1] * a, -sign * z[0]];
        let x = select(some, along, any);
        Self { x, y: cross(z, x), z }
    }

    /// Transforms a vector from world space to this frame.
    #[inline(always)]
    pub fn to_local(&self, world: [R; 3]) -> [R; 3] {
        [dot(world, self.x), dot(world, self.y), dot(world, self.z)]
    }

    /// Transforms a vector from this frame to world space.
    #[inline(always)]
    pub fn to_world(&self, local: [R; 3]) -> [R; 3] {
        scale_add(self.z, local[2], scale_add(self.y, local[1], scale(self.x, local[0])))
    }
}
