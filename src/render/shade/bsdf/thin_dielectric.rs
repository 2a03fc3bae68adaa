//! Thin dielectric: a sheet of glass without thickness.

use super::fresnel::Refraction;
use super::lobe_choice::LobeChoice;
use super::{Bsdf, BsdfSample, CoatWalks, SurfaceTextures, VertexParameters, columns};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{negate, select, splat};
use petzval_scene::MaterialModel;

columns! {
    /// A sheet of glass without thickness. Light is reflected or goes straight on, after any number of
    /// reflections between the two sides.
    #[derive(Clone, Copy, Debug)]
    pub struct ThinDielectric<R> {
        /// Refractive index, by colour channel.
        eta: [R; 3],
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
        let MaterialModel::ThinDielectric { eta, tint, .. } = model else { return None };
        Some(Self::new(splat(*eta)).tinted(textures.share(tint)))
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
    /// A sheet of refractive index `eta`, by channel, relative to the medium around it. An index <= 0
    /// counts as 1.
    #[inline(always)]
    pub fn new(eta: [R; 3]) -> Self {
        let one = R::splat(1.0);
        Self { eta: eta.map(|eta| R::select(R::splat(0.0).lt(eta), eta, one)), tint: [one; 3] }
    }

    /// Returns the share of the light of a channel that is reflected: the geometric series
    /// R + T R T + T R^3 T + ... of both sides.
    #[inline(always)]
    fn reflectance(&self, cos: R, channel: usize) -> R {
        let once = Refraction::new(cos, self.eta[channel]).reflectance;
        R::splat(2.0) * once / (R::splat(1.0) + once)
    }

    /// Returns the reflectances of all channels, and their mean.
    #[inline(always)]
    fn reflectances(&self, cos: R) -> ([R; 3], R) {
        let first = self.reflectance(cos, 0);
        let [a, b, c] = self.eta;
        let grey = a.equals(b) & a.equals(c);
        if R::bits(!grey) == 0 {
            return ([first; 3], first);
        }
        let all = [first, self.reflectance(cos, 1), self.reflectance(cos, 2)];
        let mean = (all[0] + all[1] + all[2]) * R::constant(1.0 / 3.0);
        (all, R::select(grey, first, mean))
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
        let (reflected, mean) = self.reflectances(wo[2].abs());
        let [here, there] = LobeChoice::OfGlass.chances(mean);
        let reflects = choice.lt(here);
        let (mut mirrored, mut passed) = ([zero; 3], [zero; 3]);
        for c in 0..3 {
            mirrored[c] = reflected[c] / here;
            passed[c] = self.tint[c] * ((one - reflected[c]) / there);
        }
        BsdfSample {
            wi: select(reflects, [-wo[0], -wo[1], wo[2]], negate(wo)),
            weight: select(reflects, mirrored, passed),
            pdf: zero,
            singular: self.singular(),
            valid: zero.lt(wo[2].abs()),
            eta2: one,
        }
        .only(reflects | zero.lt(one - mean))
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        R::splat(0.0).le(R::splat(0.0))
    }
}
