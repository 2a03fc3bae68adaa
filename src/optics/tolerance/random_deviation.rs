//! Random deviations: pure functions of seed, trial and parameter.

use super::monte_carlo::DeviationShape;

/// Standard deviation of a normal deviation relative to its limit, where it is cut off.
const NORMAL_WIDTH: f64 = 0.5;

/// Returns a deviation between -1 and 1, relative to the limit.
pub(super) fn deviation(shape: DeviationShape, seed: u64, trial: u64, parameter: u64) -> f64 {
    let mut state = mix(mix(mix(seed) ^ trial) ^ parameter);
    let mut next = || {
        state = state.wrapping_add(GOLDEN);
        // 53 bits, in (0, 1).
        ((mix(state) >> 11) as f64 + 0.5) / (1u64 << 53) as f64
    };
    match shape {
        DeviationShape::Uniform => 2.0 * next() - 1.0,
        DeviationShape::Extremes => {
            if next() < 0.5 {
                -1.0
            } else {
                1.0
            }
        }
        DeviationShape::Normal => loop {
            // Box & Muller 1958.
            let radius = (-2.0 * next().ln()).sqrt();
            let value = NORMAL_WIDTH * radius * (std::f64::consts::TAU * next()).cos();
            if value.abs() <= 1.0 {
                return value;
            }
        },
    }
}

/// 2^64 over the golden ratio.
const GOLDEN: u64 = 0x9e37_79b9_7f4a_7c15;

/// Mixes the bits of a number: the finalizer of splitmix64 (Steele, Lea & Flood 2014).
fn mix(x: u64) -> u64 {
    let x = x.wrapping_add(GOLDEN);
    let x = (x ^ (x >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    x ^ (x >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Mean, variance and largest size of many deviations.
    fn moments(shape: DeviationShape) -> [f64; 3] {
        let all: Vec<f64> = (0..40_000).map(|i| deviation(shape, 7, i / 20, i % 20)).collect();
        let mean = all.iter().sum::<f64>() / all.len() as f64;
        let variance = all.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / all.len() as f64;
        [mean, variance, all.iter().fold(0.0, |most, x| most.max(x.abs()))]
    }

    #[test]
    fn deviations_have_the_moments_of_their_shape_and_keep_the_limit() {
        // Variance of a normal deviation cut off at two standard deviations: 1 - 4 phi(2) / P.
        let cut = 1.0 - 4.0 * 0.053_990_97 / 0.954_499_74;
        for (shape, variance) in [
            (DeviationShape::Uniform, 1.0 / 3.0),
            (DeviationShape::Extremes, 1.0),
            (DeviationShape::Normal, 0.25 * cut),
        ] {
            let [mean, found, most] = moments(shape);
            assert!(mean.abs() < 4.0 * (variance / 40_000.0_f64).sqrt(), "{shape:?}: mean {mean}");
            assert!((found / variance - 1.0).abs() < 0.03, "{shape:?}: variance {found}");
            assert!(most <= 1.0 && most > 0.99, "{shape:?}: largest {most}");
        }
    }
}
