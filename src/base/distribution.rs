//! Discrete distribution, and piecewise constant density over a grid on the unit square.

/// A discrete distribution over the first whole numbers, sampled by its cumulative sums.
#[derive(Clone, Debug, PartialEq)]
pub struct DiscreteDistribution {
    /// Cumulative probabilities, from 0 to 1.
    cumulative: Vec<f32>,
}

impl DiscreteDistribution {
    /// Returns the distribution with probabilities in proportion to the weights; `None` if their sum is
    /// not above 0 or not finite.
    pub fn new(weights: &[f64]) -> Option<Self> {
        let total: f64 = weights.iter().sum();
        let mut cumulative = Vec::with_capacity(weights.len() + 1);
        cumulate(weights, total, &mut cumulative);
        (total > 0.0 && total.is_finite()).then_some(Self { cumulative })
    }

    /// Returns the distribution of these probabilities, of which there is at least one. Their sum is 1,
    /// but for rounding.
    pub fn from_probabilities(probabilities: &[f64]) -> Self {
        let mut cumulative = Vec::with_capacity(probabilities.len() + 1);
        cumulate(probabilities, 1.0, &mut cumulative);
        Self { cumulative }
    }

    /// Samples a number from one in [0, 1).
    #[inline]
    pub fn sample(&self, u: f32) -> usize {
        find_interval(&self.cumulative, u)
    }

    /// Returns the probability of a number; 0 beyond the last.
    pub fn probability(&self, i: usize) -> f32 {
        self.cumulative.get(i + 1).map_or(0.0, |sum| sum - self.cumulative[i])
    }
}

/// A piecewise constant density over the unit square.
#[derive(Clone, Debug, PartialEq)]
pub struct Distribution {
    size: [usize; 2],
    /// Cumulative distribution over the rows, from 0 to 1.
    rows: Vec<f32>,
    /// For each row the cumulative distribution over its cells, from 0 to 1.
    cells: Vec<f32>,
}

/// A sampled point of the square.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DistributionSample {
    /// The point, 0 to 1 each.
    pub uv: [f32; 2],
    /// Column and row of its cell; rounding may put `uv` into a neighbour.
    pub cell: [usize; 2],
    /// Probability density per unit of the square's area.
    pub density: f32,
}

impl Distribution {
    /// Returns the distribution whose cells are chosen in proportion to their weights; `None` if no
    /// weight is above 0.
    pub fn new(size: [usize; 2], weight: impl Fn(usize, usize) -> f64) -> Option<Self> {
        let [width, height] = size;
        let mut cells = Vec::with_capacity((width + 1) * height);
        let mut totals = Vec::with_capacity(height);
        let mut row = vec![0.0; width];
        for y in 0..height {
            for (x, value) in row.iter_mut().enumerate() {
                *value = weight(x, y);
            }
            let total = row.iter().sum();
            cumulate(&row, total, &mut cells);
            totals.push(total);
        }
        let mut rows = Vec::with_capacity(height + 1);
        let total = totals.iter().sum();
        cumulate(&totals, total, &mut rows);
        (total > 0.0 && total.is_finite()).then_some(Self { size, rows, cells })
    }

    fn row(&self, y: usize) -> &[f32] {
        let stride = self.size[0] + 1;
        &self.cells[y * stride..(y + 1) * stride]
    }

    /// Samples a point from two numbers in [0, 1).
    #[inline]
    pub fn sample(&self, u: [f32; 2]) -> DistributionSample {
        let (y, v, share_y) = place_in_interval(&self.rows, u[1]);
        let (x, u, share_x) = place_in_interval(self.row(y), u[0]);
        let [width, height] = self.size.map(|n| n as f32);
        DistributionSample {
            uv: [(x as f32 + u) / width, (y as f32 + v) / height],
            cell: [x, y],
            density: share_x * share_y * width * height,
        }
    }

    /// Returns the density of [`Self::sample`] at a point.
    pub fn density(&self, uv: [f32; 2]) -> f32 {
        let [x, y] = [0, 1].map(|i| {
            let n = self.size[i];
            ((uv[i] * n as f32) as usize).min(n - 1)
        });
        let row = self.row(y);
        let [width, height] = self.size.map(|n| n as f32);
        (row[x + 1] - row[x]) * (self.rows[y + 1] - self.rows[y]) * width * height
    }
}

