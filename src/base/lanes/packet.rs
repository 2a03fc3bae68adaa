//! Eight lanes of `f32` or `f64`. This is the only file that uses operations of the `wide` crate.

use wide::{f32x8, f64x8, i32x8, u32x8};

use super::{Real, Word};

macro_rules! eight_lanes {
    ($packet:ident, $float:ident, $shuffle:path) => {
        impl Real for $packet {
            type Scalar = $float;
            type Mask = $packet;
            type Word = u32x8;
            type Double = f64x8;
            const LANES: usize = 8;
            const EPSILON: f64 = $float::EPSILON as f64 / 2.0;

            #[inline(always)]
            fn splat(value: $float) -> Self {
                $packet::splat(value)
            }
            #[inline(always)]
            fn load(from: &[$float]) -> Self {
                let mut lanes = [0.0; 8];
                lanes.copy_from_slice(&from[..8]);
                $packet::new(lanes)
            }
            #[inline(always)]
            fn store(self, to: &mut [$float]) {
                to[..8].copy_from_slice(&self.to_array());
            }
            #[inline(always)]
            fn permute(self, order: &[u32; 8]) -> Self {
                $shuffle(self, order)
            }
            #[inline(always)]
            fn transpose(rows: &[[$float; 8]]) -> [Self; 8] {
                let mut packets = [$packet::ZERO; 8];
                for (packet, row) in packets.iter_mut().zip(&rows[..8]) {
                    *packet = $packet::new(*row);
                }
                $packet::transpose(packets)
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
                    $packet::mul_add(self, factor, term)
                } else {
                    self * factor + term
                }
            }
            #[inline(always)]
            fn sqrt(self) -> Self {
                $packet::sqrt(self)
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
                $packet::abs(self)
            }
            #[inline(always)]
            fn floor(self) -> Self {
                $packet::floor(self)
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
            fn equals(self, other: Self) -> Self {
                self.simd_eq(other)
            }
            #[inline(always)]
            fn select(mask: Self, yes: Self, no: Self) -> Self {
                $packet::select(mask, yes, no)
            }
            #[inline(always)]
            fn bits(mask: Self) -> u32 {
                mask.to_bitmask()
            }
            #[inline(always)]
            fn to_word(self) -> u32x8 {
                <$packet as Bits>::to_word(self)
            }
            #[inline(always)]
            fn from_word(bits: u32x8) -> Self {
                <$packet as Bits>::from_word(bits)
            }
            #[inline(always)]
            fn from_integer(value: u32x8) -> Self {
                <$packet as Bits>::from_integer(value)
            }
        }
    };
}

eight_lanes!(f32x8, f32, shuffle_f32);
eight_lanes!(f64x8, f64, shuffle_f64);

#[inline(always)]
fn shuffle_f32(packet: f32x8, order: &[u32; 8]) -> f32x8 {
    bytemuck::cast(bytemuck::cast::<f32x8, u32x8>(packet).shuffle(u32x8::new(*order)))
}

#[inline(always)]
fn shuffle_f64(packet: f64x8, order: &[u32; 8]) -> f64x8 {
    let (from, mut to) = (packet.to_array(), [0.0; 8]);
    for lane in 0..8 {
        to[lane] = from[order[lane] as usize & 7];
    }
    f64x8::new(to)
}

/// Conversions between packets of floats and of words; see [`Real`].
trait Bits {
    fn to_word(self) -> u32x8;
    fn from_word(bits: u32x8) -> Self;
    fn from_integer(value: u32x8) -> Self;
}

impl Bits for f32x8 {
    #[inline(always)]
    fn to_word(self) -> u32x8 {
        bytemuck::cast(self)
    }
    #[inline(always)]
    fn from_word(bits: u32x8) -> Self {
        bytemuck::cast(bits)
    }
    #[inline(always)]
    fn from_integer(value: u32x8) -> Self {
        bytemuck::cast::<_, i32x8>(value).round_float()
    }
}

impl Bits for f64x8 {
    #[inline(always)]
    fn to_word(self) -> u32x8 {
        u32x8::new(self.to_array().map(|value| (value as f32).to_bits()))
    }
    #[inline(always)]
    fn from_word(bits: u32x8) -> Self {
        f64x8::new(bits.to_array().map(|bits| f64::from(f32::from_bits(bits))))
    }
    #[inline(always)]
    fn from_integer(value: u32x8) -> Self {
        f64x8::new(value.to_array().map(f64::from))
    }
}

impl Word for u32x8 {
    #[inline(always)]
    fn splat(value: u32) -> Self {
        u32x8::splat(value)
    }
    #[inline(always)]
    fn load(from: &[u32]) -> Self {
        let mut lanes = [0; 8];
        lanes.copy_from_slice(&from[..8]);
        u32x8::new(lanes)
    }
    #[inline(always)]
    fn store(self, to: &mut [u32]) {
        to[..8].copy_from_slice(&self.to_array());
    }
    #[inline(always)]
    fn wrapping_add(self, other: Self) -> Self {
        self + other
    }
    #[inline(always)]
    fn wrapping_mul(self, other: Self) -> Self {
        self * other
    }
    #[inline(always)]
    fn shift_up(self, count: u32) -> Self {
        self << count
    }
    #[inline(always)]
    fn shift_down(self, count: u32) -> Self {
        self >> count
    }
}
