//! Exponential, logarithm, sine and a Bessel function over lanes. One lane and eight return the same bits.

use std::f32::consts::FRAC_1_SQRT_2;
use std::f64::consts::{LN_2, LOG2_E, PI};

use super::{Real, Word};

/// The natural logarithm of 2 in 16 bits, so that its products with exponents are exact.
const LN_2_HIGH: f64 = 0.693_145_751_953_125;

/// Bits of 1 and of the square root of 1/2.
const ONE: u32 = 1.0f32.to_bits();
const ROOT_OF_HALF: u32 = FRAC_1_SQRT_2.to_bits();

/// Returns the number that rounds to an integer if it is added: the sum has no fractional bits.
/// The lower bits of the sum are those of the integer.
#[inline(always)]
fn rounder<R: Real<Scalar = f32>>() -> R {
    R::splat(12_582_912.0)
}

/// Returns a polynomial in `x`; the first coefficient is that of the highest power.
#[inline(always)]
fn polynomial<R: Real<Scalar = f32>, const N: usize>(x: R, coefficients: [f64; N]) -> R {
    let mut sum = R::constant(coefficients[0]);
    for k in 1..N {
        sum = sum.mul_add(x, R::constant(coefficients[k]));
    }
    sum
}

/// Returns e^x for x <= 0, to 2 ulp; 0 if x < -87, where f32 runs out of exponents.
#[inline(always)]
pub fn exp_negative<R: Real<Scalar = f32>>(x: R) -> R {
    let lowest = R::splat(-87.0);
    let inside = x.max(lowest);
    let sum = inside.mul_add(R::constant(LOG2_E), rounder());
    let n = sum - rounder();
    let rest = n.mul_add(R::constant(-LN_2_HIGH), inside);
    let rest = n.mul_add(R::constant(LN_2_HIGH - LN_2), rest);
    // Taylor's series for |rest| <= ln(2) / 2: the next term is 5e-9.
    let power = polynomial(
        rest,
        [1.0 / 5040.0, 1.0 / 720.0, 1.0 / 120.0, 1.0 / 24.0, 1.0 / 6.0, 0.5, 1.0, 1.0],
    );
    // The exponent of 2^n: the bits of the rounder are shifted out.
    let exponent = sum.to_word().wrapping_add(R::Word::splat(127)).shift_up(23);
    R::select(x.lt(lowest), R::splat(0.0), power * R::from_word(exponent))
}

/// Returns the natural logarithm of a normal number x, 0 < x < infinity, to 2 ulp.
#[inline(always)]
pub fn ln<R: Real<Scalar = f32>>(x: R) -> R {
    let one = R::splat(1.0);
    // x = 2^n m with m between the square roots of 1/2 and of 2.
    let shifted = x.to_word().wrapping_add(R::Word::splat(ONE.wrapping_sub(ROOT_OF_HALF)));
    let n = R::from_integer(shifted.shift_down(23)) - R::splat(127.0);
    let mantissa = shifted & R::Word::splat(0x007f_ffff);
    let m = R::from_word(mantissa.wrapping_add(R::Word::splat(ROOT_OF_HALF)));
    // ln m = 2 artanh s. The next term of the series is 2e-9 of the sum.
    let s = (m - one) / (m + one);
    let series = polynomial(s * s, [2.0 / 9.0, 2.0 / 7.0, 2.0 / 5.0, 2.0 / 3.0]);
    let tail = s * (s * s) * series;
    let tail = n.mul_add(R::constant(LN_2 - LN_2_HIGH), tail);
    n.mul_add(R::constant(LN_2_HIGH), (s + s) + tail)
}

/// Returns the arctangent of x for 0 <= x <= 1, to 1.5e-7 (Abramowitz & Stegun 1964, 4.4.49).
#[inline(always)]
pub fn arctangent<R: Real<Scalar = f32>>(x: R) -> R {
    const COEFFICIENTS: [f64; 9] = [
        0.002_866_225_7,
        -0.016_165_736_7,
        0.042_909_613_8,
        -0.075_289_640_0,
        0.106_562_639_3,
        -0.142_088_994_4,
        0.199_935_508_5,
        -0.333_331_452_8,
        1.0,
    ];
    x * polynomial(x * x, COEFFICIENTS)
}

/// Returns e^-x I0(x) for x >= 0, where I0 is the modified Bessel function of the first kind of order
/// 0. The relative error is below 1e-6 (Abramowitz & Stegun 1964, 9.8.1 and 9.8.2).
#[inline(always)]
pub fn bessel_i0_scaled<R: Real<Scalar = f32>>(x: R) -> R {
    let limit = R::splat(3.75);
    let small = x.lt(limit);
    let t = x / limit;
    let near = polynomial(
        t * t,
        [0.004_581_3, 0.036_076_8, 0.265_973_2, 1.206_749_2, 3.089_942_4, 3.515_622_9, 1.0],
    );
    let far_x = R::select(small, limit, x);
    let far = polynomial(
        limit / far_x,
        [
            0.003_923_77,
            -0.016_476_33,
            0.026_355_37,
            -0.020_577_06,
            0.009_162_81,
            -0.001_575_65,
            0.002_253_19,
            0.013_285_92,
            0.398_942_28,
        ],
    );
    R::select(small, near * exp_negative(-x), far / far_x.sqrt())
}