/// Appends the cumulative sums of the values over their total, from 0 to 1.
fn cumulate(values: &[f64], total: f64, shares: &mut Vec<f32>) {
    let mut sum = 0.0;
    shares.push(0.0);
    for value in values {
        sum += value;
        let share = if total > 0.0 { (sum / total) as f32 } else { 0.0 };
        shares.push(share.min(1.0));
    }
    if total > 0.0 {
        // Rounding must leave no gap at the end, and no probability for cells without weight.
        let last = values.iter().rposition(|&value| value > 0.0).unwrap_or(0);
        let end = shares.len() - values.len() + last;
        shares[end..].fill(1.0);
    }
}

/// Returns the interval of a cumulative distribution that contains a number.
#[inline]
fn find_interval(shares: &[f32], u: f32) -> usize {
    shares.partition_point(|&share| share <= u).clamp(1, shares.len() - 1) - 1
}

/// Returns the interval of a cumulative distribution that contains a number, the position of the
/// number in it from 0 to 1, and its width.
#[inline]
fn place_in_interval(shares: &[f32], u: f32) -> (usize, f32, f32) {
    let i = find_interval(shares, u);
    let width = shares[i + 1] - shares[i];
    (i, ((u - shares[i]) / width).clamp(0.0, 1.0 - f32::EPSILON / 2.0), width)
}

#[cfg(test)]
mod tests {
    use super::*;

    const WEIGHTS: [[f64; 4]; 3] =
        [[1.0, 0.0, 2.0, 1.0], [0.0, 0.0, 0.0, 0.0], [5.0, 3.0, 0.0, 0.0]];

    #[test]
    fn numbers_are_sampled_in_proportion_to_their_weights() {
        let weights = [1.0, 0.0, 2.0, 1.0, 0.0];
        let of = DiscreteDistribution::new(&weights).expect("weights above 0");
        for (u, expected) in [(0.0, 0), (0.24, 0), (0.25, 2), (0.74, 2), (0.76, 3), (0.999_999, 3)]
        {
            assert_eq!(of.sample(u), expected, "{u}");
        }
        let all: Vec<f32> = (0..6).map(|i| of.probability(i)).collect();
        assert_eq!(all, [0.25, 0.0, 0.5, 0.25, 0.0, 0.0]);
        assert_eq!(of, DiscreteDistribution::from_probabilities(&weights.map(|w| w / 4.0)));
        for nothing in [vec![0.0; 3], vec![f64::INFINITY], vec![]] {
            assert_eq!(DiscreteDistribution::new(&nothing), None);
        }
    }

    #[test]
    fn cells_are_sampled_in_proportion_to_their_weights() {
        let of = Distribution::new([4, 3], |x, y| WEIGHTS[y][x]).expect("weights above 0");
        let n = 300;
        let mut counts = [[0.0; 4]; 3];
        for i in 0..n * n {
            let u = [i % n, i / n].map(|i| (i as f32 + 0.5) / n as f32);
            let chosen = of.sample(u);
            let [x, y] = chosen.cell;
            counts[y][x] += 12.0 / f64::from(n * n);
            let expected = WEIGHTS[y][x];
            assert!((f64::from(chosen.density) / expected - 1.0).abs() < 1e-5);
            assert_eq!(chosen.density, of.density(chosen.uv));
        }
        for (row, weights) in counts.iter().zip(WEIGHTS) {
            for (count, weight) in row.iter().zip(weights) {
                assert!((count - weight).abs() < 0.03, "{count} instead of {weight}");
            }
        }
    }

    #[test]
    fn extreme_numbers_sample_cells_with_weight() {
        let of = Distribution::new([4, 3], |x, y| WEIGHTS[y][x]).expect("weights above 0");
        let last = 1.0 - f32::EPSILON / 2.0;
        for u in [[0.0, 0.0], [0.0, last], [last, 0.0], [last, last]] {
            let chosen = of.sample(u);
            assert!(chosen.density > 0.0 && chosen.uv.iter().all(|&c| (0.0..=1.0).contains(&c)));
        }
    }

    #[test]
    fn weights_of_zero_have_no_distribution() {
        assert_eq!(Distribution::new([2, 2], |_, _| 0.0), None);
    }
}
