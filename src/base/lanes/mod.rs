//! Numeric types of the kernels: one lane or eight, in one arithmetic.
//!
//! A kernel is written once over [`Real`] and compiled for `f32`, `f64`, `f32x8` and `f64x8`.
//! Every operation rounds the same way in a lane of a packet as in a single number, so the
//! scalar and the SIMD path of the program agree bit for bit.

pub mod angle;
mod gather;
pub mod math;
mod packet;
mod scalar;
pub mod vector;
mod word;

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use bytemuck::Pod;
pub use gather::LaneIndices;
pub use wide::{f32x8, f64x8};
pub use word::Word;

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
    /// 32 bits per lane.
    type Word: Word;
    /// As many lanes, in f64.
    type Double: Real<Scalar = f64>;
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
    /// Returns the largest integer that is not greater.
    fn floor(self) -> Self;
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

    /// Returns the bits of each lane as an f32; f64 is rounded first.
    fn to_word(self) -> Self::Word;
    /// Returns the f32 of these bits in each lane.
    fn from_word(bits: Self::Word) -> Self;
    /// Converts integers below 2^24, which is exact.
    fn from_integer(value: Self::Word) -> Self;

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

    /// Applies a function of single numbers to every lane.
    #[inline(always)]
    fn map(self, f: impl Fn(Self::Scalar) -> Self::Scalar) -> Self {
        let mut lanes = [Self::from_f64(0.0); 8];
        self.store(&mut lanes);
        for lane in 0..Self::LANES {
            lanes[lane] = f(lanes[lane]);
        }
        Self::load(&lanes)
    }

    /// Returns `self * self`.
    #[inline(always)]
    fn square(self) -> Self {
        self * self
    }
}

/// Widens every lane to f64.
#[inline(always)]
pub fn widen<R: Real<Scalar = f32>>(from: R) -> R::Double {
    let (mut single, mut double) = ([0.0f32; 8], [0.0f64; 8]);
    from.store(&mut single);
    for lane in 0..R::LANES {
        double[lane] = f64::from(single[lane]);
    }
    R::Double::load(&double)
}

/// Rounds every lane to f32.
#[inline(always)]
pub fn narrow<R: Real<Scalar = f32>>(from: R::Double) -> R {
    let (mut single, mut double) = ([0.0f32; 8], [0.0f64; 8]);
    from.store(&mut double);
    for lane in 0..R::LANES {
        single[lane] = double[lane] as f32;
    }
    R::load(&single)
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

    /// Compares each operation on single numbers with the same in a packet.
    fn compare<One, Eight>(numbers: &[One])
    where
        One: Real<Scalar = One, Mask = bool>,
        Eight: Real<Scalar = One>,
    {
        let bits = |a: One| Eight::to_f64(a).to_bits();
        for &a in numbers {
            for &b in numbers {
                for &c in numbers {
                    let (va, vb, vc) = (Eight::splat(a), Eight::splat(b), Eight::splat(c));
                    let check = |name: &str, one: One, packet: Eight| {
                        let mut lanes = [a; 8];
                        packet.store(&mut lanes);
                        for lane in lanes {
                            let both_nan = !one.equals(one) && !lane.equals(lane);
                            let equal = both_nan || bits(one) == bits(lane);
                            let inputs = [a, b, c];
                            assert!(equal, "{name}{inputs:?}: one {one:?}, in a packet {lane:?}");
                        }
                    };
                    check("add", a + b, va + vb);
                    check("sub", a - b, va - vb);
                    check("mul", a * b, va * vb);
                    check("div", a / b, va / vb);
                    check("neg", -a, -va);
                    check("sqrt", a.sqrt(), va.sqrt());
                    check("abs", a.abs(), va.abs());
                    check("floor", a.floor(), va.floor());
                    check("min", a.min(b), va.min(vb));
                    check("max", a.max(b), va.max(vb));
                    check("mul_add", a.mul_add(b, c), va.mul_add(vb, vc));
                    let picked = Eight::select(va.lt(vb), vb, vc);
                    check("select", One::select(a.lt(b), b, c), picked);
                    assert_eq!(One::bits(a.le(b)) * 0xff, Eight::bits(va.le(vb)));
                    assert_eq!(One::bits(a.equals(b)) * 0xff, Eight::bits(va.equals(vb)));
                }
            }
        }
    }

    #[test]
    fn a_lane_of_eight_rounds_like_a_single_number() {
        compare::<f32, f32x8>(&NASTY);
        let doubles = [f64::MAX, 5e-324, f64::EPSILON, 1.0 / 3.0, 1.0 - f64::EPSILON / 2.0];
        compare::<f64, f64x8>(&NASTY.map(f64::from).into_iter().chain(doubles).collect::<Vec<_>>());
    }

    #[test]
    fn packing_moves_the_lanes_of_a_set_to_the_front() {
        let lanes = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        for set in 0..256 {
            let expected: Vec<f32> =
                lanes.into_iter().filter(|&lane| set >> lane as u32 & 1 == 1).collect();
            let found = f32x8::new(lanes).permute(pack_order(set)).to_array();
            assert_eq!(found[..expected.len()], expected, "{set:08b}");
            let doubles = f64x8::new(lanes.map(f64::from)).permute(pack_order(set)).to_array();
            assert_eq!(doubles, found.map(f64::from), "{set:08b}");
        }
    }
}
