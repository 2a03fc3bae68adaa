//! Hair: light that a fibre reflects, transmits, and reflects inside, with pbrt-v4's conventions.
//!
//! The model is that of Chiang, Bitterli, Tappan & Burley 2016, "A practical and controllable hair
//! and fur model for production path tracing". x is along the fibre. Light of the lobe p is
//! reflected p - 1 times inside the fibre; the last lobe stands for all further ones. Each lobe is
//! a product of a longitudinal term M, an attenuation A and an azimuthal term N.

mod lobes;
mod parameters;
mod terms;

use std::f64::consts::PI;

use super::{Bsdf, BsdfSample};
use lobes::HairLobes;
pub use parameters::HairParameters;
use petzval_base::lanes::Real;
use petzval_base::lanes::angle::signed_angle;
use petzval_base::lanes::math::sin_cos_turns;
use terms::{longitudinal, sample_longitudinal, sample_trimmed_logistic, trimmed_logistic, wrap};

/// Number of lobes.
const LOBES: usize = 4;

/// A hair (Chiang et al. 2016). Light counts from all directions.
#[derive(Clone, Copy, Debug)]
pub struct Hair<R> {
    absorption: [R; 3],
    eta: R,
    offset: R,
    /// Longitudinal variance by lobe.
    variance: [R; LOBES],
    /// Scale of the logistic distribution of azimuths (rad).
    spread: R,
    /// Sine and cosine of the tilt times 1, 2 and 4.
    tilts: [[R; 2]; 3],
}

/// Least roughness, as in pbrt-v4.
const LEAST_ROUGHNESS: f32 = 0.01;

impl<R: Real<Scalar = f32>> Hair<R> {
    /// Makes a hair. The variance and the spread by roughness are fits of Chiang et al. 2016,
    /// equations 7 and 8.
    #[inline(always)]
    pub fn new(parameters: HairParameters<R>) -> Self {
        let (zero, one, two) = (R::splat(0.0), R::splat(1.0), R::splat(2.0));
        let HairParameters { absorption: [r, g, b], eta, beta_m, beta_n, tilt, offset } =
            parameters;
        let m = beta_m.max(R::splat(LEAST_ROUGHNESS)).min(one);
        let n = beta_n.max(R::splat(LEAST_ROUGHNESS)).min(one);
        let fourth = |x: R| x.square().square();
        let m20 = fourth(fourth(m)) * fourth(m);
        let n22 = fourth(fourth(n)) * fourth(n) * n.square();
        let deviation =
            R::constant(0.726) * m + R::constant(0.812) * m.square() + R::constant(3.7) * m20;
        let variance = deviation.square();
        let spread =
            R::constant(0.265) * n + R::constant(1.194) * n.square() + R::constant(5.372) * n22;
        let four = R::splat(4.0);
        let turns = tilt / R::splat(360.0);
        let once = sin_cos_turns(turns - turns.floor());
        let double = |[sin, cos]: [R; 2]| [two * sin * cos, cos.square() - sin.square()];
        let twice = double(once);
        Self {
            absorption: [r.max(zero), g.max(zero), b.max(zero)],
            eta,
            offset: offset.max(-one).min(one),
            variance: [variance, variance / four, four * variance, four * variance],
            spread: R::constant((PI / 8.0).sqrt()) * spread,
            tilts: [once, twice, double(twice)],
        }
    }

    /// Returns f |cos wi| by colour channel and the density of a direction, given the lobes of
    /// `wo`, the sine and cosine of the direction's inclination, and its azimuth from that of `wo`.
    #[inline(always)]
    fn sum(&self, lobes: &HairLobes<R>, [sin, cos]: [R; 2], azimuth: R) -> ([R; 3], R) {
        let (mut value, mut pdf) = ([R::splat(0.0); 3], R::splat(0.0));
        for p in 0..LOBES {
            let m = longitudinal([sin, cos], lobes.inclination[p], self.variance[p]);
            let n = match lobes.azimuth.get(p) {
                Some(&exit) => trimmed_logistic(wrap(azimuth - exit), self.spread),
                None => R::constant(0.5 / PI),
            };
            let density = m * n;
            for channel in 0..3 {
                value[channel] = value[channel] + density * lobes.attenuation[p][channel];
            }
            pdf = pdf + density * lobes.probability[p];
        }
        (value, pdf)
    }
}

/// Returns the sine and cosine of the inclination of a unit vector from the plane across the fibre.
#[inline(always)]
fn inclination<R: Real<Scalar = f32>>(w: [R; 3]) -> [R; 2] {
    let one = R::splat(1.0);
    let sin = w[0].max(-one).min(one);
    [sin, ((one - sin) * (one + sin)).sqrt()]
}

impl<R: Real<Scalar = f32>> Bsdf<R> for Hair<R> {
    #[inline(always)]
    fn evaluate(&self, wo: [R; 3], wi: [R; 3]) -> ([R; 3], R) {
        let azimuth = signed_angle(wi[2] * wo[1] - wi[1] * wo[2], wi[1] * wo[1] + wi[2] * wo[2]);
        self.sum(&self.lobes(inclination(wo)), inclination(wi), azimuth)
    }

    #[inline(always)]
    fn sample(&self, wo: [R; 3], u: [R; 2], choice: R) -> BsdfSample<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let lobes = self.lobes(inclination(wo));
        // The lobe, and what is left of the number that chose it.
        let mut chosen = lobes.inclination[LOBES - 1];
        let mut variance = self.variance[LOBES - 1];
        let mut exit = zero;
        let (mut first, mut share) = (zero, lobes.probability[LOBES - 1]);
        let mut end = one - share;
        first = R::select(end.le(choice), end, first);
        let uniform = end.le(choice);
        for p in (0..LOBES - 1).rev() {
            let within = choice.lt(end);
            end = if p == 0 { zero } else { end - lobes.probability[p] };
            chosen = [
                R::select(within, lobes.inclination[p][0], chosen[0]),
                R::select(within, lobes.inclination[p][1], chosen[1]),
            ];
            variance = R::select(within, self.variance[p], variance);
            exit = R::select(within, lobes.azimuth[p], exit);
            first = R::select(within, end, first);
            share = R::select(within, lobes.probability[p], share);
        }
        let rest = (choice - first) / R::select(zero.lt(share), share, one);
        let rest = rest.max(zero).min(R::splat(1.0 - f32::EPSILON / 2.0));
        let [sin, cos] = sample_longitudinal(chosen, variance, u);
        let peaked = exit + sample_trimmed_logistic(rest, self.spread);
        let azimuth = R::select(uniform, R::constant(2.0 * PI) * rest, peaked);
        let (value, pdf) = self.sum(&lobes, [sin, cos], azimuth);
        // The direction across the fibre of `wo`, turned by the azimuth.
        let length = (wo[1].square() + wo[2].square()).sqrt();
        let across = zero.lt(length);
        let inverse = one / R::select(across, length, one);
        let (y, z) = (R::select(across, wo[1] * inverse, one), wo[2] * inverse);
        let turns = azimuth * R::constant(0.5 / PI);
        let [s, c] = sin_cos_turns(turns - turns.floor());
        let some = zero.lt(pdf) & pdf.lt(R::splat(f32::INFINITY));
        let over = one / R::select(some, pdf, one);
        BsdfSample {
            wi: [sin, cos * (y * c - z * s), cos * (z * c + y * s)],
            weight: [value[0] * over, value[1] * over, value[2] * over],
            pdf,
            singular: zero.lt(zero),
            valid: some,
            eta2: one,
        }
        .only(some)
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        R::splat(0.0).lt(R::splat(0.0))
    }
}
