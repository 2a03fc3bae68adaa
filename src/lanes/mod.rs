//! Numeric types of the kernels: one lane or eight, in one arithmetic.
//!
//! A kernel is written once over [`Real`] and compiled for `f32`, `f64` and `f32x8`.
//! Every operation rounds the same way in a lane of `f32x8` as in a single `f32`, so the
//! scalar and the SIMD path of the program agree bit for bit.

mod packet;
mod scalar;
pub mod vector;

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use bytemuck::Pod;
pub use wide::f32x8;

/// A real number, or a packet of numbers that are computed in step.
pub trait Real:
    Pod
    + Debug
    + Send
    + Sync
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
    /// The type of one lane.
    type Scalar: Pod + Debug + PartialOrd + Send + Sync;
    /// One truth value per lane.
    type Mask: Copy
        + Debug
        + BitAnd<Output = Self::Mask>
        + BitOr<Output = Self::Mask>
        + Not<Output = Self::Mask>;
    /// Number of lanes of a packet.
    const LANES: usize;
    /// Half the distance from 1 to the next number: the largest relative rounding error.
    const EPSILON: f64;

    /// Returns the same number in every lane.
    fn splat(value: Self::Scalar) -> Self;
    /// Loads the first [`Self::LANES`] numbers of a slice.
    fn load(from: &[Self::Scalar]) -> Self;
    /// Stores the packet in the first [`Self::LANES`] entries of a slice.
    fn store(self, to: &mut [Self::Scalar]);
    /// Returns the lanes in another order: lane `order[i]` becomes lane i, for i from 0 to 7.
    fn permute(self, order: &[u32; 8]) -> Self;
    /// Transposes one row of eight numbers per lane: packet k holds number k of every lane.
    fn transpose(rows: &[[Self::Scalar; 8]]) -> [Self; 8];
    /// Rounds an f64 to a lane's precision.
    fn from_f64(value: f64) -> Self::Scalar;
    /// Widens a lane to f64.
    fn to_f64(value: Self::Scalar) -> f64;
    /// Returns `self * factor + term`, fused if and only if the build has FMA.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// Returns the correctly rounded square root; NaN below zero.
    fn sqrt(self) -> Self;
    /// Returns `self < other ? self : other`: the other where either is NaN.
    fn min(self, other: Self) -> Self;
    /// Returns `self > other ? self : other`: the other where either is NaN.
    fn max(self, other: Self) -> Self;
    /// Returns the absolute value.
    fn abs(self) -> Self;
    /// Compares lane by lane: `<`.
    fn lt(self, other: Self) -> Self::Mask;
    /// Compares lane by lane: `<=`.
    fn le(self, other: Self) -> Self::Mask;
    /// Compares lane by lane: `==`. `x.equals(x)` is false where x is NaN.
    fn equals(self, other: Self) -> Self::Mask;
    /// Returns `yes` where the mask is set, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// Returns the mask as bits, lane 0 lowest.
    fn bits(mask: Self::Mask) -> u32;

    /// Returns an f64 constant in every lane.
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self::splat(Self::from_f64(value))
    }

    /// Applies a function of two single numbers to every lane.
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(Self::Scalar, Self::Scalar) -> Self::Scalar) -> Self {
        let zero = Self::from_f64(0.0);
        let (mut a, mut b) = ([zero; 8], [zero; 8]);
        self.store(&mut a);
        other.store(&mut b);
        for lane in 0..Self::LANES {
            a[lane] = f(a[lane], b[lane]);
        }
        Self::load(&a)
    }

    /// Returns `self * self`.
    #[inline(always)]
    fn square(self) -> Self {
        self * self
    }
}

/// Returns the order for [`Real::permute`] that moves the lanes of a set, given as bits, to the
/// front and keeps their sequence.
#[inline(always)]
pub fn pack_order(lanes: u32) -> &'static [u32; 8] {
    &PACK_ORDERS[lanes as usize % PACK_ORDERS.len()]
}

/// The order of [`pack_order`] for each of the 256 sets of lanes.
static PACK_ORDERS: [[u32; 8]; 256] = {
    let mut orders = [[0; 8]; 256];
    let mut set = 0;
    while set < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 {
            if set >> lane & 1 == 1 {
                orders[set][count] = lane;
                count += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    orders
};

#[cfg(test)]
mod tests {
    use super::*;

    /// Edge cases of floating-point arithmetic.
    const NASTY: [f32; 24] = [
        0.0,
        -0.0,
        1.0,
        -1.0,
        f32::MIN_POSITIVE,
        -f32::MIN_POSITIVE,
        1e-45,
        -1e-45,
        f32::MAX,
        f32::MIN,
        f32::INFINITY,
        f32::NEG_INFINITY,
        f32::NAN,
        f32::EPSILON,
        1.0 + f32::EPSILON,
        1.0 - f32::EPSILON / 2.0,
        0.1,
        1.0 / 3.0,
        -2.5,
        16_777_216.0,
        16_777_217.0,
        1e-20,
        -1e20,
        std::f32::consts::PI,
    ];

    fn same_bits(name: &str, one: f32, lane: f32, inputs: [f32; 3]) {
        let equal = one.to_bits() == lane.to_bits() || (one.is_nan() && lane.is_nan());
        assert!(equal, "{name}{inputs:?}: one lane {one:e}, in a packet {lane:e}");
    }

    #[test]
    fn a_lane_of_eight_rounds_like_a_single_float() {
        for a in NASTY {
            for b in NASTY {
                for c in NASTY {
                    let (va, vb, vc) = (f32x8::splat(a), f32x8::splat(b), f32x8::splat(c));
                    let check = |name: &str, one: f32, packet: f32x8| {
                        for lane in packet.to_array() {
                            same_bits(name, one, lane, [a, b, c]);
                        }
                    };
                    check("add", a + b, va + vb);
                    check("sub", a - b, va - vb);
                    check("mul", a * b, va * vb);
                    check("div", a / b, va / vb);
                    check("neg", -a, -va);
                    check("sqrt", Real::sqrt(a), Real::sqrt(va));
                    check("abs", Real::abs(a), Real::abs(va));
                    check("min", Real::min(a, b), Real::min(va, vb));
                    check("max", Real::max(a, b), Real::max(va, vb));
                    check("mul_add", Real::mul_add(a, b, c), Real::mul_add(va, vb, vc));
                    let pick = f32::select(a.lt(b), b, c);
                    check("select", pick, f32x8::select(va.lt(vb), vb, vc));
                    assert_eq!(f32::bits(a.le(b)) * 0xff, f32x8::bits(va.le(vb)));
                    assert_eq!(f32::bits(a.equals(b)) * 0xff, f32x8::bits(va.equals(vb)));
                }
            }
        }
    }

    #[test]
    fn packing_moves_the_lanes_of_a_set_to_the_front() {
        let lanes = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        for set in 0..256 {
            let expected: Vec<f32> =
                lanes.into_iter().filter(|&lane| set >> lane as u32 & 1 == 1).collect();
            let found = f32x8::new(lanes).permute(pack_order(set)).to_array();
            assert_eq!(found[..expected.len()], expected, "{set:08b}");
        }
    }
}
