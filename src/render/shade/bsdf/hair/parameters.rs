//! Parameters of a hair.

use super::Hair;
use crate::shade::bsdf::{CoatWalks, SurfaceTextures, VertexParameters, columns};
use petzval_base::lanes::Real;
use petzval_base::lanes::math::{exp_negative, ln};
use petzval_scene::{HairColour, HairFibre, MaterialModel};

/// Least reflectance of a hair: its absorption leaves no light, and its logarithm is finite.
const LEAST_REFLECTANCE: f32 = 1e-30;

columns! {
    /// Properties of a hair at a point.
    #[derive(Clone, Copy, Debug)]
    pub struct HairParameters<R> {
        /// Absorption by colour channel [per radius].
        pub absorption: [R; 3],
        /// Refractive index.
        pub eta: R,
        /// Longitudinal roughness, clamped to 0.01 to 1.
        pub beta_m: R,
        /// Azimuthal roughness, clamped to 0.01 to 1.
        pub beta_n: R,
        /// Angle of the scales (degrees).
        pub tilt: R,
        /// Offset from the axis as the ray sees it, clamped to -1 to 1 (radii).
        pub offset: R,
    }
}

impl<R: Real<Scalar = f32>> VertexParameters<R> for HairParameters<R> {
    type Bsdf = Hair<R>;
    const NAME: &'static str = "hair";
    const ONE_SIDED: bool = false;

    #[inline(always)]
    fn of(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<Self> {
        let MaterialModel::Hair(fibre) = model else { return None };
        let beta_n = textures.number(&fibre.beta_n);
        // v of the texture coordinates runs across the hair.
        let [_, v] = textures.uv();
        Some(Self {
            absorption: absorption(fibre, textures, beta_n),
            eta: textures.number(&fibre.eta),
            beta_m: textures.number(&fibre.beta_m),
            beta_n,
            tilt: textures.number(&fibre.alpha),
            offset: (v + v) - R::splat(1.0),
        })
    }

    /// Returns the approximate reflectance of many hairs.
    fn albedo(model: &MaterialModel, textures: &impl SurfaceTextures<R>) -> Option<[R; 3]> {
        let Self { absorption: [r, g, b], beta_n, .. } = Self::of(model, textures)?;
        let scale = log_scale(beta_n);
        let channel = |sigma: R| exp_negative(-(sigma.sqrt() * scale));
        Some([channel(r), channel(g), channel(b)])
    }

    #[inline(always)]
    fn bsdf(self, _: CoatWalks<R>) -> Hair<R> {
        Hair::new(self)
    }
}

/// Returns the absorption by colour channel [per radius].
#[inline(always)]
fn absorption<R: Real<Scalar = f32>>(
    fibre: &HairFibre,
    textures: &impl SurfaceTextures<R>,
    beta_n: R,
) -> [R; 3] {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let mut sum = [zero; 3];
    match &fibre.colour {
        HairColour::Absorption(absorption) => {
            let absorption = textures.colour(absorption);
            for channel in 0..3 {
                sum[channel] = absorption[channel].max(zero);
            }
        }
        HairColour::Reflectance(reflectance) => {
            let (reflectance, scale) = (textures.colour(reflectance), one / log_scale(beta_n));
            for channel in 0..3 {
                let share = reflectance[channel].max(R::splat(LEAST_REFLECTANCE)).min(one);
                sum[channel] = (ln(share) * scale).square();
            }
        }
        HairColour::Melanin { eumelanin, pheomelanin, absorption: [brown, rust] } => {
            let dark = textures.number(eumelanin).max(zero);
            let red = textures.number(pheomelanin).max(zero);
            for channel in 0..3 {
                let (e, p) = (R::splat(brown[channel]), R::splat(rust[channel]));
                sum[channel] = dark * e + red * p;
            }
        }
    }
    sum
}

/// Returns the factor between the root of the absorption and the logarithm of the reflectance of
/// many hairs: a fit of Chiang et al. 2016, equation 9.
#[inline(always)]
fn log_scale<R: Real<Scalar = f32>>(beta_n: R) -> R {
    let n = beta_n.max(R::splat(0.01)).min(R::splat(1.0));
    let fit = [0.245, 5.574, -10.73, 2.532, -0.215, 5.969];
    let mut sum = R::constant(fit[0]);
    for k in 1..fit.len() {
        sum = sum * n + R::constant(fit[k]);
    }
    sum
}
