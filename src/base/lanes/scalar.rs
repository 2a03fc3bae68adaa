//! One lane: `f32` and `f64`.

use super::Real;

macro_rules! one_lane {
    ($float:ty) => {
        impl Real for $float {
            type Scalar = $float;
            type Mask = bool;
            type Word = u32;
            type Double = f64;
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
            fn permute(self, _order: &[u32; 8]) -> Self {
                self
            }
            #[inline(always)]
            fn transpose(rows: &[[$float; 8]]) -> [Self; 8] {
                rows[0]
            }
            #[inline(always)]
            fn from_f64(value: f64) -> $float {
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
            fn floor(self) -> Self {
                <$float>::floor(self)
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
            fn equals(self, other: Self) -> bool {
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
            #[inline(always)]
            fn to_word(self) -> u32 {
                (self as f32).to_bits()
            }
            #[inline(always)]
            fn from_word(bits: u32) -> Self {
                f32::from_bits(bits) as $float
            }
            #[inline(always)]
            fn from_integer(value: u32) -> Self {
                value as $float
            }
        }
    };
}

one_lane!(f32);
one_lane!(f64);
