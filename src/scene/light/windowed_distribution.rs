//! Piecewise constant density over a grid on the unit square, restricted to a window of it.

/// A window of the unit square: its first corner and its end.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
    pub(crate) low: [f32; 2],
    pub(crate) high: [f32; 2],
}

impl Window {
    /// Returns whether a point is in the window.
    pub(crate) fn contains(&self, uv: [f32; 2]) -> bool {
        (0..2).all(|i| (self.low[i]..=self.high[i]).contains(&uv[i]))
    }
}

/// A piecewise constant density over the unit square that can be sampled in any window, by a
/// summed-area table (Bitterli, Wyman, Pharr, Shirley, Lefohn & Jarosz 2015, "Portal-masked
/// environment map sampling", section 4; Crow 1984).
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WindowedDistribution {
    size: [usize; 2],
    /// Sums of the weights of the cells before each corner of the grid, (width + 1) x (height + 1).
    sums: Vec<f64>,
}

/// A sampled point of a window.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct WindowSample {
    pub(crate) uv: [f32; 2],
    /// Column and row of its cell; rounding may put `uv` into a neighbour.
    pub(crate) cell: [usize; 2],
    /// Probability density per unit of the square's area.
    pub(crate) density: f32,
}

impl WindowedDistribution {
    /// Returns the distribution whose cells have densities in proportion to their weights, which
    /// are 0 or more.
    pub(crate) fn new(size: [usize; 2], weight: impl Fn(usize, usize) -> f64) -> Self {
        let [width, height] = size;
        let mut sums = vec![0.0; (width + 1) * (height + 1)];
        for y in 0..height {
            let mut row = 0.0;
            for x in 0..width {
                row += weight(x, y);
                sums[(y + 1) * (width + 1) + x + 1] = sums[y * (width + 1) + x + 1] + row;
            }
        }
        Self { size, sums }
    }

    /// Returns whether all weights are 0.
    pub(crate) fn is_zero(&self) -> bool {
        self.sums.last().is_none_or(|&sum| sum <= 0.0)
    }

    /// Returns the sum of the weights before column x, up to row y; both count in cells.
    fn before(&self, [x, y]: [f64; 2]) -> f64 {
        let [width, height] = self.size;
        let (column, row) = ((x as usize).min(width - 1), (y as usize).min(height - 1));
        let (fx, fy) = (x - column as f64, y - row as f64);
        let at = |x: usize, y: usize| self.sums[y * (width + 1) + x];
        let low = at(column, row) + fx * (at(column + 1, row) - at(column, row));
        let high = at(column, row + 1) + fx * (at(column + 1, row + 1) - at(column, row + 1));
        low + fy * (high - low)
    }

    /// Returns the sum of the weights between two corners, in cells.
    fn between(&self, [x0, y0]: [f64; 2], [x1, y1]: [f64; 2]) -> f64 {
        let inside = self.before([x1, y1]) - self.before([x0, y1]);
        (inside - (self.before([x1, y0]) - self.before([x0, y0]))).max(0.0)
    }

    /// Returns the corners of a window, in cells.
    fn corners(&self, window: &Window) -> [[f64; 2]; 2] {
        [window.low, window.high].map(|corner| {
            [0, 1].map(|i| f64::from(corner[i].clamp(0.0, 1.0)) * self.size[i] as f64)
        })
    }

    fn weight(&self, [x, y]: [usize; 2]) -> f64 {
        let [low, high] = [[x, y], [x + 1, y + 1]].map(|corner| corner.map(|v| v as f64));
        self.between(low, high)
    }

    /// Samples a point of a window from two numbers in [0, 1). Returns `None` if its weights are 0.
    pub(crate) fn sample(&self, u: [f32; 2], window: &Window) -> Option<WindowSample> {
        let [low, high] = self.corners(window);
        let total = self.between(low, high);
        if total.is_nan() || total <= 0.0 {
            return None;
        }
        let (column, x) =
            place(f64::from(u[0]), [low[0], high[0]], |x| self.between(low, [x, high[1]]) / total);
        let [left, right] = [column as f64, column as f64 + 1.0];
        let in_column = self.between([left, low[1]], [right, high[1]]);
        if in_column <= 0.0 {
            return None;
        }
        let (row, y) = place(f64::from(u[1]), [low[1], high[1]], |y| {
            self.between([left, low[1]], [right, y]) / in_column
        });
        let cell = [column, row];
        let area = (self.size[0] * self.size[1]) as f64;
        let density = (self.weight(cell) / total * area) as f32;
        let uv = [x / self.size[0] as f64, y / self.size[1] as f64].map(|v| v as f32);
        (density > 0.0).then_some(WindowSample { uv, cell, density })
    }

    /// Returns the density of [`Self::sample`] at a point; 0 outside the window.
    pub(crate) fn density(&self, uv: [f32; 2], window: &Window) -> f32 {
        let [low, high] = self.corners(window);
        let total = self.between(low, high);
        if !window.contains(uv) || total.is_nan() || total <= 0.0 {
            return 0.0;
        }
        let area = (self.size[0] * self.size[1]) as f64;
        (self.weight(self.cell(uv)) / total * area) as f32
    }

