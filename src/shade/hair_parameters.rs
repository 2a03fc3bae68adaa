//! Parameters of hairs at surface points.

use super::shading_context::ShadingContext;
use crate::lanes::Real;
use crate::lanes::math::{exp_negative, ln};
use crate::scene::{HairColour, HairFibre};

/// Least reflectance of a hair: its absorption leaves no light, and its logarithm is finite.
const LEAST_REFLECTANCE: f32 = 1e-30;

/// Absorption of eumelanin and pheomelanin of concentration 1, by colour channel [per radius]
/// (d'Eon et al. 2011, "An energy-conserving hair reflectance model").
const EUMELANIN: [f32; 3] = [0.419, 0.697, 1.37];
const PHEOMELANIN: [f32; 3] = [0.187, 0.4, 1.05];

/// Returns the parameters of a hair: absorption, refractive index, roughnesses, tilt, and offset
/// from the axis. v of the texture coordinates runs across the hair.
#[inline(always)]
pub(super) fn hair_parameters<R: Real<Scalar = f32>>(
    fibre: &HairFibre,
    context: &ShadingContext<R>,
) -> [R; 8] {
    let one = R::splat(1.0);
    let beta_n = context.number(&fibre.beta_n);
    let [r, g, b] = absorption(fibre, context, beta_n);
    let v = context.patch.uv[1];
    [
        r,
        g,
        b,
        context.number(&fibre.eta),
        context.number(&fibre.beta_m),
        beta_n,
        context.number(&fibre.alpha),
        (v + v) - one,
    ]
}

/// Returns the absorption by colour channel [per radius].
#[inline(always)]
fn absorption<R: Real<Scalar = f32>>(
    fibre: &HairFibre,
    context: &ShadingContext<R>,
    beta_n: R,
) -> [R; 3] {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    let mut sum = [zero; 3];
    match &fibre.colour {
        HairColour::Absorption(absorption) => {
            let absorption = context.colour(absorption);
            for channel in 0..3 {
                sum[channel] = absorption[channel].max(zero);
            }
        }
        HairColour::Reflectance(reflectance) => {
            let (reflectance, scale) = (context.colour(reflectance), one / log_scale(beta_n));
            for channel in 0..3 {
                let share = reflectance[channel].max(R::splat(LEAST_REFLECTANCE)).min(one);
                sum[channel] = (ln(share) * scale).square();
            }
        }
        HairColour::Melanin { eumelanin, pheomelanin } => {
            let dark = context.number(eumelanin).max(zero);
            let red = context.number(pheomelanin).max(zero);
            for channel in 0..3 {
                let (e, p) = (R::splat(EUMELANIN[channel]), R::splat(PHEOMELANIN[channel]));
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

/// Returns the approximate reflectance of many hairs by channel.
pub(super) fn hair_albedo(fibre: &HairFibre, context: &ShadingContext) -> [f32; 3] {
    let beta_n = context.number(&fibre.beta_n);
    let scale = log_scale(beta_n);
    absorption(fibre, context, beta_n).map(|sigma| exp_negative(-(sigma.sqrt() * scale)))
}
