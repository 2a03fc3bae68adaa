//! Estimate of a model's error, separate from the noise of its pictures.
//!
//! Two pictures differ by the error of the model and by the noise of both, and the mean squared
//! difference adds them up. Both models therefore render four quarters of their samples: quarter i
//! has the same seed in both, and no other quarter has that seed. So the differences D1 .. D4 of
//! the quarters are independent of each other. In each pixel, a difference is the model's error b
//! plus noise of mean 0:
//!
//! - The mean of Di Dj over the six pairs of different quarters is an unbiased estimate of b^2, as
//!   the noise adds a term of mean 0.
//! - (Di - Dj)(Dk - Dl) / 4 is noise alone, whatever b is. If b is 0, its variance is 3/2 of that
//!   of the estimate. So a test of b = 0 needs no model of the noise, only that the sum over many
//!   blocks of pixels is nearly normal.
//!
//! Equal seeds on both sides do no harm, since the noise of Di and Dj is independent however much
//! the noise within Di is correlated. They help, since most noise cancels within Di. They would
//! make a plain mean of squares too small, so metrics compare with a reference of other seeds.

use petzval_image::Picture;

/// Standard errors from which on an estimate counts as an error. Noise alone exceeds them in fewer
/// than one of a thousand comparisons.
const CERTAIN: f64 = 4.0;

/// Least number of pixel blocks that estimate the noise, if the picture has that many pixels.
const MIN_BLOCKS: f64 = 144.0;

/// Largest side of a block (pixels).
const MAX_SIDE: usize = 16;

/// Error of a model, apart from noise.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bias {
    /// Mean over pixels and channels of the weighted squared error. The estimate is unbiased, so it
    /// is below 0 half the time if there is no error.
    pub square: f64,
    /// Standard error of `square`.
    pub error: f64,
    /// Distance of `square` from 0 in standard errors of noise alone.
    pub deviations: f64,
}

impl Bias {
    /// Returns whether the error is real. Noise alone passes in fewer than one of a thousand
    /// comparisons.
    pub fn certain(&self) -> bool {
        self.deviations >= CERTAIN
    }

    /// Returns the root mean squared error, or 0 if noise explains it.
    pub fn size(&self) -> f64 {
        if self.certain() { self.square.max(0.0).sqrt() } else { 0.0 }
    }

    /// Returns an upper bound of the root mean squared error, two standard errors above the
    /// estimate.
    pub fn at_most(&self) -> f64 {
        (self.square.max(0.0) + 2.0 * self.error).sqrt()
    }
}

/// The six pairs of quarters.
const PAIRS: [[usize; 2]; 6] = [[0, 1], [0, 2], [0, 3], [1, 2], [1, 3], [2, 3]];

/// The three ways to split four quarters into two pairs.
const SPLITS: [[usize; 4]; 3] = [[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2]];

/// Estimates the error of a model against another from four quarters of each, with equal seeds in
/// equal places. `weight` scales the squared errors per pixel and channel; it must not depend on
/// either model's noise.
///
/// # Panics
/// If the sizes differ.
pub fn bias(model: [&Picture; 4], other: [&Picture; 4], weight: &[[f32; 3]]) -> Bias {
    let [width, height] = model[0].size;
    assert!(model.iter().chain(&other).all(|picture| picture.size == [width, height]));
    let side = ((width * height) as f64 / MIN_BLOCKS).sqrt() as usize;
    let side = side.clamp(1, MAX_SIDE);
    let across = width.div_ceil(side);
    let mut blocks = vec![Block::default(); across * height.div_ceil(side)];
    for i in 0..width * height {
        let block = &mut blocks[i / width / side * across + i % width / side];
        for c in 0..3 {
            let difference = |q: usize| f64::from(model[q].pixels[i][c] - other[q].pixels[i][c]);
            block.add([0, 1, 2, 3].map(difference), f64::from(weight[i][c]));
        }
    }
    let count = (3 * width * height).max(1) as f64;
    let square = blocks.iter().map(|block| block.square).sum::<f64>() / count;
    let squares = |of: fn(&Block) -> &[f64]| {
        let sums = blocks.iter().map(of);
        sums.map(|sums| sums.iter().map(|v| v * v).sum::<f64>() / sums.len() as f64).sum::<f64>()
    };
    let [contrast, mixed] = [squares(|block| &block.noise), squares(|block| &block.mixed)];
    // With s the variance of one D: the variance of a contrast is s^2 / 4, that of the mean of six
    // products s^2 / 6 + b^2 s, and that of a mixed term b^2 s + s^2 / 2.
    let noise = (contrast * 2.0 / 3.0).sqrt() / count;
    let error = (mixed - 2.0 * contrast).max(0.0) / count.powi(2) + noise * noise;
    let error = error.sqrt();
    let deviations = if noise > 0.0 { square / noise } else { sign(square) * f64::INFINITY };
    Bias { square, error, deviations: if square == 0.0 { 0.0 } else { deviations } }
}

fn sign(value: f64) -> f64 {
    if value < 0.0 { -1.0 } else { 1.0 }
}

/// Sums over the pixels of a block.
#[derive(Clone, Copy, Default)]
struct Block {
    /// Estimates of the squared error.
    square: f64,
    /// Products that are noise alone.
    noise: [f64; 3],
    /// Products of the error and noise.
    mixed: [f64; 6],
}

