//! Parameters of a coat and of the surfaces that have one.

use super::{CoatLayer, CoatWalks, Coated, SeededCoat};
use crate::shade::bsdf::conductor::ConductorParameters;
use crate::shade::bsdf::gloss::mean;
use crate::shade::bsdf::{
    Bsdf, Conductor, Dielectric, Diffuse, Gloss, Refraction, SurfaceTextures, VertexParameters,
    columns,
};
use petzval_base::lanes::Real;
use petzval_scene::{DielectricCoat, MaterialModel};

columns! {
    /// Parameters of the layer over a surface.
    #[derive(Clone, Copy, Debug)]
    pub(in crate::shade) struct CoatParameters<R> {
        /// Width alpha of the microfacets of the interface along u and v.
        alpha: [R; 2],
        /// Refractive index of the layer over that outside.
        eta: R,
        /// Thickness [mean free paths].
        thickness: R,
        /// Single-scattering albedo, by colour channel.
        albedo: [R; 3],
        /// Asymmetry of the scattering in the layer.
        g: R,
        /// Maximum number of events of a walk.
        max_depth: R,
        /// Number of walks of an evaluation.
        samples: R,
    }
}

columns! {
    /// Parameters of a diffuse surface under a coat.
    #[derive(Clone, Copy, Debug)]
    pub(in crate::shade) struct CoatedDiffuseParameters<R> {
        base: Diffuse<R>,
        coat: CoatParameters<R>,
    }
}

columns! {
    /// Parameters of a metal under a coat.
    #[derive(Clone, Copy, Debug)]
    pub(in crate::shade) struct CoatedConductorParameters<R> {
        /// The metal, whose refractive index is relative to that of the coat.
        base: ConductorParameters<R>,
        coat: CoatParameters<R>,
    }
}

impl<R: Real<Scalar = f32>> CoatParameters<R> {
    #[inline(always)]
    fn of_coat(coat: &DielectricCoat, textures: &impl SurfaceTextures<R>) -> Self {
        let one = R::splat(1.0);
        Self {
            alpha: textures.alpha(&coat.roughness),
            eta: R::splat(coat.eta),
            thickness: textures.number(&coat.thickness),
            albedo: textures.share(&coat.albedo),
            g: textures.number(&coat.g).max(-one).min(one),
            max_depth: R::splat(coat.max_depth as f32),
            samples: R::splat(coat.samples as f32),
        }
    }

    /// Builds the BSDF of a base under the layer.
    #[inline(always)]
    fn over<B: Bsdf<R>>(self, base: B, walks: CoatWalks<R>) -> SeededCoat<R, B> {
        let Self { alpha, eta, thickness, albedo, g, max_depth, samples } = self;
        let (interface, weights) = (Dielectric::new(alpha, eta), walks.weights);
        let layer = CoatLayer { interface, thickness, albedo, g, max_depth, samples, weights };
        Coated::new(layer, base).seeded(walks.seed)
    }
}

impl<R: Real<Scalar = f32>> VertexParameters<R> for CoatedDiffuseParameters<R> {
    type Bsdf = SeededCoat<R, Diffuse<R>>;
    const NAME: &'static str = "coateddiffuse";
    const ONE_SIDED: bool = true;
    const CATCHES_CAUSTICS: bool = true;
    const WALKS: bool = true;

    #[inline(always)]
    fn of(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<Self> {
        let MaterialModel::CoatedDiffuse { reflectance, coat } = model else { return None };
        let base = Diffuse { reflectance: textures.share(reflectance) };
        Some(Self { base, coat: CoatParameters::of_coat(coat, textures) })
    }

    /// Returns the albedo of the base.
    fn albedo(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<[R; 3]> {
        let MaterialModel::CoatedDiffuse { reflectance, .. } = model else { return None };
        Some(textures.share(reflectance))
    }

    #[inline(always)]
    fn bsdf(self, walks: CoatWalks<R>) -> SeededCoat<R, Diffuse<R>> {
        self.coat.over(self.base, walks)
    }

    #[inline(always)]
    fn for_each_width(&mut self, change: impl FnMut(&mut R)) {
        self.coat.alpha.iter_mut().for_each(change);
    }

    #[inline(always)]
    fn gloss(&self, cos: R) -> Option<Gloss<R>> {
        let reflected = Refraction::new(cos, self.coat.eta).reflectance;
        let wide = (R::splat(1.0) - reflected) * mean(self.base.reflectance);
        Some(Gloss { alpha: self.coat.alpha, glossy: reflected, wide })
    }
}

impl<R: Real<Scalar = f32>> VertexParameters<R> for CoatedConductorParameters<R> {
    type Bsdf = SeededCoat<R, Conductor<R>>;
    const NAME: &'static str = "coatedconductor";
    const ONE_SIDED: bool = true;
    const CATCHES_CAUSTICS: bool = true;
    const WALKS: bool = true;

    #[inline(always)]
    fn of(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<Self> {
        let MaterialModel::CoatedConductor { metal, roughness, coat } = model else { return None };
        let mut base = ConductorParameters::of_metal(metal, roughness, textures);
        for channel in 0..3 {
            base.eta[channel] = base.eta[channel] / R::splat(coat.eta);
            base.k[channel] = base.k[channel] / R::splat(coat.eta);
        }
        Some(Self { base, coat: CoatParameters::of_coat(coat, textures) })
    }

    /// Returns the albedo of the metal in air.
    fn albedo(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<[R; 3]> {
        let MaterialModel::CoatedConductor { metal, roughness, .. } = model else { return None };
        Some(ConductorParameters::of_metal(metal, roughness, textures).normal_reflectance())
    }

    #[inline(always)]
    fn bsdf(self, walks: CoatWalks<R>) -> SeededCoat<R, Conductor<R>> {
        self.coat.over(self.base.conductor(), walks)
    }

    #[inline(always)]
    fn for_each_width(&mut self, change: impl FnMut(&mut R)) {
        self.base.alpha.iter_mut().chain(&mut self.coat.alpha).for_each(change);
    }

    #[inline(always)]
    fn gloss(&self, _: R) -> Option<Gloss<R>> {
        // Light passes the coat twice.
        let width = |base: R, coat: R| (base * base + (coat * coat) * R::splat(2.0)).sqrt();
        let ([u, v], [coat_u, coat_v]) = (self.base.alpha, self.coat.alpha);
        Some(Gloss::only([width(u, coat_u), width(v, coat_v)]))
    }
}
