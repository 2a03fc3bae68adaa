//! Lambert's law.

use super::vector::largest;
use super::{Bsdf, Drawn};
use crate::lanes::Real;
use crate::sampler::disk;

/// A surface that reflects as Lambert 1760 says, on both sides.
#[derive(Clone, Copy, Debug)]
pub struct Diffuse<R> {
    /// The share of light reflected, by colour channel.
    pub reflectance: [R; 3],
}

/// A surface that reflects and transmits as Lambert says, the same from both sides.
#[derive(Clone, Copy, Debug)]
pub struct DiffuseTransmission<R> {
    /// The share of light reflected, by colour channel.
    pub reflectance: [R; 3],
    /// The share of light transmitted, by colour channel.
    pub transmittance: [R; 3],
}

/// A direction of the upper hemisphere with density cos / pi.
#[inline(always)]
fn cosine<R: Real<Scalar = f32>>(u: [R; 2]) -> [R; 3] {
    let [x, y] = disk(u[0], u[1]);
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
        let density = R::select(same, wi[2].abs() * inverse_pi(), zero);
        let [r, g, b] = self.reflectance;
        ([r * density, g * density, b * density], density)
    }

    #[inline(always)]
    fn draw(&self, wo: [R; 3], u: [R; 2], _choice: R) -> Drawn<R> {
        let zero = R::splat(0.0);
        let [x, y, z] = cosine(u);
        let seen = wo[2].lt(zero) | zero.lt(wo[2]);
        Drawn {
            wi: [x, y, R::select(wo[2].lt(zero), -z, z)],
            weight: self.reflectance,
            density: z * inverse_pi(),
            singular: zero.lt(zero),
            valid: seen,
            eta2: R::splat(1.0),
        }
        .only(zero.lt(z))
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        largest(self.reflectance).le(R::splat(0.0))
    }
}

impl<R: Real<Scalar = f32>> DiffuseTransmission<R> {
    /// With what probability light is drawn on the side of `wo`.
    #[inline(always)]
    fn reflects(&self) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let (here, there) = (largest(self.reflectance), largest(self.transmittance));
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
        let reflects = self.reflects();
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
    fn draw(&self, wo: [R; 3], u: [R; 2], choice: R) -> Drawn<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let [x, y, z] = cosine(u);
        let reflects = self.reflects();
        let same = choice.lt(reflects);
        let below = wo[2].lt(zero);
        let up = (same & !below) | (!same & below);
        let share = R::select(same, reflects, one - reflects);
        let scale = one / R::select(zero.lt(share), share, one);
        let (r, t) = (self.reflectance, self.transmittance);
        Drawn {
            wi: [x, y, R::select(up, z, -z)],
            weight: [
                R::select(same, r[0], t[0]) * scale,
                R::select(same, r[1], t[1]) * scale,
                R::select(same, r[2], t[2]) * scale,
            ],
            density: share * z * inverse_pi(),
            singular: zero.lt(zero),
            valid: (below | zero.lt(wo[2])) & !self.singular(),
            eta2: one,
        }
        .only(zero.lt(z) & zero.lt(share))
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        largest(self.reflectance).max(largest(self.transmittance)).le(R::splat(0.0))
    }
}
