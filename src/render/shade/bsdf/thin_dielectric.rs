//! Thin dielectric: a sheet of glass without thickness.

use super::fresnel::Refraction;
use super::lobe_choice::LobeChoice;
use super::{Bsdf, BsdfSample, CoatWalks, SurfaceTextures, VertexParameters, columns};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{negate, scale, select};
use petzval_scene::MaterialModel;

columns! {
    /// A sheet of glass without thickness. Light is reflected or goes straight on, after any number of
    /// reflections between the two sides.
    #[derive(Clone, Copy, Debug)]
    pub struct ThinDielectric<R> {
        eta: R,
        /// Share of the transmitted light that is kept, by colour channel.
        tint: [R; 3],
    }
}

impl<R: Real<Scalar = f32>> VertexParameters<R> for ThinDielectric<R> {
    type Bsdf = Self;
    const NAME: &'static str = "thindielectric";
    const ONE_SIDED: bool = false;

    #[inline(always)]
    fn of(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<Self> {
        let MaterialModel::ThinDielectric { eta, tint } = model else { return None };
        Some(Self::new(R::splat(*eta)).tinted(textures.share(tint)))
    }

    fn albedo(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<[R; 3]> {
        Some(Self::of(model, textures)?.tint)
    }

    #[inline(always)]
    fn bsdf(self, _: CoatWalks<R>) -> Self {
        self
    }

    #[inline(always)]
    fn unlit(&self) -> R::Mask {
        self.singular()
    }
}

impl<R: Real<Scalar = f32>> ThinDielectric<R> {
    /// A sheet of refractive index `eta`, relative to the medium around it. An index <= 0 counts
    /// as 1.
    #[inline(always)]
    pub fn new(eta: R) -> Self {
        let one = R::splat(1.0);
        Self { eta: R::select(R::splat(0.0).lt(eta), eta, one), tint: [one; 3] }
    }

    /// Returns the sheet with this share of the transmitted light kept, by colour channel.
    #[inline(always)]
    pub fn tinted(self, tint: [R; 3]) -> Self {
        Self { tint, ..self }
    }
}

impl<R: Real<Scalar = f32>> Bsdf<R> for ThinDielectric<R> {
    #[inline(always)]
    fn evaluate(&self, _wo: [R; 3], _wi: [R; 3]) -> ([R; 3], R) {
        ([R::splat(0.0); 3], R::splat(0.0))
    }

    #[inline(always)]
    fn sample(&self, wo: [R; 3], _u: [R; 2], choice: R) -> BsdfSample<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let once = Refraction::new(wo[2].abs(), self.eta).reflectance;
        // The geometric series R + T R T + T R^3 T + ... of both sides.
        let reflected = R::splat(2.0) * once / (one + once);
        let [here, there] = LobeChoice::OfGlass.chances(reflected);
        let reflects = choice.lt(here);
        let passed = one - reflected;
        BsdfSample {
            wi: select(reflects, [-wo[0], -wo[1], wo[2]], negate(wo)),
            weight: select(reflects, [reflected / here; 3], scale(self.tint, passed / there)),
            pdf: zero,
            singular: self.singular(),
            valid: zero.lt(wo[2].abs()),
            eta2: one,
        }
        .only(reflects | zero.lt(passed))
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        R::splat(0.0).le(R::splat(0.0))
    }
}
