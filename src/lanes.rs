//! One set of arithmetic for one lane and for eight.
//!
//! A kernel is written once over [`Real`] and compiled for `f32`, `f64` and `f32x8`.
//! Every operation rounds the same way in a lane of `f32x8` as in a lone `f32`, so the
//! scalar and the SIMD path of the program agree bit for bit. This is the only file
//! that names the `wide` crate.

use std::fmt::Debug;
use std::ops::{Add, BitAnd, BitOr, Div, Mul, Neg, Not, Sub};

use bytemuck::Pod;
pub use wide::f32x8;
use wide::u32x8;

/// A real number, or a packet of them that are computed in step.
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
    /// How many numbers a packet holds.
    const LANES: usize;
    /// Half the distance from 1 to the next number: the largest relative error of rounding.
    const EPSILON: f64;

    /// The same number in every lane.
    fn splat(value: Self::Scalar) -> Self;
    /// The first [`Self::LANES`] numbers of a slice.
    fn load(from: &[Self::Scalar]) -> Self;
    /// Writes the packet to the first [`Self::LANES`] places of a slice.
    fn store(self, to: &mut [Self::Scalar]);
    /// The lanes in another order: lane `order[i]` becomes the i-th, i from 0 to 7.
    fn ordered(self, order: &[u32; 8]) -> Self;
    /// Eight numbers of every lane: a packet of the first ones, a packet of the second ones ...
    fn columns(rows: &[[Self::Scalar; 8]]) -> [Self; 8];
    /// Rounds an f64 to a lane's precision.
    fn scalar(value: f64) -> Self::Scalar;
    /// Widens a lane to f64.
    fn to_f64(value: Self::Scalar) -> f64;
    /// `self * factor + term`, fused exactly when the build has FMA.
    fn mul_add(self, factor: Self, term: Self) -> Self;
    /// The correctly rounded square root; NaN below zero.
    fn sqrt(self) -> Self;
    /// `self < other ? self : other`: the other where either is NaN.
    fn min(self, other: Self) -> Self;
    /// `self > other ? self : other`: the other where either is NaN.
    fn max(self, other: Self) -> Self;
    /// The magnitude.
    fn abs(self) -> Self;
    /// Lane-wise `<`.
    fn lt(self, other: Self) -> Self::Mask;
    /// Lane-wise `<=`.
    fn le(self, other: Self) -> Self::Mask;
    /// Lane-wise `==`.
    fn same(self, other: Self) -> Self::Mask;
    /// `yes` where the mask is set, `no` elsewhere.
    fn select(mask: Self::Mask, yes: Self, no: Self) -> Self;
    /// The mask as bits, lane 0 lowest.
    fn bits(mask: Self::Mask) -> u32;

    /// An f64 constant in every lane.
    #[inline(always)]
    fn constant(value: f64) -> Self {
        Self::splat(Self::scalar(value))
    }

    /// A function of one lane, in every lane of two packets.
    #[inline(always)]
    fn zip(self, other: Self, f: impl Fn(Self::Scalar, Self::Scalar) -> Self::Scalar) -> Self {
        let zero = Self::scalar(0.0);
        let (mut a, mut b) = ([zero; 8], [zero; 8]);
        self.store(&mut a);
        other.store(&mut b);
        for lane in 0..Self::LANES {
            a[lane] = f(a[lane], b[lane]);
        }
        Self::load(&a)
    }

    /// `self * self`.
    #[inline(always)]
    fn square(self) -> Self {
        self * self
    }
}

/// An order of lanes, for [`Real::ordered`]: first those of eight whose bits are set, as they come.
#[inline(always)]
pub fn ranks(lanes: u32) -> &'static [u32; 8] {
    &RANKS[lanes as usize % RANKS.len()]
}

/// Of every set of lanes, as bits: those of the set first.
static RANKS: [[u32; 8]; 256] = {
    let mut ranks = [[0; 8]; 256];
    let mut set = 0;
    while set < 256 {
        let (mut lane, mut count) = (0, 0);
        while lane < 8 {
            if set >> lane & 1 == 1 {
                ranks[set][count] = lane;
                count += 1;
            }
            lane += 1;
        }
        set += 1;
    }
    ranks
};

