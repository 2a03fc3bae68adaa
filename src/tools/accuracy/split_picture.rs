//! Pictures whose samples are split into independent parts, to estimate noise.

use petzval_base::sampler::hash;
use petzval_image::Picture;

/// Number of independent parts of a rung's samples, each with a seed of its own.
pub const QUARTERS: u32 = 4;

/// Returns the seed of one part of a picture's samples. The parts of the reference follow those of
/// the rungs.
pub(super) fn part_seed(job_seed: u32, part: u32) -> u32 {
    hash(hash(job_seed) ^ (part + 1).wrapping_mul(0x9e37_79b9))
}

/// A picture in `N` parts with equal numbers of samples.
#[derive(Clone, Debug)]
pub struct SplitPicture<const N: usize> {
    /// The mean of each part.
    pub means: [Picture; N],
    /// Samples per pixel in each part.
    pub count: u32,
}

impl<const N: usize> SplitPicture<N> {
    /// Creates a black picture without samples.
    pub fn new(size: [u32; 2]) -> Self {
        let size = size.map(|n| n as usize);
        let black = Picture { size, pixels: vec![[0.0; 3]; size[0] * size[1]] };
        Self { means: [(); N].map(|()| black.clone()), count: 0 }
    }

    /// Averages in the means of `count` more samples of every part.
    pub fn add(&mut self, more: [Picture; N], count: u32) {
        let share = count as f32 / (self.count + count) as f32;
        for (mean, more) in self.means.iter_mut().zip(more) {
            for (mean, more) in mean.pixels.iter_mut().zip(more.pixels) {
                *mean = [0, 1, 2].map(|c| mean[c] + share * (more[c] - mean[c]));
            }
        }
        self.count += count;
    }

    /// Returns the samples per pixel of all parts together.
    pub fn samples(&self) -> u32 {
        N as u32 * self.count
    }

    /// Returns the mean of all parts.
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

    /// Returns an unbiased estimate of the variance of that mean: weighted, and averaged over
    /// pixels and channels.
    pub fn noise(&self, weight: &[[f32; 3]]) -> f64 {
        let mut sum = 0.0;
        for (i, weight) in weight.iter().enumerate() {
            for c in 0..3 {
                let values = self.means.each_ref().map(|mean| f64::from(mean.pixels[i][c]));
                let mean = values.iter().sum::<f64>() / N as f64;
                let squares: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
                sum += f64::from(weight[c]) * squares;
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
    fn parts_are_weighted_by_their_samples() {
        let mut picture = SplitPicture::<2>::new([2, 1]);
        picture.add([grey([1.0, 4.0]), grey([3.0, 4.0])], 1);
        picture.add([grey([5.0, 8.0]), grey([3.0, 0.0])], 3);
        assert_eq!(picture.picture(), grey([3.5, 4.0]));
        assert_eq!(picture.samples(), 8);
    }

    #[test]
    fn the_noise_is_the_variance_of_the_mean() {
        let mut picture = SplitPicture::<2>::new([2, 1]);
        picture.add([grey([1.0, 4.0]), grey([3.0, 4.0])], 1);
        // Two values that differ by 2 have a mean of variance 1; half of the pixels do.
        assert!((picture.noise(&[[1.0; 3]; 2]) - 0.5).abs() < 1e-12);
        assert!((picture.noise(&[[0.5; 3], [9.0; 3]]) - 0.25).abs() < 1e-12);
    }

    #[test]
    fn no_two_parts_share_a_seed() {
        let mut seeds: Vec<u32> =
            (0..20).flat_map(|job| (0..6).map(move |part| part_seed(job, part))).collect();
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), 120);
    }
}
