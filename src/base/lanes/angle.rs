//! Trigonometric functions, lane by lane.

use super::Real;

/// Returns the polynomial with these coefficients, the constant one first.
#[inline(always)]
fn polynomial<R: Real, const N: usize>(x: R, coefficients: [f64; N]) -> R {
    let mut sum = R::constant(coefficients[N - 1]);
    let mut i = N - 1;
    while i > 0 {
        i -= 1;
        sum = sum.mul_add(x, R::constant(coefficients[i]));
    }
    sum
}

/// Returns the sine and the versine, 1 - cosine, of an angle of 0 to 2 pi (rad), both without
/// cancellation for small angles. The errors are below 3e-7.
#[inline(always)]
pub fn sin_versine<R: Real>(angle: R) -> [R; 2] {
    let (one, two) = (R::constant(1.0), R::constant(2.0));
    let quarter = angle.mul_add(R::constant(std::f64::consts::FRAC_2_PI), R::constant(0.5)).floor();
    // Pi / 2 in two parts, so that the difference is exact to rounding.
    let rest = quarter.mul_add(R::constant(-1.570_796_251_296_997), angle);
    let rest = quarter.mul_add(R::constant(-7.549_789_415_861_596e-8), rest);
    let square = rest * rest;
    let sin =
        rest * polynomial(square, [1.0, -1.0 / 6.0, 1.0 / 120.0, -1.0 / 5040.0, 1.0 / 362_880.0]);
    let versine = square * polynomial(square, [0.5, -1.0 / 24.0, 1.0 / 720.0, -1.0 / 40320.0]);
    let cos = one - versine;
    let is = |number: f64| quarter.equals(R::constant(number));
    let (first, second, third) = (is(1.0), is(2.0), is(3.0));
    [
        R::select(first, cos, R::select(second, -sin, R::select(third, -cos, sin))),
        R::select(
            first,
            one + sin,
            R::select(second, two - versine, R::select(third, one - sin, versine)),
        ),
    ]
}

/// Returns the angle of the point (x, y) from the x axis, 0 to pi (rad). y is at least 0. The
/// relative error is below 4e-7 (Abramowitz & Stegun 1964, 4.4.49).
#[inline(always)]
pub fn angle_above_axis<R: Real>(y: R, x: R) -> R {
    let steep = x.abs().lt(y);
    let (low, high) = (R::select(steep, x.abs(), y), R::select(steep, y, x.abs()));
    let ratio = low / high;
    let series = polynomial(
        ratio * ratio,
        [
            1.0,
            -0.333_331_452_8,
            0.199_935_508_5,
            -0.142_088_994_4,
            0.106_562_639_3,
            -0.075_289_640_0,
            0.042_909_613_8,
            -0.016_165_736_7,
            0.002_866_225_7,
        ],
    );
    let angle = ratio * series;
    let angle = R::select(steep, R::constant(std::f64::consts::FRAC_PI_2) - angle, angle);
    R::select(x.lt(R::constant(0.0)), R::constant(std::f64::consts::PI) - angle, angle)
}

/// Returns the angle of the point (x, y) from the x axis, -pi to pi (rad), and 0 for the origin. The
/// relative error is that of [`angle_above_axis`].
#[inline(always)]
pub fn signed_angle<R: Real>(y: R, x: R) -> R {
    let zero = R::constant(0.0);
    let none = x.equals(zero) & y.equals(zero);
    let angle = angle_above_axis(y.abs(), R::select(none, R::constant(1.0), x));
    R::select(y.lt(zero), -angle, angle)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::f32x8;

    #[test]
    fn sine_and_versine_are_accurate_for_small_and_large_angles() {
        for i in 0..=20_000 {
            let large = i as f32 * (std::f32::consts::TAU / 20_000.0);
            for angle in [large, large * 1e-4, large * 1e-8] {
                let [sin, versine] = sin_versine(angle);
                let exact = f64::from(angle);
                let exact_versine = 2.0 * (exact / 2.0).sin().powi(2);
                let allowed = 3e-7 * exact.min(1.0);
                assert!((f64::from(sin) - exact.sin()).abs() <= allowed, "{angle}");
                let off = (f64::from(versine) - exact_versine).abs();
                let relative = 3e-7 * exact_versine + 3e-7 * exact_versine.sqrt() * exact.min(1.0);
                assert!(off <= relative, "{angle}");
                assert_eq!(
                    sin_versine(f32x8::splat(angle)).map(|v| v.to_array()[3]),
                    [sin, versine]
                );
            }
        }
    }

    #[test]
    fn angles_are_accurate_relative_to_their_size() {
        for i in 0..=10_000 {
            let exact = f64::from(i) * (std::f64::consts::PI / 10_000.0);
            for scale in [1e-10, 1.0, 1e10] {
                let (y, x) = ((exact.sin().abs() * scale) as f32, (exact.cos() * scale) as f32);
                let expected = f64::from(y).atan2(f64::from(x));
                let found = f64::from(angle_above_axis(y, x));
                assert!((found - expected).abs() <= 4e-7 * expected, "{found}, not {expected}");
            }
        }
        assert!((angle_above_axis(1e-6f32, 1.0) - 1e-6).abs() < 1e-12);
    }

    #[test]
    fn signed_angles_are_those_of_all_quadrants() {
        for step in 0..=400 {
            let (sin, cos) = (f64::from(step) * 0.0155 - 3.1).sin_cos();
            let (y, x) = (sin as f32, cos as f32);
            let expected = f64::from(y).atan2(f64::from(x));
            let found = signed_angle(y, x);
            assert!((f64::from(found) - expected).abs() < 2e-6, "{found}, not {expected}");
            let eight = signed_angle(f32x8::splat(y), f32x8::splat(x)).to_array();
            assert_eq!(eight.map(f32::to_bits), [found.to_bits(); 8]);
        }
        assert_eq!(signed_angle(0.0f32, 0.0), 0.0);
    }
}
