//! Light that leaves a medium through its boundary.

use super::{Bsdf, BsdfSample, CoatWalks, Refraction, SurfaceTextures, VertexParameters, columns};
use petzval_base::lanes::Real;
use petzval_base::sampler::concentric_disk;
use petzval_scene::MaterialModel;

columns! {
    /// Diffuse transmission from the outside to a path inside a medium, with the distribution
    /// 1 - F(cos) (Jensen et al. 2001, "A practical model for subsurface light transport", equation 5).
    /// The normal points outwards. The path has been chosen with the probability that light leaves.
    #[derive(Clone, Copy, Debug)]
    pub struct SubsurfaceExit<R> {
        /// Refractive index of the medium over that outside.
        pub eta: R,
        /// Share of diffuse light from the outside that enters.
        pub entering: R,
    }
}

impl<R: Real<Scalar = f32>> VertexParameters<R> for SubsurfaceExit<R> {
    type Bsdf = Self;
    const NAME: &'static str = "subsurface";
    const ONE_SIDED: bool = false;

    /// Returns `None`: the parameters are those of a medium's boundary.
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

impl<R: Real<Scalar = f32>> SubsurfaceExit<R> {
    /// Returns the value over cos / pi, for light from a direction of this cosine. Radiance inside
    /// is larger by eta^2.
    #[inline(always)]
    fn value(&self, cos: R) -> R {
        let reflected = Refraction::new(cos, self.eta).reflectance;
        self.eta * self.eta * (R::splat(1.0) - reflected) / self.entering
    }
}

impl<R: Real<Scalar = f32>> Bsdf<R> for SubsurfaceExit<R> {
    #[inline(always)]
    fn evaluate(&self, _: [R; 3], wi: [R; 3]) -> ([R; 3], R) {
        let pdf = wi[2].max(R::splat(0.0)) * R::constant(std::f64::consts::FRAC_1_PI);
        ([pdf * self.value(wi[2].max(R::splat(0.0))); 3], pdf)
    }

    #[inline(always)]
    fn sample(&self, _: [R; 3], u: [R; 2], _: R) -> BsdfSample<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let [x, y] = concentric_disk(u[0], u[1]);
        let z = (one - x.mul_add(x, y * y)).max(zero).sqrt();
        BsdfSample {
            wi: [x, y, z],
            weight: [self.value(z); 3],
            pdf: z * R::constant(std::f64::consts::FRAC_1_PI),
            singular: one.lt(zero),
            valid: zero.lt(z),
            eta2: one / (self.eta * self.eta),
        }
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        R::splat(1.0).lt(R::splat(0.0))
    }
}
