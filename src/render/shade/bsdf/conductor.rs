//! Conductor: a metal, smooth or rough.

use super::fresnel::conductor_reflectance;
use super::microfacet::Microfacets;
use super::{Bsdf, BsdfSample, CoatWalks, Gloss, SurfaceTextures, VertexParameters, columns};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{dot, negate, scale, scale_add, select, z_axis};
use petzval_scene::{MaterialModel, Metal, Roughness};

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

columns! {
    /// Parameters of a [`Conductor`].
    #[derive(Clone, Copy, Debug)]
    pub(in crate::shade) struct ConductorParameters<R> {
        /// Width alpha of the microfacets along u and v.
        pub(super) alpha: [R; 2],
        /// Real part of the refractive index, by colour channel.
        pub(super) eta: [R; 3],
        /// Imaginary part.
        pub(super) k: [R; 3],
        /// Factor of the reflectance at normal incidence.
        pub(super) tint: [R; 3],
    }
}

impl<R: Real<Scalar = f32>> ConductorParameters<R> {
    /// Returns the parameters of a metal in air.
    #[inline(always)]
    pub(super) fn of_metal(
        metal: &Metal,
        roughness: &Roughness,
        textures: &impl SurfaceTextures<R>,
    ) -> Self {
        let alpha = textures.alpha(roughness);
        match metal {
            Metal::Index { eta, k, tint } => {
                let (eta, k) = (textures.colour(eta), textures.colour(k));
                Self { alpha, eta, k, tint: textures.colour(tint) }
            }
            Metal::Reflectance(reflectance) => {
                // An index 1 + i k reflects k^2 / (4 + k^2) at normal incidence.
                let (zero, one) = (R::splat(0.0), R::splat(1.0));
                let k = |r: R| {
                    let r = r.max(zero).min(R::splat(0.9999));
                    R::splat(2.0) * (r / (one - r)).sqrt()
                };
                let [r, g, b] = textures.colour(reflectance);
                Self { alpha, eta: [one; 3], k: [k(r), k(g), k(b)], tint: [one; 3] }
            }
        }
    }

    /// Returns the share of light that the metal reflects at normal incidence.
    pub(super) fn normal_reflectance(&self) -> [R; 3] {
        let Self { eta, k, tint, .. } = self;
        let channel = |c: usize| conductor_reflectance(R::splat(1.0), eta[c], k[c]) * tint[c];
        [channel(0), channel(1), channel(2)]
    }

    /// Builds the BSDF.
    #[inline(always)]
    pub(super) fn conductor(self) -> Conductor<R> {
        Conductor::new(self.alpha, self.eta, self.k).tinted(self.tint)
    }
}

impl<R: Real<Scalar = f32>> VertexParameters<R> for ConductorParameters<R> {
    type Bsdf = Conductor<R>;
    const NAME: &'static str = "conductor";
    const ONE_SIDED: bool = true;
    const CATCHES_CAUSTICS: bool = true;

    #[inline(always)]
    fn of(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<Self> {
        let MaterialModel::Conductor { metal, roughness } = model else { return None };
        Some(Self::of_metal(metal, roughness, textures))
    }

    fn albedo(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<[R; 3]> {
        Some(Self::of(model, textures)?.normal_reflectance())
    }

    #[inline(always)]
    fn bsdf(self, _: CoatWalks<R>) -> Conductor<R> {
        self.conductor()
    }

    #[inline(always)]
    fn for_each_width(&mut self, change: impl FnMut(&mut R)) {
        self.alpha.iter_mut().for_each(change);
    }

    #[inline(always)]
    fn unlit(&self) -> R::Mask {
        Microfacets::new(self.alpha).smooth
    }

    #[inline(always)]
    fn gloss(&self, _: R) -> Option<Gloss<R>> {
        Some(Gloss::only(self.alpha))
    }
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
