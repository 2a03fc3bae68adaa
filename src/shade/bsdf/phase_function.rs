//! Phase function of scattering in a medium.

use std::f64::consts::PI;

use super::shading_frame::ShadingFrame;
use crate::lanes::Real;
use crate::lanes::math::sin_cos_turns;

/// Largest magnitude of the asymmetry, as in pbrt-v4.
const MAX_G: f32 = 0.99;

#[inline(always)]
fn clamp<R: Real<Scalar = f32>>(x: R, limit: f32) -> R {
    x.max(R::splat(-limit)).min(R::splat(limit))
}

/// Returns the phase function of Henyey & Greenstein 1941, by solid angle. `cos` is the cosine
/// between the directions to where light goes and to where it comes from, so forward scattering
/// (`g` > 0) is strongest at -1.
#[inline(always)]
pub fn henyey_greenstein<R: Real<Scalar = f32>>(cos: R, g: R) -> R {
    let (one, two) = (R::splat(1.0), R::splat(2.0));
    let g = clamp(g, MAX_G);
    let spread = (one + g * g + two * g * cos).max(R::splat(f32::MIN_POSITIVE));
    (one - g * g) / (R::constant(4.0 * PI) * spread * spread.sqrt())
}

/// Samples a direction to where light comes from, with the density of [`henyey_greenstein`].
#[inline(always)]
pub fn sample_henyey_greenstein<R: Real<Scalar = f32>>(wo: [R; 3], g: R, u: [R; 2]) -> [R; 3] {
    let (zero, one, two) = (R::splat(0.0), R::splat(1.0), R::splat(2.0));
    let g = clamp(g, MAX_G);
    let isotropic = g.abs().lt(R::splat(1e-3));
    let twice = R::select(isotropic, one, two * g);
    let quotient = (one - g * g) / (one + g - two * g * u[0]);
    let skewed = -(one + g * g - quotient * quotient) / twice;
    let cos = clamp(R::select(isotropic, one - two * u[0], skewed), 1.0);
    let sin = (one - cos * cos).max(zero).sqrt();
    let [y, x] = sin_cos_turns(u[1]);
    ShadingFrame::about(wo, [zero; 3]).to_world([sin * x, sin * y, cos])
}
