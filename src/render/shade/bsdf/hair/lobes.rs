//! Lobes of a hair, given the direction to where a path came from.

use std::f64::consts::PI;

use super::{Hair, LOBES};
use crate::shade::bsdf::fresnel::Refraction;
use petzval_base::lanes::Real;
use petzval_base::lanes::angle::signed_angle;
use petzval_base::lanes::math::exp_negative;

/// The lobes of a hair.
pub(super) struct HairLobes<R> {
    /// Sine and cosine of the inclination around which a lobe is mirrored.
    pub(super) inclination: [[R; 2]; LOBES],
    /// Share of the light by lobe and colour channel.
    pub(super) attenuation: [[R; 3]; LOBES],
    /// Probability of sampling the lobe.
    pub(super) probability: [R; LOBES],
    /// Azimuth at which a perfectly smooth fibre sends the light out (rad); the last lobe is
    /// uniform.
    pub(super) azimuth: [R; LOBES - 1],
}

/// Keeps quotients finite.
const TINY: f32 = 1e-20;

impl<R: Real<Scalar = f32>> Hair<R> {
    /// Returns the lobes for a sine and cosine of inclination.
    #[inline(always)]
    pub(super) fn lobes(&self, [sin, cos]: [R; 2]) -> HairLobes<R> {
        let (zero, one, two) = (R::splat(0.0), R::splat(1.0), R::splat(2.0));
        let tiny = R::splat(TINY);
        let h = self.offset;
        let root = |square: R| square.max(zero).sqrt();
        // Marschner et al. 2003, "Light scattering from human hair fibers": the fibre's plane of
        // refraction has the index `modified`, which is sqrt(eta^2 - sin^2) / cos.
        let sin_t = sin / self.eta;
        let cos_t = root((one - sin_t) * (one + sin_t)).max(tiny);
        let bent = root(self.eta.square() - sin.square()).max(tiny);
        let sin_gamma_t = (h * cos / bent).max(-one).min(one);
        let cos_gamma_t = root((one - sin_gamma_t) * (one + sin_gamma_t));
        let cos_gamma_o = root((one - h) * (one + h));
        let f = Refraction::new(cos * cos_gamma_o, self.eta).reflectance;
        let path = two * cos_gamma_t / cos_t;
        let mut attenuation = [[f; 3]; LOBES];
        for channel in 0..3 {
            let passes = exp_negative(-(self.absorption[channel] * path));
            let entered = (one - f).square() * passes;
            let inside = passes * f;
            attenuation[1][channel] = entered;
            attenuation[2][channel] = entered * inside;
            // The sum of the geometric series of further reflections inside.
            attenuation[3][channel] = entered * inside * inside / (one - inside).max(tiny);
        }
        let mut probability = [zero; LOBES];
        let mut total = zero;
        for p in 0..LOBES {
            let [r, g, b] = attenuation[p];
            probability[p] = r + g + b;
            total = total + probability[p];
        }
        for p in 0..LOBES {
            probability[p] = probability[p] / total.max(tiny);
        }
        let gamma_o = signed_angle(h, cos_gamma_o);
        let gamma_t = signed_angle(sin_gamma_t, cos_gamma_t);
        let exit = |p: f64| R::constant(2.0 * p) * gamma_t - two * gamma_o + R::constant(p * PI);
        let tilted = |[s, c]: [R; 2]| [sin * c + cos * s, (cos * c - sin * s).abs()];
        let [once, twice, four_times] = self.tilts;
        HairLobes {
            inclination: [
                tilted([-twice[0], twice[1]]),
                tilted(once),
                tilted(four_times),
                [sin, cos],
            ],
            attenuation,
            probability,
            azimuth: [exit(0.0), exit(1.0), exit(2.0)],
        }
    }
}