impl Block {
    fn add(&mut self, difference: [f64; 4], weight: f64) {
        let pairs: f64 = PAIRS.iter().map(|&[i, j]| difference[i] * difference[j]).sum();
        self.square += weight * pairs / 6.0;
        for (k, [i, j, l, m]) in SPLITS.into_iter().enumerate() {
            let [one, other] = [difference[i] - difference[j], difference[l] - difference[m]];
            self.noise[k] += weight * one * other / 4.0;
            self.mixed[2 * k] += weight * (difference[i] + difference[j]) * other * MIXED;
            self.mixed[2 * k + 1] += weight * (difference[l] + difference[m]) * one * MIXED;
        }
    }
}

/// Scale of the mean of two quarters times a difference of two, normalised to the variance of one.
const MIXED: f64 = std::f64::consts::FRAC_1_SQRT_2 / 2.0;

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_base::sampler::hash;

    const SIZE: [usize; 2] = [40, 30];

    /// A picture with noise as renders have it: mostly a little too dark, sometimes far too bright.
    /// `seed` chooses the noise, `gain` multiplies the light.
    fn quarter(seed: u32, gain: f64) -> Picture {
        let mut state = hash(seed.wrapping_mul(0x9e37_79b9) ^ 0x51ed);
        let mut next = || {
            state = state.wrapping_add(0x6d2b_79f5);
            (f64::from(hash(state) >> 8) + 0.5) / 16_777_216.0
        };
        let pixels = (0..SIZE[0] * SIZE[1]).map(|i| {
            let light = 0.2 + (i % SIZE[0]) as f64 / SIZE[0] as f64;
            [(); 3].map(|()| (gain * light * (1.0 - 0.2 * (1.0 + next().ln()))) as f32)
        });
        Picture { size: SIZE, pixels: pixels.collect() }
    }

    fn compare(seeds: [u32; 2], gain: f64) -> Bias {
        let [one, other] = [(seeds[0], gain), (seeds[1], 1.0)]
            .map(|(seed, gain)| [0, 1, 2, 3].map(|q| quarter(8 * seed + q, gain)));
        let weight = vec![[1.0; 3]; SIZE[0] * SIZE[1]];
        bias(one.each_ref(), other.each_ref(), &weight)
    }

    #[test]
    fn noise_is_not_taken_for_an_error() {
        // Each side has seeds of its own; the models are otherwise the same.
        let runs = 4000;
        let (mut sum, mut squares, mut above) = (0.0, 0.0, [0; 3]);
        for run in 0..runs {
            let found = compare([2 * run, 2 * run + 1], 1.0);
            sum += found.deviations;
            squares += found.deviations.powi(2);
            for (count, bound) in above.iter_mut().zip([2.0, 3.0, CERTAIN]) {
                *count += u32::from(found.deviations > bound);
            }
        }
        let n = f64::from(runs);
        println!("mean {:.4}, variance {:.3}, above 2, 3, 4: {above:?}", sum / n, squares / n);
        // Five standard errors of 4000 numbers of mean 0 and variance 1.
        assert!((sum / n).abs() < 5.0 / n.sqrt(), "{}", sum / n);
        assert!((squares / n - 1.0).abs() < 0.13, "{}", squares / n);
        // A normal number is above 2 in 2.3 % of all cases, above 3 in 0.13 %.
        assert!((50..=150).contains(&above[0]) && above[1] < 30 && above[2] <= 4, "{above:?}");
    }

    #[test]
    fn a_model_one_percent_brighter_is_detected() {
        let mut sum = 0.0;
        let expected = {
            let light = |i: usize| 0.2 + i as f64 / SIZE[0] as f64;
            (0..SIZE[0]).map(|i| (0.01 * light(i)).powi(2)).sum::<f64>() / SIZE[0] as f64
        };
        let mut variance = 0.0;
        for run in 0..200 {
            let found = compare([run; 2], 1.01);
            assert!(found.certain(), "the same seeds, run {run}: {found:?}");
            sum += found.square / 200.0;
            variance += found.error.powi(2) / 200.0;
        }
        println!("{sum:e}, {expected:e}, {:e}", variance.sqrt());
        assert!((sum / expected - 1.0).abs() < 0.01, "{sum:e} of {expected:e}");
        // With different seeds, detection takes a larger error or more samples.
        let mut above = 0;
        let (mut mean, mut squares) = (0.0, 0.0);
        for run in 0..200 {
            let found = compare([2 * run, 2 * run + 1], 1.1);
            above += u32::from(found.certain());
            mean += found.square / 200.0;
            squares += ((found.square - 100.0 * expected) / found.error).powi(2) / 200.0;
        }
        println!("{above} of 200; {mean:e} of {:e}; {squares}", 100.0 * expected);
        assert!(above > 190, "{above}");
        assert!((mean / (100.0 * expected) - 1.0).abs() < 0.03);
        // The standard error matches the scatter of the estimate: five deviations of 200 squares.
        assert!((squares - 1.0).abs() < 0.5, "{squares}");
    }

    #[test]
    fn an_error_in_one_corner_is_detected() {
        let [mut one, other] = [1, 2].map(|seed| [0, 1, 2, 3].map(|q| quarter(8 * seed + q, 1.0)));
        for quarter in &mut one {
            quarter.pixels[..6].iter_mut().for_each(|pixel| *pixel = pixel.map(|v| v + 2.0));
        }
        let weight = vec![[1.0; 3]; SIZE[0] * SIZE[1]];
        assert!(bias(one.each_ref(), other.each_ref(), &weight).certain());
    }

    #[test]
    fn a_picture_does_not_differ_from_itself() {
        let found = compare([3, 3], 1.0);
        assert_eq!(found, Bias::default());
        assert!(!found.certain() && found.at_most() == 0.0);
    }
}
