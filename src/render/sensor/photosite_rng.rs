//! Random numbers of one photosite.

use petzval_base::sampler::{hash, pixel_key};

/// Separates the noise from the samples of the same pixel and seed.
const SALT: u32 = 0x5e05_0b1e;

/// A sequence of random numbers that depends on pixel, channel and seed alone.
pub(super) struct PhotositeRng {
    key: u32,
    drawn: u32,
}

impl PhotositeRng {
    pub fn new([x, y]: [u32; 2], channel: u32, seed: u32) -> Self {
        Self { key: hash(pixel_key(x, y, hash(seed ^ SALT)) ^ channel), drawn: 0 }
    }

    /// Returns a uniform number: one of the midpoints of 2^32 intervals of (0, 1), so neither 0 nor
    /// 1.
    pub fn uniform(&mut self) -> f64 {
        self.drawn = self.drawn.wrapping_add(0x9e37_79b9);
        (f64::from(hash(self.key ^ hash(self.drawn))) + 0.5) / 4_294_967_296.0
    }

    /// Returns a Gaussian number of mean 0 and variance 1 (Box & Muller 1958).
    pub fn normal(&mut self) -> f64 {
        let radius = (-2.0 * self.uniform().ln()).sqrt();
        radius * (std::f64::consts::TAU * self.uniform()).cos()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn normal_numbers_have_the_moments_of_a_gaussian() {
        let count = 1 << 20;
        let mut moments = [0.0; 4];
        for i in 0..count {
            let x = PhotositeRng::new([i % 777, i / 777], i % 3, 5).normal();
            for (power, moment) in (1..).zip(&mut moments) {
                *moment += x.powi(power) / f64::from(count);
            }
        }
        // The variances of x, x^2, x^3 and x^4 are 1, 2, 15 and 96.
        for ((moment, expected), variance) in
            moments.into_iter().zip([0.0, 1.0, 0.0, 3.0]).zip([1.0, 2.0, 15.0, 96.0f64])
        {
            let error = (variance / f64::from(count)).sqrt();
            assert!((moment - expected).abs() < 5.0 * error, "{moments:?}");
        }
    }

    #[test]
    fn neighbours_channels_and_draws_are_uncorrelated() {
        let count = 1 << 18;
        let mut products = [0.0; 4];
        for i in 0..count {
            let [x, y] = [i % 512, i / 512];
            let mut noise = PhotositeRng::new([x, y], 0, 0);
            let own = noise.uniform() - 0.5;
            let others = [
                noise.uniform(),
                PhotositeRng::new([x + 1, y], 0, 0).uniform(),
                PhotositeRng::new([x, y], 1, 0).uniform(),
                PhotositeRng::new([x, y], 0, 1).uniform(),
            ];
            for (product, other) in products.iter_mut().zip(others) {
                *product += 12.0 * own * (other - 0.5);
            }
        }
        for product in products {
            assert!(product.abs() < 5.0 * f64::from(count).sqrt(), "{products:?}");
        }
    }
}
