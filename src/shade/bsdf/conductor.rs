//! Conductor: a metal, smooth or rough.

use super::fresnel::conductor_reflectance;
use super::microfacet::Microfacets;
use super::{Bsdf, BsdfSample};
use crate::lanes::Real;
use crate::lanes::vector::{dot, negate, scale, scale_add, select, z_axis};

/// Largest refractive index, practically a perfect mirror; keeps its powers in the range of f32.
const MAX_INDEX: f32 = 1e8;

/// A metal, smooth or of microfacets (Torrance & Sparrow 1967), the same from both sides.
#[derive(Clone, Copy, Debug)]
pub struct Conductor<R: Real> {
    facets: Microfacets<R>,
    eta: [R; 3],
    k: [R; 3],
    /// Factor of the reflectance at normal incidence, minus 1.
    excess: [R; 3],
}

impl<R: Real<Scalar = f32>> Conductor<R> {
    /// A metal of roughness `alpha` along x and y, and of refractive index eta + i k by colour
    /// channel. The index is relative to the medium around the metal; under a coat, to the coat.
    #[inline(always)]
    pub fn new(alpha: [R; 2], eta: [R; 3], k: [R; 3]) -> Self {
        let clamp = |x: R| x.max(R::splat(0.0)).min(R::splat(MAX_INDEX));
        Self {
            facets: Microfacets::new(alpha),
            eta: [clamp(eta[0]), clamp(eta[1]), clamp(eta[2])],
            k: [clamp(k[0]), clamp(k[1]), clamp(k[2])],
            excess: [R::splat(0.0); 3],
        }
    }

    /// The same metal with a tinted reflectance: multiplied by the tint at normal incidence, by 1
    /// at grazing incidence, and linearly in the cosine between.
    #[inline(always)]
    pub fn tinted(self, tint: [R; 3]) -> Self {
        let one = R::splat(1.0);
        Self { excess: [tint[0] - one, tint[1] - one, tint[2] - one], ..self }
    }

    /// Returns the tinted Fresnel reflectance times a factor, by colour channel.
    #[inline(always)]
    fn reflectance(&self, cos: R, factor: R) -> [R; 3] {
        let [r, g, b] = self.excess;
        let one = R::splat(1.0);
        [
            conductor_reflectance(cos, self.eta[0], self.k[0]) * (factor * r.mul_add(cos, one)),
            conductor_reflectance(cos, self.eta[1], self.k[1]) * (factor * g.mul_add(cos, one)),
            conductor_reflectance(cos, self.eta[2], self.k[2]) * (factor * b.mul_add(cos, one)),
        ]
    }
}

impl<R: Real<Scalar = f32>> Bsdf<R> for Conductor<R> {
    #[inline(always)]
    fn evaluate(&self, wo: [R; 3], wi: [R; 3]) -> ([R; 3], R) {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let half = scale_add(wi, one, wo);
        let length2 = dot(half, half);
        let scatters = zero.lt(wo[2] * wi[2]) & zero.lt(length2) & !self.facets.smooth;
        let m = scale(half, one / R::select(scatters, length2, one).sqrt());
        let (o, i) = (self.facets.stretch(wo), self.facets.stretch(wi));
        let quarter = self.facets.distribution(m) * R::splat(0.25);
        let factor = R::select(scatters, quarter * Microfacets::g_over_cos(o, i), zero);
        let pdf = R::select(scatters, quarter * Microfacets::g1_over_cos(o), zero);
        (self.reflectance(dot(wo, m).abs(), factor), pdf)
    }

    #[inline(always)]
    fn sample(&self, wo: [R; 3], u: [R; 2], _choice: R) -> BsdfSample<R> {
        let (zero, two) = (R::splat(0.0), R::splat(2.0));
        let smooth = self.facets.smooth;
        let m = select(smooth, z_axis(), self.facets.sample_visible_normal(wo, u));
        let cos = dot(wo, m);
        let wi = scale_add(m, two * cos, negate(wo));
        let (o, i) = (self.facets.stretch(wo), self.facets.stretch(wi));
        let visible = Microfacets::g1_over_cos(o);
        let unshadowed = Microfacets::g_over_cos(o, i) / visible;
        let weight = self.reflectance(cos.abs(), R::select(smooth, R::splat(1.0), unshadowed));
        let pdf = self.facets.distribution(m) * R::splat(0.25) * visible;
        BsdfSample {
            wi,
            weight,
            pdf: R::select(smooth, zero, pdf),
            singular: smooth,
            valid: zero.lt(wo[2] * wi[2]),
            eta2: R::splat(1.0),
        }
        .only(zero.lt(cos.abs()))
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        self.facets.smooth
    }
}
