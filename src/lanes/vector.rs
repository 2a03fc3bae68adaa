//! Vectors of three components, each a packet of lanes.

use super::Real;

/// Returns the dot product.
#[inline(always)]
pub fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

/// Returns the cross product a x b.
#[inline(always)]
pub fn cross<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// Returns a s.
#[inline(always)]
pub fn scale<R: Real>(a: [R; 3], s: R) -> [R; 3] {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// Returns a s + b.
#[inline(always)]
pub fn scale_add<R: Real>(a: [R; 3], s: R, b: [R; 3]) -> [R; 3] {
    [a[0].mul_add(s, b[0]), a[1].mul_add(s, b[1]), a[2].mul_add(s, b[2])]
}

/// Multiplies a vector by the 3 x 3 matrix of these columns, summing from the last column to the
/// first.
#[inline(always)]
pub fn transform<R: Real>(columns: &[[R; 3]; 3], v: [R; 3]) -> [R; 3] {
    let [x, y, z] = *columns;
    scale_add(x, v[0], scale_add(y, v[1], scale(z, v[2])))
}

/// Returns -a.
#[inline(always)]
pub fn negate<R: Real>(a: [R; 3]) -> [R; 3] {
    [-a[0], -a[1], -a[2]]
}

/// Returns `yes` where the mask is set, `no` elsewhere.
#[inline(always)]
pub fn select<R: Real>(mask: R::Mask, yes: [R; 3], no: [R; 3]) -> [R; 3] {
    [R::select(mask, yes[0], no[0]), R::select(mask, yes[1], no[1]), R::select(mask, yes[2], no[2])]
}

/// Returns the largest component.
#[inline(always)]
pub fn max_component<R: Real>(a: [R; 3]) -> R {
    a[0].max(a[1]).max(a[2])
}

/// Returns [0, 0, 1].
#[inline(always)]
pub fn z_axis<R: Real>() -> [R; 3] {
    [R::constant(0.0), R::constant(0.0), R::constant(1.0)]
}