/// Returns the sine and cosine of `turns` whole turns, 0 to 1, with errors below 1e-7.
#[inline(always)]
pub fn sin_cos_turns<R: Real<Scalar = f32>>(turns: R) -> [R; 2] {
    let (one, two) = (R::splat(1.0), R::splat(2.0));
    let quarters = turns * R::splat(4.0);
    let quadrant = (quarters + rounder()) - rounder();
    // The angle to the nearest axis, at most pi / 4.
    let angle = (quarters - quadrant) * R::constant(PI / 2.0);
    let square = angle * angle;
    let tail = polynomial(square, [1.0 / 362_880.0, -1.0 / 5040.0, 1.0 / 120.0, -1.0 / 6.0]);
    let sin = (angle * square).mul_add(tail, angle);
    let tail = polynomial(square, [1.0 / 40_320.0, -1.0 / 720.0, 1.0 / 24.0, -0.5]);
    let cos = square.mul_add(tail, one);
    let (first, third) = (quadrant.equals(one), quadrant.equals(R::splat(3.0)));
    let second = quadrant.equals(two);
    let odd = first | third;
    let (y, x) = (R::select(odd, cos, sin), R::select(odd, sin, cos));
    [R::select(second | third, -y, y), R::select(first | second, -x, x)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::f32x8;

    /// Returns the error of a result [ulp of the exact value].
    fn ulps(found: f32, exact: f64) -> f64 {
        let ulp = (exact as f32).abs().max(f32::MIN_POSITIVE);
        let ulp = f64::from(f32::from_bits(ulp.to_bits() + 1)) - f64::from(ulp);
        (f64::from(found) - exact).abs() / ulp
    }

    /// Returns a function's result, which is the same in one lane and in eight.
    fn both(one: f32, eight: f32x8, x: f32) -> f32 {
        assert_eq!(eight.to_array().map(f32::to_bits), [one.to_bits(); 8], "{x:e}");
        one
    }

    #[test]
    fn arctangents_are_accurate() {
        for i in 0..=10_000 {
            let x = i as f32 / 10_000.0;
            let found = f64::from(arctangent::<f32>(x));
            assert!((found - f64::from(x).atan()).abs() < 1.5e-7, "{x}: {found}");
        }
    }

    #[test]
    fn exponentials_are_accurate() {
        let numbers = (0..870_000).map(|step| -step as f32 * 1e-4);
        let tiny = (0..40).map(|power| -(0.5f32.powi(power)));
        for x in numbers.chain(tiny).chain([-0.0]) {
            let found = both(exp_negative(x), exp_negative(f32x8::splat(x)), x);
            assert!(ulps(found, f64::from(x).exp()) <= 2.0, "{x}: {found}");
        }
        assert_eq!(exp_negative(0.0f32), 1.0);
        for x in [-87.1, -88.0, -1e10, f32::MIN, f32::NEG_INFINITY] {
            assert_eq!(both(exp_negative(x), exp_negative(f32x8::splat(x)), x), 0.0);
        }
    }

    #[test]
    fn logarithms_are_accurate() {
        let numbers = (1..=1 << 20).map(|k| k as f32 / (1 << 20) as f32);
        let tiny = (1..=2000).map(|k| k as f32 / 16_777_216.0);
        let near_one = (0..2000).map(|k| 1.0 - k as f32 / 16_777_216.0);
        let root = std::f32::consts::SQRT_2;
        let extreme = [f32::MIN_POSITIVE, 1e-30, root, root.next_up(), 2.0, 3.7, 1e30, f32::MAX];
        for x in numbers.chain(tiny).chain(near_one).chain(extreme) {
            let found = both(ln(x), ln(f32x8::splat(x)), x);
            assert!(ulps(found, f64::from(x).ln()) <= 2.0, "{x}: {found}");
        }
        assert_eq!(ln(1.0f32), 0.0);
    }

    #[test]
    fn sines_and_cosines_are_accurate() {
        for turns in (0..=1 << 20).map(|k| k as f32 / (1 << 20) as f32) {
            let eight = sin_cos_turns(f32x8::splat(turns));
            let [sin, cos] = sin_cos_turns(turns);
            let (sin, cos) = (both(sin, eight[0], turns), both(cos, eight[1], turns));
            let (exact_sin, exact_cos) = (2.0 * PI * f64::from(turns)).sin_cos();
            assert!((f64::from(sin) - exact_sin).abs() < 1e-7, "{turns}: {sin}, not {exact_sin}");
            assert!((f64::from(cos) - exact_cos).abs() < 1e-7, "{turns}: {cos}, not {exact_cos}");
        }
    }

    #[test]
    fn bessel_functions_are_accurate() {
        // The integral of Bessel, whose sum over equal steps converges faster than any power.
        let exact = |x: f64| {
            let steps = 3000;
            let cos = |k: i32| (PI * (f64::from(k) + 0.5) / f64::from(steps)).cos();
            (0..steps).map(|k| (x * (cos(k) - 1.0)).exp()).sum::<f64>() / f64::from(steps)
        };
        let numbers = (0..=400).map(|step| step as f32 * 0.05);
        for x in numbers.chain([3.749_999, 3.75, 3.750_001, 100.0, 1e3, 1e5]) {
            let found = both(bessel_i0_scaled(x), bessel_i0_scaled(f32x8::splat(x)), x);
            let exact = exact(f64::from(x));
            assert!((f64::from(found) / exact - 1.0).abs() < 1e-6, "{x}: {found}, not {exact}");
        }
        assert_eq!(bessel_i0_scaled(0.0f32), 1.0);
    }
}
