//! Random numbers of walks whose length is not known beforehand.

use super::hash;
use crate::lanes::{Real, Word};

/// Random numbers in [0, 1), one sequence per lane, each a pure function of its seed and keys.
///
/// Numbers are drawn by index. A lane's numbers therefore do not depend on which other lanes draw,
/// and masked lanes need no special care.
#[derive(Clone, Copy, Debug)]
pub struct RandomStream<R: Real>(R::Word);

/// 2^32 over the golden ratio, odd: the distance of the hashed counters of a sequence.
const NUMBER_STEP: u32 = 0x9e37_79b9;
/// The fractional bits of the square root of 3, odd: separates the seeds of substreams.
const STREAM_STEP: u32 = 0xbb67_ae85;

impl<R: Real> RandomStream<R> {
    /// The sequence of a seed and any number of keys.
    #[inline(always)]
    pub fn new<const N: usize>(seed: R::Word, keys: [R; N]) -> Self {
        let mut state = hash(seed.wrapping_add(R::Word::splat(NUMBER_STEP)));
        for key in keys {
            state = hash(state.wrapping_add(R::Word::splat(NUMBER_STEP)) ^ key.to_word());
        }
        Self(state)
    }

    /// The sequence whose state is known.
    #[inline(always)]
    pub fn resumed(state: R::Word) -> Self {
        Self(state)
    }

    /// Returns the state of the sequence.
    #[inline(always)]
    pub fn state(&self) -> R::Word {
        self.0
    }

    /// Returns the sequence of one part of a walk, counted from 0.
    #[inline(always)]
    pub fn substream(&self, index: u32) -> Self {
        Self(hash(self.0 ^ R::Word::splat(index.wrapping_add(1).wrapping_mul(STREAM_STEP))))
    }

    /// Returns the number of an index, of 24 random bits.
    #[inline(always)]
    pub fn number(&self, index: u32) -> R {
        let counter = R::Word::splat(index.wrapping_add(1).wrapping_mul(NUMBER_STEP));
        let bits = hash(self.0.wrapping_add(counter)).shift_down(8);
        R::from_integer(bits) * R::constant(1.0 / 16_777_216.0)
    }

    /// Returns the numbers of an index and of the next one.
    #[inline(always)]
    pub fn pair(&self, index: u32) -> [R; 2] {
        [self.number(index), self.number(index + 1)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lanes::f32x8;

    #[test]
    fn lanes_have_the_numbers_of_single_streams() {
        let seeds = [0, 1, 2, 77, 0x8000_0000, u32::MAX, 5, 6];
        let keys = [0.0, -0.0, 1.0, 0.3, -0.3, 1e-20, f32::MAX, 0.5];
        let eight = RandomStream::new(Word::load(&seeds), [f32x8::new(keys), f32x8::splat(0.25)]);
        for part in [0, 1, 1000] {
            for index in [0, 1, 4] {
                let packet = eight.substream(part).number(index).to_array();
                for lane in 0..8 {
                    let one = RandomStream::<f32>::new(seeds[lane], [keys[lane], 0.25]);
                    assert_eq!(one.substream(part).number(index), packet[lane]);
                }
            }
        }
    }

    #[test]
    fn numbers_are_uniform_and_independent() {
        // The numbers of one event, of the next event, and of the walk of the next seed. The
        // tolerance is five standard errors.
        let n = 1_000_000u32;
        let (mut sums, mut products) = ([0.0f64; 4], [0.0f64; 6]);
        let mut cells = [0.0f64; 256];
        for seed in 0..n {
            let stream = |seed| RandomStream::<f32>::new(seed, [0.6f32, 0.0, 0.8]);
            let event = stream(seed).substream(2);
            let numbers = [
                event.number(0),
                event.number(1),
                stream(seed).substream(3).number(0),
                stream(seed + 1).substream(2).number(0),
            ]
            .map(|u| f64::from(u) - 0.5);
            let mut pair = 0;
            for a in 0..4 {
                sums[a] += numbers[a];
                for b in a + 1..4 {
                    products[pair] += numbers[a] * numbers[b];
                    pair += 1;
                }
            }
            let cell = |x: f64| ((x + 0.5) * 16.0) as usize;
            cells[cell(numbers[0]) * 16 + cell(numbers[1])] += 1.0;
        }
        let n = f64::from(n);
        for sum in sums {
            assert!((sum / n).abs() < 5.0 * (1.0 / 12.0 / n).sqrt(), "{sums:?}");
        }
        for product in products {
            assert!((product / n).abs() < 5.0 / 12.0 / n.sqrt(), "{products:?}");
        }
        // Pearson's statistic of 255 degrees of freedom has the standard deviation 22.6.
        let expected = n / 256.0;
        let statistic: f64 = cells.iter().map(|c| (c - expected).powi(2) / expected).sum();
        assert!((statistic - 255.0).abs() < 5.0 * 22.6, "{statistic}");
    }
}
