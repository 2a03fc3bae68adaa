//! Phase function of scattering in a medium.

use std::f64::consts::PI;

use super::shading_frame::ShadingFrame;
use super::{Bsdf, BsdfSample};
use crate::lanes::Real;
use crate::lanes::math::sin_cos_turns;
use crate::lanes::vector::dot;

/// Largest magnitude of the asymmetry, as in pbrt-v4.
const MAX_G: f32 = 0.99;

#[inline(always)]
fn clamp<R: Real<Scalar = f32>>(x: R, limit: f32) -> R {
    x.max(R::splat(-limit)).min(R::splat(limit))
}

/// Scattering in a medium, by the phase function of Henyey & Greenstein.
#[derive(Clone, Copy, Debug)]
pub struct MediumScattering<R> {
    /// Asymmetry, -1 to 1.
    pub g: R,
}

impl<R: Real<Scalar = f32>> Bsdf<R> for MediumScattering<R> {
    #[inline(always)]
    fn evaluate(&self, wo: [R; 3], wi: [R; 3]) -> ([R; 3], R) {
        let phase = henyey_greenstein(dot(wo, wi), self.g);
        ([phase; 3], phase)
    }

    #[inline(always)]
    fn sample(&self, wo: [R; 3], u: [R; 2], _: R) -> BsdfSample<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let wi = sample_henyey_greenstein(wo, self.g, u);
        BsdfSample {
            wi,
            weight: [one; 3],
            pdf: henyey_greenstein(dot(wo, wi), self.g),
            singular: one.lt(zero),
            valid: zero.lt(one),
            eta2: one,
        }
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        R::splat(1.0).lt(R::splat(0.0))
    }
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
