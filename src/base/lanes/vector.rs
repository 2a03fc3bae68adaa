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

/// Returns a + b.
#[inline(always)]
pub fn add<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Returns a - b.
#[inline(always)]
pub fn sub<R: Real>(a: [R; 3], b: [R; 3]) -> [R; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Returns the magnitudes of the components.
#[inline(always)]
pub fn abs<R: Real>(a: [R; 3]) -> [R; 3] {
    [a[0].abs(), a[1].abs(), a[2].abs()]
}

/// Returns the unit vector along `a`, and the lanes in which there is one: its length must be
/// neither 0 nor so small or large that its inverse or its square leaves the range. The vector of
/// other lanes is 0.
#[inline(always)]
pub fn normalize<R: Real>(a: [R; 3]) -> ([R; 3], R::Mask) {
    let (zero, one) = (R::constant(0.0), R::constant(1.0));
    let inverse = one / dot(a, a).sqrt();
    let some = zero.lt(inverse) & inverse.lt(R::constant(f64::INFINITY));
    let inverse = R::select(some, inverse, zero);
    ([clear(a[0], some) * inverse, clear(a[1], some) * inverse, clear(a[2], some) * inverse], some)
}

/// Scales a vector that is nearly of unit length to unit length, by a step of Newton's method for
/// 1 / sqrt(a.a). A relative error e of the length becomes 3/2 e^2, below the rounding errors of f32 for
/// e < 1e-4, so that a direction which passes through this function at every step of a path keeps its
/// length over any number of steps. Cheaper than [`normalize`], and defined for the vector 0, which stays.
#[inline(always)]
pub fn renormalize<R: Real>(a: [R; 3]) -> [R; 3] {
    scale(a, R::constant(1.5) - R::constant(0.5) * dot(a, a))
}

/// Returns two unit vectors that are orthogonal to a unit vector and to each other, so that the
/// cross product of the first and the second is the vector (Duff et al. 2017, "Building an
/// orthonormal basis, revisited").
#[inline(always)]
pub fn orthonormal_pair<R: Real>(z: [R; 3]) -> [[R; 3]; 2] {
    let one = R::constant(1.0);
    let sign = R::select(z[2].lt(R::constant(0.0)), -one, one);
    let a = -one / (sign + z[2]);
    let b = z[0] * z[1] * a;
    [
        [(sign * z[0]).mul_add(z[0] * a, one), sign * b, -sign * z[0]],
        [b, z[1].mul_add(z[1] * a, sign), -z[1]],
    ]
}

/// Returns 0 outside of the mask.
#[inline(always)]
pub fn clear<R: Real>(a: R, mask: R::Mask) -> R {
    R::select(mask, a, R::constant(0.0))
}

/// Returns a in every lane.
#[inline(always)]
pub fn splat<R: Real>(a: [R::Scalar; 3]) -> [R; 3] {
    [R::splat(a[0]), R::splat(a[1]), R::splat(a[2])]
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
