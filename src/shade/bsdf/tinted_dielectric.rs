//! Tinted dielectric: an interface whose transmitted light has a colour.

use super::dielectric::Dielectric;
use super::{Bsdf, BsdfSample};
use crate::lanes::Real;
use crate::lanes::vector::select;

/// A dielectric interface that keeps a share of the light that it transmits, by colour channel: the
/// base colour of a transmitting surface in glTF (KHR_materials_transmission). What it reflects has no
/// colour.
#[derive(Clone, Copy, Debug)]
pub struct TintedDielectric<R: Real> {
    /// The interface.
    pub interface: Dielectric<R>,
    /// Share of the transmitted light that is kept.
    pub tint: [R; 3],
}

impl<R: Real<Scalar = f32>> TintedDielectric<R> {
    /// Returns the factor of light that is scattered from `wi` to `wo`.
    #[inline(always)]
    fn factor(&self, wo: [R; 3], wi: [R; 3]) -> [R; 3] {
        let transmitted = (wo[2] * wi[2]).lt(R::splat(0.0));
        select(transmitted, self.tint, [R::splat(1.0); 3])
    }
}

impl<R: Real<Scalar = f32>> Bsdf<R> for TintedDielectric<R> {
    #[inline(always)]
    fn evaluate(&self, wo: [R; 3], wi: [R; 3]) -> ([R; 3], R) {
        let ([r, g, b], pdf) = self.interface.evaluate(wo, wi);
        let [tr, tg, tb] = self.factor(wo, wi);
        ([r * tr, g * tg, b * tb], pdf)
    }

    #[inline(always)]
    fn sample(&self, wo: [R; 3], u: [R; 2], choice: R) -> BsdfSample<R> {
        let sample = self.interface.sample(wo, u, choice);
        let ([r, g, b], [tr, tg, tb]) = (sample.weight, self.factor(wo, sample.wi));
        BsdfSample { weight: [r * tr, g * tg, b * tb], ..sample }
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        self.interface.singular()
    }
}
