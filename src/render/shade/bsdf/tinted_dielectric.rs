//! Tinted dielectric: an interface whose transmitted light has a colour.

use super::dielectric::Dielectric;
use super::microfacet::Microfacets;
use super::{Bsdf, BsdfSample, CoatWalks, SurfaceTextures, VertexParameters, columns};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::select;
use petzval_scene::MaterialModel;

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

columns! {
    /// Parameters of a [`TintedDielectric`].
    #[derive(Clone, Copy, Debug)]
    pub(in crate::shade) struct TintedDielectricParameters<R> {
        /// Width alpha of the microfacets along u and v.
        alpha: [R; 2],
        /// Refractive index inside over that outside.
        eta: R,
        /// Share of the transmitted light that is kept.
        tint: [R; 3],
    }
}

impl<R: Real<Scalar = f32>> VertexParameters<R> for TintedDielectricParameters<R> {
    type Bsdf = TintedDielectric<R>;
    const NAME: &'static str = "dielectric";
    const ONE_SIDED: bool = false;

    #[inline(always)]
    fn of(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<Self> {
        let (eta, roughness, tint) = match model {
            MaterialModel::Dielectric { eta, roughness, .. } => (*eta, roughness, None),
            MaterialModel::Subsurface { interior, roughness } => (interior.eta, roughness, None),
            MaterialModel::TintedDielectric { eta, roughness, tint } => {
                (*eta, roughness, Some(tint))
            }
            _ => return None,
        };
        let tint = match tint {
            Some(tint) => textures.share(tint),
            None => [R::splat(1.0); 3],
        };
        Some(Self { alpha: textures.alpha(roughness), eta: R::splat(eta), tint })
    }

    fn albedo(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<[R; 3]> {
        Some(Self::of(model, textures)?.tint)
    }

    #[inline(always)]
    fn bsdf(self, _: CoatWalks<R>) -> TintedDielectric<R> {
        let Self { alpha, eta, tint } = self;
        TintedDielectric { interface: Dielectric::new(alpha, eta), tint }
    }

    #[inline(always)]
    fn for_each_width(&mut self, change: impl FnMut(&mut R)) {
        self.alpha.iter_mut().for_each(change);
    }

    #[inline(always)]
    fn unlit(&self) -> R::Mask {
        Microfacets::new(self.alpha).smooth
    }
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
