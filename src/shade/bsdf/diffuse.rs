//! Diffuse surfaces, by Lambert's law.

use super::{Bsdf, BsdfSample};
use crate::lanes::Real;
use crate::lanes::vector::max_component;
use crate::sampler::concentric_disk;

/// A Lambertian reflector (Lambert 1760), the same from both sides.
#[derive(Clone, Copy, Debug)]
pub struct Diffuse<R> {
    /// The share of light reflected, by colour channel.
    pub reflectance: [R; 3],
}

/// A Lambertian reflector and transmitter, the same from both sides.
#[derive(Clone, Copy, Debug)]
pub struct DiffuseTransmission<R> {
    /// The share of light reflected, by colour channel.
    pub reflectance: [R; 3],
    /// The share of light transmitted, by colour channel.
    pub transmittance: [R; 3],
}

/// Samples a direction of the upper hemisphere with density cos / pi.
#[inline(always)]
fn cosine<R: Real<Scalar = f32>>(u: [R; 2]) -> [R; 3] {
    let [x, y] = concentric_disk(u[0], u[1]);
    let z2 = R::splat(1.0) - x.mul_add(x, y * y);
    [x, y, z2.max(R::splat(0.0)).sqrt()]
}

#[inline(always)]
fn inverse_pi<R: Real<Scalar = f32>>() -> R {
    R::constant(std::f64::consts::FRAC_1_PI)
}

impl<R: Real<Scalar = f32>> Bsdf<R> for Diffuse<R> {
    #[inline(always)]
    fn evaluate(&self, wo: [R; 3], wi: [R; 3]) -> ([R; 3], R) {
        let zero = R::splat(0.0);
        let same = zero.lt(wo[2] * wi[2]);
        let pdf = R::select(same, wi[2].abs() * inverse_pi(), zero);
        let [r, g, b] = self.reflectance;
        ([r * pdf, g * pdf, b * pdf], pdf)
    }

    #[inline(always)]
    fn sample(&self, wo: [R; 3], u: [R; 2], _choice: R) -> BsdfSample<R> {
        let zero = R::splat(0.0);
        let [x, y, z] = cosine(u);
        let seen = wo[2].lt(zero) | zero.lt(wo[2]);
        BsdfSample {
            wi: [x, y, R::select(wo[2].lt(zero), -z, z)],
            weight: self.reflectance,
            pdf: z * inverse_pi(),
            singular: zero.lt(zero),
            valid: seen,
            eta2: R::splat(1.0),
        }
        .only(zero.lt(z))
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        max_component(self.reflectance).le(R::splat(0.0))
    }
}

impl<R: Real<Scalar = f32>> DiffuseTransmission<R> {
    /// Returns the probability of sampling a direction on the side of `wo`.
    #[inline(always)]
    fn reflection_probability(&self) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let (here, there) = (max_component(self.reflectance), max_component(self.transmittance));
        let sum = here + there;
        here / R::select(zero.lt(sum), sum, one)
    }
}

impl<R: Real<Scalar = f32>> Bsdf<R> for DiffuseTransmission<R> {
    #[inline(always)]
    fn evaluate(&self, wo: [R; 3], wi: [R; 3]) -> ([R; 3], R) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let side = wo[2] * wi[2];
        let (same, other) = (zero.lt(side), side.lt(zero));
        let cosine = R::select(same | other, wi[2].abs() * inverse_pi(), zero);
        let reflects = self.reflection_probability();
        let (r, t) = (self.reflectance, self.transmittance);
        let share = R::select(same, reflects, one - reflects);
        let share = R::select(self.singular(), zero, share);
        (
            [
                R::select(same, r[0], t[0]) * cosine,
                R::select(same, r[1], t[1]) * cosine,
                R::select(same, r[2], t[2]) * cosine,
            ],
            share * cosine,
        )
    }

    #[inline(always)]
    fn sample(&self, wo: [R; 3], u: [R; 2], choice: R) -> BsdfSample<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let [x, y, z] = cosine(u);
        let reflects = self.reflection_probability();
        let same = choice.lt(reflects);
        let below = wo[2].lt(zero);
        let up = (same & !below) | (!same & below);
        let share = R::select(same, reflects, one - reflects);
        let scale = one / R::select(zero.lt(share), share, one);
        let (r, t) = (self.reflectance, self.transmittance);
        BsdfSample {
            wi: [x, y, R::select(up, z, -z)],
            weight: [
                R::select(same, r[0], t[0]) * scale,
                R::select(same, r[1], t[1]) * scale,
                R::select(same, r[2], t[2]) * scale,
            ],
            pdf: share * z * inverse_pi(),
            singular: zero.lt(zero),
            valid: (below | zero.lt(wo[2])) & !self.singular(),
            eta2: one,
        }
        .only(zero.lt(z) & zero.lt(share))
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        max_component(self.reflectance).max(max_component(self.transmittance)).le(R::splat(0.0))
    }
}