macro_rules! one_lane {
    ($float:ty) => {
        impl Real for $float {
            type Scalar = $float;
            type Mask = bool;
            const LANES: usize = 1;
            const EPSILON: f64 = <$float>::EPSILON as f64 / 2.0;

            #[inline(always)]
            fn splat(value: $float) -> Self {
                value
            }
            #[inline(always)]
            fn load(from: &[$float]) -> Self {
                from[0]
            }
            #[inline(always)]
            fn store(self, to: &mut [$float]) {
                to[0] = self;
            }
            #[inline(always)]
            fn ordered(self, _order: &[u32; 8]) -> Self {
                self
            }
            #[inline(always)]
            fn columns(rows: &[[$float; 8]]) -> [Self; 8] {
                rows[0]
            }
            #[inline(always)]
            fn scalar(value: f64) -> $float {
                value as $float
            }
            #[inline(always)]
            fn to_f64(value: $float) -> f64 {
                f64::from(value)
            }
            #[inline(always)]
            fn mul_add(self, factor: Self, term: Self) -> Self {
                if cfg!(target_feature = "fma") {
                    <$float>::mul_add(self, factor, term)
                } else {
                    self * factor + term
                }
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                <$float>::sqrt(self)
            }
            #[inline(always)]
            fn min(self, other: Self) -> Self {
                if self < other { self } else { other }
            }
            #[inline(always)]
            fn max(self, other: Self) -> Self {
                if self > other { self } else { other }
            }
            #[inline(always)]
            fn abs(self) -> Self {
                <$float>::abs(self)
            }
            #[inline(always)]
            fn lt(self, other: Self) -> bool {
                self < other
            }
            #[inline(always)]
            fn le(self, other: Self) -> bool {
                self <= other
            }
            #[inline(always)]
            fn same(self, other: Self) -> bool {
                self == other
            }
            #[inline(always)]
            fn select(mask: bool, yes: Self, no: Self) -> Self {
                if mask { yes } else { no }
            }
            #[inline(always)]
            fn bits(mask: bool) -> u32 {
                u32::from(mask)
            }
        }
    };
}

one_lane!(f32);
one_lane!(f64);

impl Real for f32x8 {
    type Scalar = f32;
    type Mask = f32x8;
    const LANES: usize = 8;
    const EPSILON: f64 = f32::EPSILON as f64 / 2.0;

    #[inline(always)]
    fn splat(value: f32) -> Self {
        f32x8::splat(value)
    }
    #[inline(always)]
    fn load(from: &[f32]) -> Self {
        let mut lanes = [0.0; 8];
        lanes.copy_from_slice(&from[..8]);
        f32x8::new(lanes)
    }
    #[inline(always)]
    fn store(self, to: &mut [f32]) {
        to[..8].copy_from_slice(&self.to_array());
    }
    #[inline(always)]
    fn ordered(self, order: &[u32; 8]) -> Self {
        bytemuck::cast(bytemuck::cast::<Self, u32x8>(self).shuffle(u32x8::new(*order)))
    }
    #[inline(always)]
    fn columns(rows: &[[f32; 8]]) -> [Self; 8] {
        let mut packets = [f32x8::ZERO; 8];
        for (packet, row) in packets.iter_mut().zip(&rows[..8]) {
            *packet = f32x8::new(*row);
        }
        f32x8::transpose(packets)
    }
    #[inline(always)]
    fn scalar(value: f64) -> f32 {
        value as f32
    }
    #[inline(always)]
    fn to_f64(value: f32) -> f64 {
        f64::from(value)
    }
    #[inline(always)]
    fn mul_add(self, factor: Self, term: Self) -> Self {
        if cfg!(target_feature = "fma") {
            f32x8::mul_add(self, factor, term)
        } else {
            self * factor + term
        }
    }
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32x8::sqrt(self)
    }
    #[inline(always)]
    fn min(self, other: Self) -> Self {
        self.fast_min(other)
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        self.fast_max(other)
    }
    #[inline(always)]
    fn abs(self) -> Self {
        f32x8::abs(self)
    }
    #[inline(always)]
    fn lt(self, other: Self) -> Self {
        self.simd_lt(other)
    }
    #[inline(always)]
    fn le(self, other: Self) -> Self {
        self.simd_le(other)
    }
    #[inline(always)]
    fn same(self, other: Self) -> Self {
        self.simd_eq(other)
    }
    #[inline(always)]
    fn select(mask: Self, yes: Self, no: Self) -> Self {
        wide::f32x8::select(mask, yes, no)
    }
    #[inline(always)]
    fn bits(mask: Self) -> u32 {
        mask.to_bitmask()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Numbers that break kernels; every test of lanes uses this list.
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
    fn a_lane_of_eight_rounds_like_a_lone_float() {
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
                    assert_eq!(f32::bits(a.same(b)) * 0xff, f32x8::bits(va.same(vb)));
                }
            }
        }
    }

    #[test]
    fn lanes_of_a_set_come_first() {
        let lanes = [0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0];
        for set in 0..256 {
            let wanted: Vec<f32> =
                lanes.into_iter().filter(|&lane| set >> lane as u32 & 1 == 1).collect();
            let found = f32x8::new(lanes).ordered(ranks(set)).to_array();
            assert_eq!(found[..wanted.len()], wanted, "{set:08b}");
        }
    }
}
