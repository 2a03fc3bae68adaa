//! Filter along one axis, as tables for samples and for values.

use super::Profile;

/// Number of steps of the tables.
const STEPS: usize = 2048;

/// The smallest f32 whose last bit is worth 1.
const TWO_TO_23: f32 = 8_388_608.0;

/// Filter along one axis, tabulated.
#[derive(Clone, Debug)]
pub(super) struct FilterAxis {
    pub(super) radius: f64,
    /// Inverse of the cumulative distribution of the filter's magnitude, [`STEPS`] + 1 positions;
    /// empty for a box.
    inverse_cdf: Vec<f32>,
    /// Weight of the samples of each step, 1 on average; empty if the filter has no negative lobe.
    pub(super) weights: Vec<f32>,
    /// Filter at the edges of the steps from its centre to its radius, and the change to the next;
    /// empty for a box.
    values: Vec<[f32; 2]>,
    /// Integral of the filter (pixels).
    pub(super) integral: f64,
}

impl FilterAxis {
    pub(super) fn new(profile: Profile, radius: f64) -> Self {
        if profile == Profile::Box {
            return Self {
                radius,
                inverse_cdf: Vec::new(),
                weights: Vec::new(),
                values: Vec::new(),
                integral: 2.0 * radius,
            };
        }
        let cells = 16 * STEPS;
        let edge = |i: usize| radius * (2.0 * i as f64 / cells as f64 - 1.0);
        // Integrals of the filter and of its magnitude from the left edge to each cell's.
        let mut sums = vec![[0.0; 2]];
        let (mut sum, mut signed) = ([0.0; 2], false);
        for i in 0..cells {
            let value = profile.at((edge(i) + edge(i + 1)) / 2.0, radius);
            signed |= value < 0.0;
            sum = [sum[0] + value, sum[1] + value.abs()];
            sums.push(sum);
        }
        // By share of the magnitude's integral: the position, and the filter's integral up to it.
        let mut cell = 0;
        let quantiles: Vec<[f64; 2]> = (0..=STEPS)
            .map(|i| {
                let goal = sum[1] * i as f64 / STEPS as f64;
                while cell + 1 < cells && sums[cell + 1][1] < goal {
                    cell += 1;
                }
                let width = sums[cell + 1][1] - sums[cell][1];
                let within = if width > 0.0 { (goal - sums[cell][1]) / width } else { 0.0 };
                let within = within.clamp(0.0, 1.0);
                let between = |a: f64, b: f64| a + within * (b - a);
                [between(edge(cell), edge(cell + 1)), between(sums[cell][0], sums[cell + 1][0])]
            })
            .collect();
        let share = |step: &[[f64; 2]]| ((step[1][1] - step[0][1]) / sum[0] * STEPS as f64) as f32;
        let weights = if signed { quantiles.windows(2).map(share).collect() } else { Vec::new() };
        let value = |i: usize| {
            let distance = radius * i.min(STEPS) as f64 / STEPS as f64;
            profile.at(distance, radius) as f32
        };
        let values = (0..=STEPS).map(|i| [value(i), value(i + 1) - value(i)]).collect();
        let inverse_cdf = quantiles.iter().map(|quantile| quantile[0] as f32).collect();
        let integral = sum[0] * 2.0 * radius / cells as f64;
        Self { radius, inverse_cdf, weights, values, integral }
    }

    /// Multiplies each value by the filter at a position relative to the pixel's centre.
    pub(super) fn multiply(&self, positions: &[f32], values: &mut [f32]) {
        let (positions, last_positions) = positions.as_chunks();
        let (values, last_values) = values.as_chunks_mut::<8>();
        for (values, positions) in values.iter_mut().zip(positions) {
            multiply(values, self.values_at(positions));
        }
        let mut padded = [f32::NAN; 8];
        for (padded, position) in padded.iter_mut().zip(last_positions) {
            *padded = *position;
        }
        multiply(last_values, self.values_at(&padded));
    }

    /// Returns the filter at positions relative to the pixel's centre; 0 at NaN.
    #[inline(always)]
    pub(super) fn values_at(&self, positions: &[f32; 8]) -> [f32; 8] {
        let radius = self.radius as f32;
        let inside = |position: f32| position.abs() <= radius;
        if self.values.is_empty() {
            return positions.map(|position| f32::from(u8::from(inside(position))));
        }
        let per_step = STEPS as f32 / radius;
        let (mut within, mut steps) = ([0.0; 8], [0u32; 8]);
        for i in 0..8 {
            let scaled = positions[i].abs() * per_step;
            let step = scaled.floor().min(STEPS as f32);
            within[i] = scaled - step;
            // Its integer, in the mantissa: vectors have no conversion that saturates.
            steps[i] = (step + TWO_TO_23).to_bits() ^ TWO_TO_23.to_bits();
        }
        let steps = steps.map(|step| self.values[step as usize]);
        let mut values = [0.0; 8];
        for i in 0..8 {
            let [low, change] = steps[i];
            let value = within[i].mul_add(change, low);
            values[i] = if inside(positions[i]) { value } else { 0.0 };
        }
        values
    }

    /// Returns the position, relative to the pixel's centre, for a random number in [0, 1).
    #[inline(always)]
    pub(super) fn place(&self, u: f32) -> f32 {
        if self.inverse_cdf.is_empty() {
            return (2.0 * u - 1.0) * self.radius as f32;
        }
        let (step, scaled) = (step(u), u * STEPS as f32);
        let [low, high] = [self.inverse_cdf[step], self.inverse_cdf[step + 1]];
        (scaled - step as f32).mul_add(high - low, low)
    }

    pub(super) fn weight(&self, u: f32) -> f32 {
        self.weights.get(step(u)).copied().unwrap_or(1.0)
    }
}

/// Multiplies values by factors; a factor of 0 gives 0, whatever the value.
#[inline(always)]
fn multiply(values: &mut [f32], factors: [f32; 8]) {
    for (value, factor) in values.iter_mut().zip(factors) {
        *value = if factor == 0.0 { 0.0 } else { *value * factor };
    }
}

/// Returns the step of the tables that contains a number in [0, 1).
#[inline(always)]
fn step(u: f32) -> usize {
    ((u * STEPS as f32) as usize).min(STEPS - 1)
}
