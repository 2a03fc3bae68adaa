//! Phase function of Henyey & Greenstein 1941.

use std::f64::consts::PI;

use petzval_base::lanes::Real;

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

/// Samples the cosine between the directions to where light goes and to where it comes from, with the
/// density of [`henyey_greenstein`] times 2 pi. `u` is in [0, 1).
#[inline(always)]
pub fn sample_henyey_greenstein_cosine<R: Real<Scalar = f32>>(g: R, u: R) -> R {
    let (one, two) = (R::splat(1.0), R::splat(2.0));
    let g = clamp(g, MAX_G);
    let isotropic = g.abs().lt(R::splat(1e-3));
    let twice = R::select(isotropic, one, two * g);
    let quotient = (one - g * g) / (one + g - two * g * u);
    let skewed = -(one + g * g - quotient * quotient) / twice;
    clamp(R::select(isotropic, one - two * u, skewed), 1.0)
}
