//! The random numbers of a walk whose length nobody knows beforehand.

/// A sequence of numbers in [0, 1) that depends on its keys alone
/// (Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators").
#[derive(Clone, Debug)]
pub struct Stream(u64);

/// The golden ratio in 64 bits.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl Stream {
    /// The sequence of a seed and any numbers.
    pub fn new(seed: u32, keys: impl IntoIterator<Item = f32>) -> Self {
        let start = mix(u64::from(seed).wrapping_add(STEP));
        Self(
            keys.into_iter()
                .fold(start, |state, key| mix(state.wrapping_add(STEP) ^ u64::from(key.to_bits()))),
        )
    }

    /// The next number.
    pub fn number(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(STEP);
        (mix(self.0) >> 40) as f32 * (1.0 / 16_777_216.0)
    }

    /// The next two.
    pub fn pair(&mut self) -> [f32; 2] {
        [self.number(), self.number()]
    }
}
