//! Vectors of lanes.

use crate::lanes::Real;

/// The scalar product.
#[inline(always)]
pub(super) fn dot<R: Real>(a: [R; 3], b: [R; 3]) -> R {
    a[2].mul_add(b[2], a[1].mul_add(b[1], a[0] * b[0]))
}

/// a x b.
#[inline(always)]
pub(super) fn cross<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// a s.
#[inline(always)]
pub(super) fn scale<R: Real>(a: [R; 3], s: R) -> [R; 3] {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// a s + b.
#[inline(always)]
pub(super) fn scale_add<R: Real>(a: [R; 3], s: R, b: [R; 3]) -> [R; 3] {
    [a[0].mul_add(s, b[0]), a[1].mul_add(s, b[1]), a[2].mul_add(s, b[2])]
}

/// -a.
#[inline(always)]
pub(super) fn negate<R: Real>(a: [R; 3]) -> [R; 3] {
    [-a[0], -a[1], -a[2]]
}

/// `yes` where the mask is set, `no` elsewhere.
#[inline(always)]
pub(super) fn select<R: Real>(mask: R::Mask, yes: [R; 3], no: [R; 3]) -> [R; 3] {
    [R::select(mask, yes[0], no[0]), R::select(mask, yes[1], no[1]), R::select(mask, yes[2], no[2])]
}

/// The largest component.
#[inline(always)]
pub(super) fn largest<R: Real>(a: [R; 3]) -> R {
    a[0].max(a[1]).max(a[2])
}

/// The normal [0, 0, 1].
#[inline(always)]
pub(super) fn normal<R: Real<Scalar = f32>>() -> [R; 3] {
    [R::splat(0.0), R::splat(0.0), R::splat(1.0)]
}
