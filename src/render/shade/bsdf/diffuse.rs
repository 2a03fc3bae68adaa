//! Diffuse surface, by Lambert's law.

use super::{Bsdf, BsdfSample, CoatWalks, SurfaceTextures, VertexParameters, columns};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::max_component;
use petzval_base::sampler::concentric_disk;
use petzval_scene::MaterialModel;

columns! {
    /// A Lambertian reflector (Lambert 1760), the same from both sides.
    #[derive(Clone, Copy, Debug)]
    pub struct Diffuse<R> {
        /// The share of light reflected, by colour channel.
        pub reflectance: [R; 3],
    }
}

impl<R: Real<Scalar = f32>> VertexParameters<R> for Diffuse<R> {
    type Bsdf = Self;
    const NAME: &'static str = "diffuse";
    const ONE_SIDED: bool = true;
    const CATCHES_CAUSTICS: bool = true;
    const DIFFUSE: bool = true;

    #[inline(always)]
    fn of(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<Self> {
        let MaterialModel::Diffuse { reflectance } = model else { return None };
        Some(Self { reflectance: textures.share(reflectance) })
    }

    fn albedo(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<[R; 3]> {
        Some(Self::of(model, textures)?.reflectance)
    }

    #[inline(always)]
    fn bsdf(self, _: CoatWalks<R>) -> Self {
        self
    }
}

/// Samples a direction of the upper hemisphere with density cos / pi.
#[inline(always)]
pub(super) fn cosine<R: Real<Scalar = f32>>(u: [R; 2]) -> [R; 3] {
    let [x, y] = concentric_disk(u[0], u[1]);
    let z2 = R::splat(1.0) - x.mul_add(x, y * y);
    [x, y, z2.max(R::splat(0.0)).sqrt()]
}

/// Returns 1 / pi.
#[inline(always)]
pub(super) fn inverse_pi<R: Real<Scalar = f32>>() -> R {
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
