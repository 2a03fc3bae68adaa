//! Phase function of scattering in a medium.

use super::shading_frame::ShadingFrame;
use super::{Bsdf, BsdfSample, CoatWalks, SurfaceTextures, VertexParameters, columns};
use petzval_base::lanes::Real;
use petzval_base::lanes::math::sin_cos_turns;
use petzval_base::lanes::vector::{dot, renormalize};
use petzval_scene::{MaterialModel, henyey_greenstein, sample_henyey_greenstein_cosine};

columns! {
    /// Scattering in a medium, by the phase function of Henyey & Greenstein.
    #[derive(Clone, Copy, Debug)]
    pub struct MediumScattering<R> {
        /// Asymmetry, -1 to 1.
        pub g: R,
    }
}

impl<R: Real<Scalar = f32>> VertexParameters<R> for MediumScattering<R> {
    type Bsdf = Self;
    const NAME: &'static str = "medium";
    const ONE_SIDED: bool = false;

    /// Returns `None`: the parameters are those of a medium.
    fn of(_: &MaterialModel, _: &impl SurfaceTextures<R>) -> Option<Self> {
        None
    }

    fn albedo(_: &MaterialModel, _: &impl SurfaceTextures<R>) -> Option<[R; 3]> {
        None
    }

    #[inline(always)]
    fn bsdf(self, _: CoatWalks<R>) -> Self {
        self
    }
}

impl<R: Real<Scalar = f32>> Bsdf<R> for MediumScattering<R> {
    #[inline(always)]
    fn evaluate(&self, wo: [R; 3], wi: [R; 3]) -> ([R; 3], R) {
        let phase = henyey_greenstein(dot(wo, wi), self.g);
        ([phase; 3], phase)
    }

    #[inline(always)]
    fn sample(&self, wo: [R; 3], u: [R; 2], _: R) -> BsdfSample<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let wi = sample_henyey_greenstein(wo, self.g, u);
        BsdfSample {
            wi,
            weight: [one; 3],
            pdf: henyey_greenstein(dot(wo, wi), self.g),
            singular: one.lt(zero),
            valid: zero.lt(one),
            eta2: one,
        }
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        R::splat(1.0).lt(R::splat(0.0))
    }
}

/// Samples a direction to where light comes from, with the density of [`henyey_greenstein`]. It is a unit
/// vector if `wo` is nearly one: a frame about `wo` doubles the error of its length, and the next
/// scattering would double it again.
#[inline(always)]
pub fn sample_henyey_greenstein<R: Real<Scalar = f32>>(wo: [R; 3], g: R, u: [R; 2]) -> [R; 3] {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let cos = sample_henyey_greenstein_cosine(g, u[0]);
    let sin = (one - cos * cos).max(zero).sqrt();
    let [y, x] = sin_cos_turns(u[1]);
    renormalize(ShadingFrame::about(wo, [zero; 3]).to_world([sin * x, sin * y, cos]))
}
