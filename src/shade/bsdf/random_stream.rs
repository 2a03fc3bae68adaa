//! Random numbers of walks whose length is not known beforehand.

/// A sequence of random numbers in [0, 1) that depends on its seed and keys alone
/// (Steele, Lea & Flood 2014, "Fast splittable pseudorandom number generators").
#[derive(Clone, Debug)]
pub struct RandomStream(u64);

/// 2^64 over the golden ratio.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

impl RandomStream {
    /// The sequence of a seed and any number of keys.
    pub fn new(seed: u32, keys: impl IntoIterator<Item = f32>) -> Self {
        let start = mix(u64::from(seed).wrapping_add(STEP));
        Self(
            keys.into_iter()
                .fold(start, |state, key| mix(state.wrapping_add(STEP) ^ u64::from(key.to_bits()))),
        )
    }

    /// Returns the next number.
    pub fn next_number(&mut self) -> f32 {
        self.0 = self.0.wrapping_add(STEP);
        (mix(self.0) >> 40) as f32 * (1.0 / 16_777_216.0)
    }

    /// Returns the next two numbers.
    pub fn next_pair(&mut self) -> [f32; 2] {
        [self.next_number(), self.next_number()]
    }
}
