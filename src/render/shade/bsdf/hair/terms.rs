//! Longitudinal and azimuthal distributions of a hair's lobes.

use std::f64::consts::PI;

use petzval_base::lanes::Real;
use petzval_base::lanes::math::{bessel_i0_scaled, exp_negative, ln, sin_cos_turns};

/// Returns the density M of an inclination about the mirrored one of a lobe (d'Eon et al. 2011, "An
/// energy-conserving hair reflectance model", equation 7). It is per solid angle along the fibre:
/// its integral with the cosine of the inclination is 1.
///
/// I0 is scaled by its exponential growth, so that the formula holds for every variance.
#[inline(always)]
pub(super) fn longitudinal<R: Real<Scalar = f32>>(
    [sin_i, cos_i]: [R; 2],
    [sin_o, cos_o]: [R; 2],
    variance: R,
) -> R {
    let (one, two) = (R::splat(1.0), R::splat(2.0));
    let inverse = one / variance;
    // cos_i cos_o - sin_i sin_o - 1 without cancellation.
    let chord = (cos_i - cos_o).square() + (sin_i + sin_o).square();
    let peak = exp_negative(-(chord * inverse) / two);
    let area = one - exp_negative(-(two * inverse));
    peak * bessel_i0_scaled(cos_i * cos_o * inverse) * inverse / area
}

/// Samples the sine and cosine of an inclination with the density of [`longitudinal`] (d'Eon 2013,
/// "Importance sampling for physically-based hair fiber models").
#[inline(always)]
pub(super) fn sample_longitudinal<R: Real<Scalar = f32>>(
    [sin_o, cos_o]: [R; 2],
    variance: R,
    u: [R; 2],
) -> [R; 2] {
    let (one, two) = (R::splat(1.0), R::splat(2.0));
    let least = exp_negative(-(two / variance));
    let mixed = u[0] + (one - u[0]) * least;
    let cos = one + variance * ln(mixed.max(R::splat(1e-30)));
    let cos = cos.max(-one).min(one);
    let sin = ((one - cos) * (one + cos)).sqrt();
    let [_, turned] = sin_cos_turns(u[1]);
    let sin_i = (sin * turned * cos_o - cos * sin_o).max(-one).min(one);
    [sin_i, ((one - sin_i) * (one + sin_i)).sqrt()]
}

/// Returns an angle moved by whole turns to -pi to pi (rad).
#[inline(always)]
pub(super) fn wrap<R: Real<Scalar = f32>>(angle: R) -> R {
    let turns = (angle * R::constant(0.5 / PI) + R::splat(0.5)).floor();
    // 2 pi in two parts, the first of 8 bits, so that its products are exact.
    let rest = turns.mul_add(R::splat(-6.281_25), angle);
    turns.mul_add(R::constant(6.281_25 - 2.0 * PI), rest)
}

/// Returns the density of the logistic distribution of a scale, trimmed to -pi to pi.
#[inline(always)]
pub(super) fn trimmed_logistic<R: Real<Scalar = f32>>(x: R, scale: R) -> R {
    let one = R::splat(1.0);
    let power = exp_negative(-(x.abs() / scale));
    let tail = exp_negative(-(R::constant(PI) / scale));
    power * (one + tail) / (scale * (one + power).square() * (one - tail))
}

/// Samples the density of [`trimmed_logistic`].
#[inline(always)]
pub(super) fn sample_trimmed_logistic<R: Real<Scalar = f32>>(u: R, scale: R) -> R {
    let (one, pi) = (R::splat(1.0), R::constant(PI));
    let tail = exp_negative(-(pi / scale));
    let least = tail / (one + tail);
    // The distribution function at the sample; away from 0 and 1, where the logarithm is infinite.
    let y = u.mul_add(one - (least + least), least);
    let y = y.max(R::splat(1e-8)).min(R::splat(1.0 - f32::EPSILON / 2.0));
    let x = scale * ln(y / (one - y));
    x.max(-pi).min(pi)
}
