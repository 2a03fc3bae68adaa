//! Sample allocation: the number of samples of each tile.
//!
//! With a variance v of one sample and a count n, the squared errors of all tiles add up to
//! sum v / n. For a given sum of counts, this is smallest if n is proportional to sqrt(v) (Neyman 1934).

/// Smallest density of samples relative to the mean: a tile may contain light that has not been found.
const MIN_DENSITY: f64 = 0.25;

/// Distribution of samples over tiles.
pub(super) struct SampleAllocation<'a> {
    /// The number of pixels of each tile that light reaches.
    pixels: &'a [u64],
    /// The number of samples per pixel of each tile.
    counts: &'a [u32],
    /// The relative variance of one sample, added up over the pixels of each tile.
    variance: &'a [f64],
    /// The density of samples of each tile, to which counts are proportional.
    density: Vec<f64>,
}

impl<'a> SampleAllocation<'a> {
    pub(super) fn new(pixels: &'a [u64], counts: &'a [u32], variance: &'a [f64]) -> Self {
        let root = |(&v, &pixels): (&f64, &u64)| (v / pixels as f64).sqrt();
        let mut density: Vec<f64> = variance.iter().zip(pixels).map(root).collect();
        let all: f64 = pixels.iter().map(|&pixels| pixels as f64).sum();
        let sum: f64 = density.iter().zip(pixels).map(|(d, &pixels)| d * pixels as f64).sum();
        let mean = sum / all;
        for density in &mut density {
            // Without any variance, all tiles have equal density.
            *density = if mean > 0.0 { density.max(MIN_DENSITY * mean) } else { 1.0 };
        }
        Self { pixels, counts, variance, density }
    }

    /// Returns the counts for a scale of the density. Samples that are taken stay.
    fn counts(&self, scale: f64) -> impl Iterator<Item = u32> {
        let count = move |(&taken, density): (&u32, &f64)| taken.max((scale * density) as u32);
        self.counts.iter().zip(&self.density).map(count)
    }

    fn error(&self, scale: f64) -> f64 {
        self.counts(scale).zip(self.variance).map(|(n, v)| v / f64::from(n)).sum()
    }

    fn cost(&self, scale: f64) -> f64 {
        cost(self.pixels, self.counts(scale))
    }

    /// Returns the smallest counts whose squared errors add up to at most `bound`, or the largest that
    /// cost at most `budget`, whichever are fewer.
    pub(super) fn wanted(&self, bound: Option<f64>, budget: f64) -> Vec<u32> {
        let accurate = |scale| bound.is_some_and(|bound| self.error(scale) <= bound);
        let enough = |scale| accurate(scale) || self.cost(scale) > budget;
        if enough(0.0) {
            return self.counts.to_vec();
        }
        let [mut low, mut high] = [0.0, 1.0 / self.density.iter().copied().fold(0.0, f64::max)];
        while !enough(high) && high.is_finite() {
            (low, high) = (high, 2.0 * high);
        }
        for _ in 0..50 {
            let middle = (low + high) / 2.0;
            if enough(middle) {
                high = middle;
            } else {
                low = middle;
            }
        }
        let scale = if accurate(high) && self.cost(high) <= budget { high } else { low };
        self.counts(scale).collect()
    }
}

/// Returns the number of samples of all tiles together.
pub(super) fn cost(pixels: &[u64], counts: impl Iterator<Item = u32>) -> f64 {
    pixels.iter().zip(counts).map(|(&pixels, n)| pixels as f64 * f64::from(n)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PIXELS: [u64; 3] = [256, 128, 256];
    const TAKEN: [u32; 3] = [4, 4, 4];

    #[test]
    fn a_bound_is_met_with_the_fewest_samples() {
        let variance = [256.0, 128.0 * 9.0, 256.0 * 4.0];
        let allocation = SampleAllocation::new(&PIXELS, &TAKEN, &variance);
        let wanted = allocation.wanted(Some(20.0), 1e9);
        let error = |counts: &[u32]| {
            counts.iter().zip(variance).map(|(&n, v)| v / f64::from(n)).sum::<f64>()
        };
        assert!(error(&wanted) <= 20.0 && error(&wanted) > 19.0, "{wanted:?}");
        // By Lagrange: n = sqrt(v) sum sqrt(v) / bound, a pixel.
        let expected = [1.0, 3.0, 2.0].map(|root| root * (256.0 + 384.0 + 512.0) / 20.0);
        for (&n, expected) in wanted.iter().zip(expected) {
            assert!((f64::from(n) - expected).abs() <= 2.0, "{wanted:?} {expected}");
        }
    }

    #[test]
    fn a_budget_is_nearly_spent_and_never_exceeded() {
        let variance = [1.0, 1e6, 0.0];
        let allocation = SampleAllocation::new(&PIXELS, &TAKEN, &variance);
        for budget in [1000.0, 2560.0, 3000.0, 1e4, 1e6] {
            let wanted = allocation.wanted(None, budget);
            let cost = cost(&PIXELS, wanted.iter().copied());
            assert!(cost <= f64::max(budget, 2560.0), "{budget}: {wanted:?}");
            assert!(cost > budget - 640.0, "{budget}: {wanted:?}");
            assert!(wanted.iter().all(|&n| n >= 4));
        }
        assert_eq!(allocation.wanted(Some(1e9), 1e9), TAKEN);
    }

    #[test]
    fn a_tile_without_variance_takes_the_smallest_density() {
        let allocation = SampleAllocation::new(&PIXELS, &TAKEN, &[0.0, 128.0, 0.0]);
        let wanted = allocation.wanted(None, 1e6);
        // The mean density is a fifth of the largest, and the other tiles have MIN_DENSITY of it.
        assert!((f64::from(wanted[0]) / f64::from(wanted[1]) - 0.05).abs() < 1e-3, "{wanted:?}");
        let equal = SampleAllocation::new(&PIXELS, &TAKEN, &[0.0; 3]);
        assert_eq!(equal.wanted(None, 6400.0), [10; 3]);
    }
}
