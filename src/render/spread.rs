//! How many samples tiles should take.
//!
//! With a variance v of one sample and a count n the errors of all tiles add up to sum v / n. For
//! the same sum of counts that is least where n is in proportion to sqrt(v) (Neyman 1934).

/// The least density of samples, as a share of the mean: what has not been seen yet may be there.
const LEAST: f64 = 0.25;

/// Tiles that want samples.
pub(super) struct Spread<'a> {
    /// Pixels of each tile that light comes to.
    pixels: &'a [u64],
    /// Samples that each of them has taken.
    counts: &'a [u32],
    /// Relative variance of one sample, added up over the tile's pixels.
    variance: &'a [f64],
    /// What counts are in proportion to.
    density: Vec<f64>,
}

impl<'a> Spread<'a> {
    pub(super) fn new(pixels: &'a [u64], counts: &'a [u32], variance: &'a [f64]) -> Self {
        let root = |(&v, &pixels): (&f64, &u64)| (v / pixels as f64).sqrt();
        let mut density: Vec<f64> = variance.iter().zip(pixels).map(root).collect();
        let all: f64 = pixels.iter().map(|&pixels| pixels as f64).sum();
        let sum: f64 = density.iter().zip(pixels).map(|(d, &pixels)| d * pixels as f64).sum();
        let mean = sum / all;
        for density in &mut density {
            // Where nothing is known all are alike.
            *density = if mean > 0.0 { density.max(LEAST * mean) } else { 1.0 };
        }
        Self { pixels, counts, variance, density }
    }

    /// The counts at a scale of the density: samples are not given back.
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

    /// The least counts whose errors add up to no more than a bound, where there is one, or the
    /// most that cost no more than a budget, if those are fewer.
    pub(super) fn wanted(&self, bound: Option<f64>, budget: f64) -> Vec<u32> {
        let exact = |scale| bound.is_some_and(|bound| self.error(scale) <= bound);
        let enough = |scale| exact(scale) || self.cost(scale) > budget;
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
        let scale = if exact(high) && self.cost(high) <= budget { high } else { low };
        self.counts(scale).collect()
    }
}

/// The samples of all tiles together.
pub(super) fn cost(pixels: &[u64], counts: impl Iterator<Item = u32>) -> f64 {
    pixels.iter().zip(counts).map(|(&pixels, n)| pixels as f64 * f64::from(n)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    const PIXELS: [u64; 3] = [256, 128, 256];
    const TAKEN: [u32; 3] = [4, 4, 4];

    #[test]
    fn a_bound_is_met_by_the_least_counts() {
        let variance = [256.0, 128.0 * 9.0, 256.0 * 4.0];
        let spread = Spread::new(&PIXELS, &TAKEN, &variance);
        let wanted = spread.wanted(Some(20.0), 1e9);
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
    fn a_budget_is_never_exceeded_and_nearly_spent() {
        let variance = [1.0, 1e6, 0.0];
        let spread = Spread::new(&PIXELS, &TAKEN, &variance);
        for budget in [1000.0, 2560.0, 3000.0, 1e4, 1e6] {
            let wanted = spread.wanted(None, budget);
            let cost = cost(&PIXELS, wanted.iter().copied());
            assert!(cost <= f64::max(budget, 2560.0), "{budget}: {wanted:?}");
            assert!(cost > budget - 640.0, "{budget}: {wanted:?}");
            assert!(wanted.iter().all(|&n| n >= 4));
        }
        assert_eq!(spread.wanted(Some(1e9), 1e9), TAKEN);
    }

    #[test]
    fn a_tile_without_variance_takes_a_share_of_the_mean() {
        let spread = Spread::new(&PIXELS, &TAKEN, &[0.0, 128.0, 0.0]);
        let wanted = spread.wanted(None, 1e6);
        // The others have LEAST of the mean density, which is a fifth.
        assert!((f64::from(wanted[0]) / f64::from(wanted[1]) - 0.05).abs() < 1e-3, "{wanted:?}");
        let even = Spread::new(&PIXELS, &TAKEN, &[0.0; 3]);
        assert_eq!(even.wanted(None, 6400.0), [10; 3]);
    }
}
