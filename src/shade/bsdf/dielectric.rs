//! The border of glass, water and the like.

use super::fresnel::Refraction;
use super::microfacet::Microfacets;
use super::vector::{dot, negate, normal, scale, scale_add, select};
use super::{Bsdf, Drawn};
use crate::lanes::Real;

/// The border between two clear media, smooth or of microfacets
/// (Walter et al. 2007, "Microfacet models for refraction through rough surfaces").
#[derive(Clone, Copy, Debug)]
pub struct Dielectric<R: Real> {
    facets: Microfacets<R>,
    eta: R,
    singular: R::Mask,
}

/// Which lobes take part, as a factor of each one's probability.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Lobes {
    reflection: f32,
    transmission: f32,
}

impl Lobes {
    pub(super) const BOTH: Self = Self { reflection: 1.0, transmission: 1.0 };
    pub(super) const REFLECTION: Self = Self { reflection: 1.0, transmission: 0.0 };
    pub(super) const TRANSMISSION: Self = Self { reflection: 0.0, transmission: 1.0 };
}

/// What is transported along `wo`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Transport {
    /// Light, which changes with the square of the index where it is refracted.
    Radiance,
    /// Its adjoint, which does not.
    Importance,
}

/// The part of chance that a lobe has among those that take part.
#[inline(always)]
fn share<R: Real<Scalar = f32>>(part: R, total: R) -> R {
    let some = R::splat(0.0).lt(total);
    R::select(some, part / R::select(some, total, R::splat(1.0)), R::splat(0.0))
}

impl<R: Real<Scalar = f32>> Dielectric<R> {
    /// A border of roughness `alpha` along x and y; `eta` is the refractive index below
    /// (z < 0) over that above. An index of 1 passes straight through, whatever the roughness,
    /// and so does one that is not above 0, as pbrt-v4 reads it.
    #[inline(always)]
    pub fn new(alpha: [R; 2], eta: R) -> Self {
        let one = R::splat(1.0);
        let facets = Microfacets::new(alpha);
        let eta = R::select(R::splat(0.0).lt(eta), eta, one);
        Self { facets, eta, singular: facets.smooth | eta.same(one) }
    }

    /// The index beyond the border over that on the side of `wo`.
    #[inline(always)]
    fn ratio(&self, wo: [R; 3]) -> R {
        R::select(wo[2].lt(R::splat(0.0)), R::splat(1.0) / self.eta, self.eta)
    }

    /// (i.m + o.m / eta)^2 where it is more than rounding, for indices that hardly differ.
    #[inline(always)]
    fn spread(sum: R) -> R {
        sum.square().max(R::splat(1e-12))
    }

    /// f |cos wi|, radiance, and the density if only some lobes take part.
    #[inline(always)]
    pub(super) fn scatter(&self, wo: [R; 3], wi: [R; 3], lobes: Lobes) -> (R, R) {
        let (zero, one, quarter) = (R::splat(0.0), R::splat(1.0), R::splat(0.25));
        let side = wo[2] * wi[2];
        let same = zero.lt(side);
        let eta = self.ratio(wo);
        let half = scale_add(wi, R::select(same, one, eta), wo);
        let length2 = dot(half, half);
        let some = zero.lt(length2);
        let m = scale(half, one / R::select(some, length2, one).sqrt());
        // Microfacets face the side that wo is on.
        let m = select((m[2] * wo[2]).lt(zero), negate(m), m);
        let (om, im) = (dot(wo, m), dot(wi, m));
        let faces = zero.lt(om) & ((same & zero.lt(im)) | (side.lt(zero) & im.lt(zero)));
        let scatters = some & faces & !self.singular;

        let reflected = Refraction::new(om.max(zero), eta).reflectance;
        let passed = one - reflected;
        let here = reflected * R::splat(lobes.reflection);
        let there = passed * R::splat(lobes.transmission);
        let (o, i) = (self.facets.facing(wo), self.facets.facing(wi));
        let inverse = one / eta;
        let jacobian = im.abs() / Self::spread(om.mul_add(inverse, im));
        let beyond = om * jacobian;
        let area = self.facets.density(m);
        let lobe = R::select(same, reflected * quarter, passed * beyond * inverse.square());
        let chance = R::select(same, here * quarter, there * beyond);
        let value = area * Microfacets::shadowed(o, i) * lobe;
        let density = area * Microfacets::visible(o) * share(chance, here + there);
        (R::select(scatters, value, zero), R::select(scatters, density, zero))
    }

    /// Draws a direction among some lobes.
    #[inline(always)]
    pub(super) fn draw_of(
        &self,
        wo: [R; 3],
        u: [R; 2],
        choice: R,
        lobes: Lobes,
        transport: Transport,
    ) -> Drawn<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let eta = self.ratio(wo);
        let m = select(self.singular, normal(), self.facets.sample(wo, u));
        let m = select(wo[2].lt(zero), negate(m), m);
        let cos = dot(wo, m).max(zero);
        let fresnel = Refraction::new(cos, eta);
        let here = fresnel.reflectance * R::splat(lobes.reflection);
        let there = (one - fresnel.reflectance) * R::splat(lobes.transmission);
        let total = here + there;
        let reflects = (choice * total).lt(here);

        let back = negate(wo);
        let inverse = one / eta;
        let mirrored = scale_add(m, R::splat(2.0) * cos, back);
        let refracted = scale(scale_add(m, cos - fresnel.beyond, back), inverse);
        let wi = select(reflects, mirrored, refracted);
        let side = wo[2] * wi[2];
        let sides = (reflects & zero.lt(side)) | (!reflects & side.lt(zero));

        let (o, i) = (self.facets.facing(wo), self.facets.facing(wi));
        let visible = Microfacets::visible(o);
        let lost = Microfacets::shadowed(o, i) / visible;
        let weight = total * R::select(self.singular, one, lost);
        let compressed = match transport {
            Transport::Radiance => R::select(reflects, one, inverse.square()),
            Transport::Importance => one,
        };
        let bent = Self::spread((cos - fresnel.beyond) * inverse);
        let beyond = cos * fresnel.beyond * inverse / bent;
        let chance = R::select(reflects, here * R::splat(0.25), there * beyond);
        let density = self.facets.density(m) * visible * share(chance, total);
        let weight = weight * compressed;
        Drawn {
            wi,
            weight: [weight; 3],
            density: R::select(self.singular, zero, density),
            singular: self.singular,
            valid: sides,
            eta2: R::select(reflects, one, eta.square()),
        }
        .only(zero.lt(total) & zero.lt(cos))
    }
}

impl<R: Real<Scalar = f32>> Bsdf<R> for Dielectric<R> {
    #[inline(always)]
    fn evaluate(&self, wo: [R; 3], wi: [R; 3]) -> ([R; 3], R) {
        let (value, density) = self.scatter(wo, wi, Lobes::BOTH);
        ([value; 3], density)
    }

    #[inline(always)]
    fn draw(&self, wo: [R; 3], u: [R; 2], choice: R) -> Drawn<R> {
        self.draw_of(wo, u, choice, Lobes::BOTH, Transport::Radiance)
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        self.singular
    }
}
