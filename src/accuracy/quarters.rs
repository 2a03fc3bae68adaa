//! Pictures in independent parts.

use crate::image::Picture;
use crate::sampler::hash;

/// The parts of a picture's samples that have seeds of their own.
pub(super) const QUARTERS: u32 = 4;

/// The seed of one part of a picture's samples; those of the reference follow those of the rungs.
pub(super) fn seed(of: u32, part: u32) -> u32 {
    hash(hash(of) ^ (part + 1).wrapping_mul(0x9e37_79b9))
}

/// A picture in `N` parts of as many samples each.
#[derive(Clone, Debug)]
pub(super) struct Parts<const N: usize> {
    /// The mean of each.
    pub means: [Picture; N],
    /// Samples of each.
    pub count: u32,
}

impl<const N: usize> Parts<N> {
    /// Nothing yet, of this size.
    pub fn new(size: [u32; 2]) -> Self {
        let size = size.map(|n| n as usize);
        let black = Picture { size, pixels: vec![[0.0; 3]; size[0] * size[1]] };
        Self { means: [(); N].map(|()| black.clone()), count: 0 }
    }

    /// Takes in more samples, of every part as many.
    pub fn add(&mut self, more: [Picture; N], count: u32) {
        let share = count as f32 / (self.count + count) as f32;
        for (mean, more) in self.means.iter_mut().zip(more) {
            for (mean, more) in mean.pixels.iter_mut().zip(more.pixels) {
                *mean = [0, 1, 2].map(|c| mean[c] + share * (more[c] - mean[c]));
            }
        }
        self.count += count;
    }

    /// Samples of a pixel in all.
    pub fn samples(&self) -> u32 {
        N as u32 * self.count
    }

    /// The picture of all parts.
    pub fn picture(&self) -> Picture {
        let mut sum = self.means[0].clone();
        for (i, pixel) in sum.pixels.iter_mut().enumerate() {
            *pixel = [0, 1, 2].map(|c| {
                let all: f32 = self.means.iter().map(|mean| mean.pixels[i][c]).sum();
                all / N as f32
            });
        }
        sum
    }

    /// The variance of that picture, by weight, pixels and channels taken together: an estimate
    /// without bias.
    pub fn noise(&self, weight: &[[f32; 3]]) -> f64 {
        let mut sum = 0.0;
        for (i, weight) in weight.iter().enumerate() {
            for c in 0..3 {
                let values = self.means.each_ref().map(|mean| f64::from(mean.pixels[i][c]));
                let mean = values.iter().sum::<f64>() / N as f64;
                let spread: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
                sum += f64::from(weight[c]) * spread;
            }
        }
        sum / (N * (N - 1)) as f64 / (3 * weight.len()).max(1) as f64
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn grey(values: [f32; 2]) -> Picture {
        Picture { size: [2, 1], pixels: values.map(|v| [v; 3]).to_vec() }
    }

    #[test]
    fn more_samples_count_by_their_number() {
        let mut parts = Parts::<2>::new([2, 1]);
        parts.add([grey([1.0, 4.0]), grey([3.0, 4.0])], 1);
        parts.add([grey([5.0, 8.0]), grey([3.0, 0.0])], 3);
        assert_eq!(parts.picture(), grey([3.5, 4.0]));
        assert_eq!(parts.samples(), 8);
    }

    #[test]
    fn the_noise_is_the_variance_of_the_mean() {
        let mut parts = Parts::<2>::new([2, 1]);
        parts.add([grey([1.0, 4.0]), grey([3.0, 4.0])], 1);
        // A difference of 2 is a variance of 1 of the mean of two; half of the pixels have it.
        assert!((parts.noise(&[[1.0; 3]; 2]) - 0.5).abs() < 1e-12);
        assert!((parts.noise(&[[0.5; 3], [9.0; 3]]) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn no_two_parts_share_a_seed() {
        let mut seeds: Vec<u32> =
            (0..20).flat_map(|of| (0..6).map(move |part| seed(of, part))).collect();
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), 120);
    }
}
