//! Words of 32 bits, one per lane, for random numbers and for the bits of floating-point numbers.

use std::fmt::Debug;
use std::ops::{BitAnd, BitOr, BitXor};

/// An unsigned integer of 32 bits, or a packet of them. Arithmetic is modulo 2^32.
pub trait Word:
    Copy + Debug + Send + Sync + BitAnd<Output = Self> + BitOr<Output = Self> + BitXor<Output = Self>
{
    /// Returns the same word in every lane.
    fn splat(value: u32) -> Self;
    /// Loads the first words of a slice, as many as there are lanes.
    fn load(from: &[u32]) -> Self;
    /// Stores the words in the first entries of a slice, as many as there are lanes.
    fn store(self, to: &mut [u32]);
    /// Returns the sum.
    fn wrapping_add(self, other: Self) -> Self;
    /// Returns the lower 32 bits of the product.
    fn wrapping_mul(self, other: Self) -> Self;
    /// Moves the bits up by `count` places, 0 to 31, and fills with zeros.
    fn shift_up(self, count: u32) -> Self;
    /// Moves the bits down by `count` places, 0 to 31, and fills with zeros.
    fn shift_down(self, count: u32) -> Self;
}

impl Word for u32 {
    #[inline(always)]
    fn splat(value: u32) -> Self {
        value
    }
    #[inline(always)]
    fn load(from: &[u32]) -> Self {
        from[0]
    }
    #[inline(always)]
    fn store(self, to: &mut [u32]) {
        to[0] = self;
    }
    #[inline(always)]
    fn wrapping_add(self, other: Self) -> Self {
        u32::wrapping_add(self, other)
    }
    #[inline(always)]
    fn wrapping_mul(self, other: Self) -> Self {
        u32::wrapping_mul(self, other)
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

#[cfg(test)]
mod tests {
    use wide::u32x8;

    use super::Word;
    use crate::lanes::{Real, f32x8};

    /// Edge cases of integers, and bits of ordinary and special numbers.
    const WORDS: [u32; 8] =
        [0, 1, 0x00ff_ffff, 0x3f80_0001, 0x7f80_0000, 0x8000_0000, 0x9e37_79b9, u32::MAX];

    #[test]
    fn a_word_of_eight_equals_a_single_word() {
        let eight = u32x8::load(&WORDS);
        let mut stored = [0; 8];
        eight.store(&mut stored);
        assert_eq!(stored, WORDS);
        for b in WORDS {
            let splat = <u32x8 as Word>::splat(b);
            let check = |packet: u32x8, one: fn(u32, u32) -> u32| {
                assert_eq!(packet.to_array(), WORDS.map(|a| one(a, b)), "{b:x}");
            };
            check(Word::wrapping_add(eight, splat), u32::wrapping_add);
            check(Word::wrapping_mul(eight, splat), u32::wrapping_mul);
            check(eight & splat, |a, b| a & b);
            check(eight | splat, |a, b| a | b);
            check(eight ^ splat, |a, b| a ^ b);
        }
        for count in [0, 1, 8, 16, 23, 31] {
            let (up, down) = (eight.shift_up(count), eight.shift_down(count));
            assert_eq!(up.to_array(), WORDS.map(|a| a.shift_up(count)), "{count}");
            assert_eq!(down.to_array(), WORDS.map(|a| a.shift_down(count)), "{count}");
        }
    }

    #[test]
    fn words_convert_to_the_same_numbers_in_one_lane_and_in_eight() {
        let eight = u32x8::load(&WORDS);
        let bits = f32x8::from_word(eight).to_word();
        assert_eq!(bits.to_array(), WORDS);
        assert_eq!(f32x8::from_word(eight).to_array().map(f32::to_bits), WORDS);
        assert_eq!(WORDS.map(|word| <f32 as Real>::from_word(word).to_word()), WORDS);
        let small = eight.shift_down(8);
        let expected = WORDS.map(|word| (word >> 8) as f32);
        assert_eq!(f32x8::from_integer(small).to_array(), expected);
        assert_eq!(WORDS.map(|word| f32::from_integer(word >> 8)), expected);
        assert_eq!(WORDS.map(|word| f64::from_integer(word >> 8) as f32), expected);
        assert_eq!((1.5f64.to_word(), f64::from_word(0x3fc0_0000)), (0x3fc0_0000, 1.5));
    }
}
