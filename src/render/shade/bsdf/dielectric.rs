//! Dielectric: the interface between two clear media, such as air and glass.

use super::fresnel::Refraction;
use super::lobe_choice::LobeChoice;
use super::microfacet::Microfacets;
use super::{Bsdf, BsdfSample};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{dot, negate, scale, scale_add, select, z_axis};

/// The interface between two clear media, smooth or of microfacets
/// (Walter et al. 2007, "Microfacet models for refraction through rough surfaces").
#[derive(Clone, Copy, Debug)]
pub struct Dielectric<R: Real> {
    facets: Microfacets<R>,
    eta: R,
    singular: R::Mask,
}

/// The quantity that is transported along `wo`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Transport {
    /// Radiance, which refraction scales by the squared ratio of the indices.
    Radiance,
    /// Importance, the adjoint, which refraction does not scale.
    Importance,
}

impl<R: Real<Scalar = f32>> Dielectric<R> {
    /// An interface of roughness `alpha` along x and y. `eta` is the refractive index below (z < 0)
    /// over that above. With an index of 1 light passes straight through, whatever the roughness.
    /// An index <= 0 counts as 1, as in pbrt-v4.
    #[inline(always)]
    pub fn new(alpha: [R; 2], eta: R) -> Self {
        let one = R::splat(1.0);
        let facets = Microfacets::new(alpha);
        let eta = R::select(R::splat(0.0).lt(eta), eta, one);
        Self { facets, eta, singular: facets.smooth | eta.equals(one) }
    }

    /// Returns the index beyond the interface over that on the side of `wo`.
    #[inline(always)]
    fn relative_index(&self, wo: [R; 3]) -> R {
        R::select(wo[2].lt(R::splat(0.0)), R::splat(1.0) / self.eta, self.eta)
    }

    /// Returns the Fresnel reflectance of a smooth interface for light along `wo`.
    #[inline(always)]
    pub(super) fn smooth_reflectance(&self, wo: [R; 3]) -> R {
        Refraction::new(wo[2].abs(), self.relative_index(wo)).reflectance
    }

    /// Returns the square of `sum` = i.m + o.m / eta. It is kept above rounding errors, for indices
    /// that hardly differ.
    #[inline(always)]
    fn clamped_square(sum: R) -> R {
        sum.square().max(R::splat(1e-12))
    }

    /// Returns f |cos wi| for radiance, and the density of sampling `wi` among `lobes`.
    #[inline(always)]
    pub(super) fn evaluate_lobes(&self, wo: [R; 3], wi: [R; 3], lobes: LobeChoice) -> (R, R) {
        let (zero, one, quarter) = (R::splat(0.0), R::splat(1.0), R::splat(0.25));
        let side = wo[2] * wi[2];
        let same = zero.lt(side);
        let eta = self.relative_index(wo);
        let half = scale_add(wi, R::select(same, one, eta), wo);
        let length2 = dot(half, half);
        let some = zero.lt(length2);
        let m = scale(half, one / R::select(some, length2, one).sqrt());
        // Microfacets face the side of wo.
        let m = select((m[2] * wo[2]).lt(zero), negate(m), m);
        let (om, im) = (dot(wo, m), dot(wi, m));
        let faces = zero.lt(om) & ((same & zero.lt(im)) | (side.lt(zero) & im.lt(zero)));
        let scatters = some & faces & !self.singular;

        let reflected = Refraction::new(om.max(zero), eta).reflectance;
        let passed = one - reflected;
        let [here, there] = lobes.chances(reflected);
        let (o, i) = (self.facets.stretch(wo), self.facets.stretch(wi));
        let inverse = one / eta;
        let jacobian = im.abs() / Self::clamped_square(om.mul_add(inverse, im));
        let transmitted = om * jacobian;
        let area = self.facets.distribution(m);
        let lobe = R::select(same, reflected * quarter, passed * transmitted * inverse.square());
        let chance = R::select(same, here * quarter, there * transmitted);
        let value = area * Microfacets::g_over_cos(o, i) * lobe;
        let pdf = area * Microfacets::g1_over_cos(o) * chance;
        (R::select(scatters, value, zero), R::select(scatters, pdf, zero))
    }

    /// Samples a direction among `lobes`.
    #[inline(always)]
    pub(super) fn sample_lobes(
        &self,
        wo: [R; 3],
        u: [R; 2],
        choice: R,
        lobes: LobeChoice,
        transport: Transport,
    ) -> BsdfSample<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let eta = self.relative_index(wo);
        let m = select(self.singular, z_axis(), self.facets.sample_visible_normal(wo, u));
        let m = select(wo[2].lt(zero), negate(m), m);
        let cos = dot(wo, m).max(zero);
        let fresnel = Refraction::new(cos, eta);
        let [here, there] = lobes.chances(fresnel.reflectance);
        let reflects = choice.lt(here);

        let back = negate(wo);
        let inverse = one / eta;
        let mirrored = scale_add(m, R::splat(2.0) * cos, back);
        let refracted = scale(scale_add(m, cos - fresnel.eta_cos, back), inverse);
        let wi = select(reflects, mirrored, refracted);
        let side = wo[2] * wi[2];
        let sides = (reflects & zero.lt(side)) | (!reflects & side.lt(zero));

        let (o, i) = (self.facets.stretch(wo), self.facets.stretch(wi));
        let visible = Microfacets::g1_over_cos(o);
        let unshadowed = Microfacets::g_over_cos(o, i) / visible;
        let share = R::select(reflects, fresnel.reflectance, one - fresnel.reflectance);
        let lobe_weight = share / R::select(reflects, here, there);
        let weight = lobe_weight * R::select(self.singular, one, unshadowed);
        let radiance_scale = match transport {
            Transport::Radiance => R::select(reflects, one, inverse.square()),
            Transport::Importance => one,
        };
        let bent = Self::clamped_square((cos - fresnel.eta_cos) * inverse);
        let transmitted = cos * fresnel.eta_cos * inverse / bent;
        let chance = R::select(reflects, here * R::splat(0.25), there * transmitted);
        let pdf = self.facets.distribution(m) * visible * chance;
        let weight = weight * radiance_scale;
        BsdfSample {
            wi,
            weight: [weight; 3],
            pdf: R::select(self.singular, zero, pdf),
            singular: self.singular,
            valid: sides,
            eta2: R::select(reflects, one, eta.square()),
        }
        .only(zero.lt(share) & zero.lt(cos))
    }
}

impl<R: Real<Scalar = f32>> Bsdf<R> for Dielectric<R> {
    #[inline(always)]
    fn evaluate(&self, wo: [R; 3], wi: [R; 3]) -> ([R; 3], R) {
        let (value, pdf) = self.evaluate_lobes(wo, wi, LobeChoice::OfGlass);
        ([value; 3], pdf)
    }

    #[inline(always)]
    fn sample(&self, wo: [R; 3], u: [R; 2], choice: R) -> BsdfSample<R> {
        self.sample_lobes(wo, u, choice, LobeChoice::OfGlass, Transport::Radiance)
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        self.singular
    }
}
