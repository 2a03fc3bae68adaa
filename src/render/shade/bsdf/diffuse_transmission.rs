//! Diffuse surface that light passes, by Lambert's law.

use super::diffuse::{cosine, inverse_pi};
use super::{
    Bsdf, BsdfSample, CoatWalks, SurfaceTextures, VertexParameters, clamp_to_unit, columns,
};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{max_component, scale};
use petzval_scene::MaterialModel;

columns! {
    /// A Lambertian reflector and transmitter, the same from both sides.
    #[derive(Clone, Copy, Debug)]
    pub struct DiffuseTransmission<R> {
        /// The share of light reflected, by colour channel.
        pub reflectance: [R; 3],
        /// The share of light transmitted, by colour channel.
        pub transmittance: [R; 3],
    }
}

impl<R: Real<Scalar = f32>> VertexParameters<R> for DiffuseTransmission<R> {
    type Bsdf = Self;
    const NAME: &'static str = "diffusetransmission";
    const ONE_SIDED: bool = false;
    const CATCHES_CAUSTICS: bool = true;
    const DIFFUSE: bool = true;

    #[inline(always)]
    fn of(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<Self> {
        let MaterialModel::DiffuseTransmission { reflectance, transmittance, scale: factor } =
            model
        else {
            return None;
        };
        let scaled = |texture| clamp_to_unit(scale(textures.colour(texture), R::splat(*factor)));
        Some(Self { reflectance: scaled(reflectance), transmittance: scaled(transmittance) })
    }

    fn albedo(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<[R; 3]> {
        let MaterialModel::DiffuseTransmission { reflectance, transmittance, scale: factor } =
            model
        else {
            return None;
        };
        let ([r, g, b], [tr, tg, tb]) =
            (textures.colour(reflectance), textures.colour(transmittance));
        Some(clamp_to_unit(scale([r + tr, g + tg, b + tb], R::splat(*factor))))
    }

    #[inline(always)]
    fn bsdf(self, _: CoatWalks<R>) -> Self {
        self
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