    /// Returns the cell of a point of the unit square.
    pub(crate) fn cell(&self, uv: [f32; 2]) -> [usize; 2] {
        [0, 1].map(|i| ((uv[i] * self.size[i] as f32) as usize).min(self.size[i] - 1))
    }
}

/// Returns the cell and the point between two ends, in cells, at which a cumulative distribution
/// reaches `u`. The distribution is linear within cells.
fn place(u: f64, [low, high]: [f64; 2], cumulative: impl Fn(f64) -> f64) -> (usize, f64) {
    let first = low.floor() as usize;
    let end = (high.ceil() as usize).max(first + 1);
    // The last cell whose start the distribution reaches before u.
    let (mut from, mut to) = (first, end);
    while to - from > 1 {
        let middle = from.midpoint(to);
        if cumulative(middle as f64) <= u { from = middle } else { to = middle }
    }
    let (start, stop) = (low.max(from as f64), high.min(to as f64));
    let [before, after] = [start, stop].map(&cumulative);
    let t = if after > before { ((u - before) / (after - before)).clamp(0.0, 1.0) } else { 0.5 };
    (from, start + t * (stop - start))
}

#[cfg(test)]
mod tests {
    use super::*;

    const WEIGHTS: [[f64; 4]; 3] =
        [[1.0, 0.0, 2.0, 1.0], [0.0, 4.0, 0.0, 0.5], [5.0, 3.0, 0.0, 0.0]];

    fn distribution() -> WindowedDistribution {
        WindowedDistribution::new([4, 3], |x, y| WEIGHTS[y][x])
    }

    fn windows() -> [Window; 4] {
        [
            Window { low: [0.0; 2], high: [1.0; 2] },
            Window { low: [0.1, 0.2], high: [0.7, 0.95] },
            Window { low: [0.3, 0.4], high: [0.45, 0.6] },
            Window { low: [0.49, 0.0], high: [0.51, 1.0] },
        ]
    }

    #[test]
    fn the_density_integrates_to_one_over_a_window() {
        let (of, n) = (distribution(), 600);
        for window in windows() {
            let mut sum = 0.0;
            for i in 0..n * n {
                let t = [i % n, i / n].map(|i| (i as f32 + 0.5) / n as f32);
                let uv = [0, 1].map(|i| window.low[i] + t[i] * (window.high[i] - window.low[i]));
                sum += f64::from(of.density(uv, &window));
            }
            let area: f32 = (0..2).map(|i| window.high[i] - window.low[i]).product();
            let integral = sum / f64::from(n * n) * f64::from(area);
            assert!((integral - 1.0).abs() < 0.01, "{window:?}: {integral}");
        }
    }

    #[test]
    fn samples_have_their_density_and_fill_the_window_by_it() {
        let (of, n) = (distribution(), 400);
        for window in windows() {
            let mut inverse = 0.0;
            let mut counts = [[0.0; 4]; 3];
            for i in 0..n * n {
                let u = [i % n, i / n].map(|i| (i as f32 + 0.5) / n as f32);
                let chosen = of.sample(u, &window).expect("weights above 0");
                assert!(window.contains(chosen.uv), "{chosen:?}");
                let [x, y] = chosen.cell;
                counts[y][x] += 1.0 / f64::from(n * n);
                inverse += 1.0 / f64::from(chosen.density);
            }
            // The mean of 1 / density is the area of the cells that have weight.
            let (mut lit, mut total) = (0.0, 0.0);
            let mut expected = [[0.0; 4]; 3];
            for y in 0..3 {
                for x in 0..4 {
                    let overlap = |i: usize, cell: usize, n: f32| {
                        let high = window.high[i].min((cell + 1) as f32 / n);
                        f64::from((high - window.low[i].max(cell as f32 / n)).max(0.0))
                    };
                    let area = overlap(0, x, 4.0) * overlap(1, y, 3.0);
                    lit += if WEIGHTS[y][x] > 0.0 { area } else { 0.0 };
                    expected[y][x] = area * WEIGHTS[y][x];
                    total += expected[y][x];
                }
            }
            assert!((inverse / f64::from(n * n) / lit - 1.0).abs() < 0.02, "{window:?}");
            for (found, expected) in counts.as_flattened().iter().zip(expected.as_flattened()) {
                assert!((found - expected / total).abs() < 0.01, "{window:?}: {counts:?}");
            }
        }
    }

    #[test]
    fn a_window_without_weight_has_no_samples() {
        let of = distribution();
        let dark = Window { low: [0.26, 0.0], high: [0.49, 0.3] };
        assert_eq!(of.sample([0.5; 2], &dark), None);
        assert_eq!(of.density([0.3, 0.1], &dark), 0.0);
        let nothing = WindowedDistribution::new([2, 2], |_, _| 0.0);
        assert!(nothing.is_zero() && !of.is_zero());
        let outside = windows()[1];
        assert_eq!(of.density([0.05, 0.5], &outside), 0.0);
    }

    #[test]
    fn extreme_numbers_sample_points_of_the_window() {
        let last = 1.0 - f32::EPSILON / 2.0;
        for window in windows() {
            for u in [[0.0, 0.0], [0.0, last], [last, 0.0], [last, last]] {
                if let Some(chosen) = distribution().sample(u, &window) {
                    assert!(chosen.density > 0.0 && window.contains(chosen.uv), "{chosen:?}");
                }
            }
        }
    }
}
