//! Functions over the unit square, bilinear between the points of a grid, that depend on two further
//! parameters, between whose values they are linear. Densities map uniform points to their own.

/// A function over the unit square for a list of two parameters.
#[derive(Clone, Debug)]
pub(super) struct Grid {
    /// Width and height (points), at least 2 each.
    pub(super) size: [usize; 2],
    /// Values of the two parameters, ascending.
    pub(super) parameters: [Vec<f32>; 2],
    /// Number of values at every point.
    pub(super) channels: usize,
    /// Points within rows within channels within slices; the second parameter varies faster.
    pub(super) values: Vec<f32>,
}

/// Slices of a grid, and their weights.
type Slices = [(usize, f32); 4];

impl Grid {
    /// Returns the slices around two parameters, which are clamped to the lists.
    fn slices(&self, at: [f32; 2]) -> Slices {
        let [(i, s), (j, t)] = [0, 1].map(|axis| interval(&self.parameters[axis], at[axis]));
        let count = self.parameters[1].len();
        let slice = |di: usize, dj: usize| {
            let i = (i + di).min(self.parameters[0].len() - 1);
            i * count + (j + dj).min(count - 1)
        };
        [
            (slice(0, 0), (1.0 - s) * (1.0 - t)),
            (slice(0, 1), (1.0 - s) * t),
            (slice(1, 0), s * (1.0 - t)),
            (slice(1, 1), s * t),
        ]
    }

    /// Returns a channel at a point.
    pub(super) fn at(&self, uv: [f32; 2], parameters: [f32; 2], channel: usize) -> f32 {
        let ([x, y], [fx, fy]) = self.cell(uv);
        let slices = self.slices(parameters);
        let [top, bottom] = [y, y + 1].map(|y| {
            let [a, b] = [x, x + 1].map(|x| self.point(&slices, channel, x, y));
            a + fx * (b - a)
        });
        top + fy * (bottom - top)
    }

    /// Returns the cell of a point and the place in it, from 0 to 1.
    fn cell(&self, uv: [f32; 2]) -> ([usize; 2], [f32; 2]) {
        let place = [0, 1].map(|i| uv[i].clamp(0.0, 1.0) * (self.size[i] - 1) as f32);
        let cell = [0, 1].map(|i| (place[i] as usize).min(self.size[i] - 2));
        (cell, [0, 1].map(|i| place[i] - cell[i] as f32))
    }

    fn point(&self, slices: &Slices, channel: usize, x: usize, y: usize) -> f32 {
        let points = self.size[0] * self.size[1];
        let index =
            |slice: usize| (slice * self.channels + channel) * points + y * self.size[0] + x;
        slices.iter().map(|&(slice, weight)| weight * self.values[index(slice)]).sum()
    }
}

/// Returns the last entry of an ascending list that is not above a value, but not the last, and the
/// place of the value between it and the next, from 0 to 1.
fn interval(list: &[f32], value: f32) -> (usize, f32) {
    if list.len() < 2 {
        return (0, 0.0);
    }
    let i = list.partition_point(|&entry| entry <= value).clamp(1, list.len() - 1) - 1;
    (i, ((value - list[i]) / (list[i + 1] - list[i])).clamp(0.0, 1.0))
}

/// A density over the unit square, which integrates to 1 for all parameters.
#[derive(Clone, Debug)]
pub(super) struct Warp {
    density: Grid,
    /// Integral from the left edge to each point along its row [cells].
    along: Grid,
    /// Integral from the upper edge to each row [cells]; a grid of one column, repeated.
    rows: Grid,
}

/// A point that a warp sends to another, and its density.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Warped {
    pub(super) uv: [f32; 2],
    /// Density of the end of the warp per unit of the square's area.
    pub(super) density: f32,
}

impl Warp {
    /// Makes a density that is proportional to a function of one channel, 0 or more. Returns `None`
    /// if a slice has no integral above 0.
    pub(super) fn new(function: Grid) -> Option<Self> {
        let ([width, height], mut density) = (function.size, function);
        let mut along =
            Grid { values: Vec::with_capacity(density.values.len()), ..density.clone() };
        along.values.clear();
        let mut rows = Grid { size: [1, height], values: Vec::new(), ..along.clone() };
        for slice in density.values.chunks_exact_mut(width * height) {
            let (first_point, first_row) = (along.values.len(), rows.values.len());
            let mut total = 0.0;
            let mut last = 0.0;
            for (y, row) in slice.chunks_exact(width).enumerate() {
                let mut sum = 0.0;
                for (x, &value) in row.iter().enumerate() {
                    if x > 0 {
                        sum += 0.5 * (f64::from(row[x - 1]) + f64::from(value));
                    }
                    along.values.push(sum as f32);
                }
                if y > 0 {
                    total += 0.5 * (last + sum);
                }
                last = sum;
                rows.values.push(total as f32);
            }
            if !(total > 0.0 && total.is_finite()) {
                return None;
            }
            let scale = (1.0 / total) as f32;
            slice.iter_mut().for_each(|value| *value *= scale);
            along.values[first_point..].iter_mut().for_each(|value| *value *= scale);
            rows.values[first_row..].iter_mut().for_each(|value| *value *= scale);
        }
        Some(Self { density, along, rows })
    }

    /// Returns the number of cells.
    fn cells(&self) -> f32 {
        ((self.density.size[0] - 1) * (self.density.size[1] - 1)) as f32
    }

    /// Returns the density at a point.
    pub(super) fn at(&self, uv: [f32; 2], parameters: [f32; 2]) -> f32 {
        self.density.at(uv, parameters, 0) * self.cells()
    }

    /// Maps a uniform point to the density.
    pub(super) fn sample(&self, u: [f32; 2], parameters: [f32; 2]) -> Warped {
        let [width, height] = self.density.size;
        let slices = self.density.slices(parameters);
        let row_start = |y: usize| self.rows.point(&slices, 0, 0, y);
        let y = last_below(height - 1, |y| row_start(y) <= u[1]);
        let [r0, r1] = [y, y + 1].map(|y| self.along.point(&slices, 0, width - 1, y));
        let fy = invert_linear(u[1] - row_start(y), r0, r1);
        let across = |a: f32, b: f32| a + fy * (b - a);
        let target = u[0] * across(r0, r1);
        let start = |x: usize| {
            across(self.along.point(&slices, 0, x, y), self.along.point(&slices, 0, x, y + 1))
        };
        let x = last_below(width - 1, |x| start(x) <= target);
        let [c0, c1] = [x, x + 1].map(|x| {
            across(self.density.point(&slices, 0, x, y), self.density.point(&slices, 0, x, y + 1))
        });
        let fx = invert_linear(target - start(x), c0, c1);
        let uv = [(x as f32 + fx) / (width - 1) as f32, (y as f32 + fy) / (height - 1) as f32];
        Warped { uv, density: (c0 + fx * (c1 - c0)) * self.cells() }
    }

    /// Maps a point of the density back to the uniform one, with the density of [`Self::sample`].
    pub(super) fn invert(&self, uv: [f32; 2], parameters: [f32; 2]) -> Warped {
        let width = self.density.size[0];
        let slices = self.density.slices(parameters);
        let ([x, y], [fx, fy]) = self.density.cell(uv);
        let across = |a: f32, b: f32| a + fy * (b - a);
        let [c0, c1] = [x, x + 1].map(|x| {
            across(self.density.point(&slices, 0, x, y), self.density.point(&slices, 0, x, y + 1))
        });
        let start =
            across(self.along.point(&slices, 0, x, y), self.along.point(&slices, 0, x, y + 1));
        let [r0, r1] = [y, y + 1].map(|y| self.along.point(&slices, 0, width - 1, y));
        let total = across(r0, r1);
        let before = start + fx * (c0 + 0.5 * fx * (c1 - c0));
        let above = self.rows.point(&slices, 0, 0, y) + fy * (r0 + 0.5 * fy * (r1 - r0));
        let u = if total > 0.0 { before / total } else { 0.5 };
        let density = (c0 + fx * (c1 - c0)) * self.cells();
        Warped { uv: [u.clamp(0.0, 1.0), above.clamp(0.0, 1.0)], density }
    }
}

/// Returns the last index below `count` for which a condition holds that holds up to some index;
/// 0 if it holds for none.
fn last_below(count: usize, holds: impl Fn(usize) -> bool) -> usize {
    let (mut low, mut high) = (0, count);
    while high - low > 1 {
        let middle = low.midpoint(high);
        if holds(middle) { low = middle } else { high = middle }
    }
    low
}

/// Returns the t from 0 to 1 at which the integral of a function that is linear from `a` at 0 to `b`
/// at 1 reaches a value: (a + (b - a) t / 2) t.
fn invert_linear(integral: f32, a: f32, b: f32) -> f32 {
    let root = (a * a + 2.0 * integral * (b - a)).max(0.0).sqrt();
    let t = 2.0 * integral / (a + root);
    if t.is_finite() { t.clamp(0.0, 1.0) } else { 0.5 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A density of 5 x 4 points with 2 x 3 slices.
    fn warp() -> Warp {
        let values = (0..120).map(|i| ((i * 37 + i / 7) % 11) as f32 + 0.2).collect();
        let parameters = [vec![-1.0, 2.0], vec![0.0, 0.4, 1.5]];
        Warp::new(Grid { size: [5, 4], parameters, channels: 1, values }).expect("a density")
    }

    const PARAMETERS: [[f32; 2]; 4] = [[-1.0, 0.0], [0.3, 0.2], [1.9, 1.4], [5.0, -3.0]];

    #[test]
    fn the_density_integrates_to_one() {
        let (warp, n) = (warp(), 300);
        for parameters in PARAMETERS {
            let sum: f64 = (0..n * n)
                .map(|i| {
                    let uv = [i % n, i / n].map(|i| (i as f32 + 0.5) / n as f32);
                    f64::from(warp.at(uv, parameters))
                })
                .sum();
            assert!((sum / f64::from(n * n) - 1.0).abs() < 1e-3, "{parameters:?}: {sum}");
        }
    }

    #[test]
    fn samples_have_their_density_and_are_inverted() {
        let warp = warp();
        for parameters in PARAMETERS {
            for i in 0..900 {
                let u = [(i % 30) as f32 / 30.0 + 0.01, (i / 30) as f32 / 30.0 + 0.02];
                let sample = warp.sample(u, parameters);
                let density = warp.at(sample.uv, parameters);
                assert!((sample.density / density - 1.0).abs() < 1e-4, "{u:?}: {sample:?}");
                let back = warp.invert(sample.uv, parameters);
                let off = (0..2).map(|i| (back.uv[i] - u[i]).abs()).fold(0.0, f32::max);
                assert!(off < 1e-4, "{u:?}: {back:?}");
                assert!((back.density / density - 1.0).abs() < 1e-4);
            }
        }
    }

    #[test]
    fn samples_fill_the_square_by_the_density() {
        let (warp, n, bins) = (warp(), 800, 6);
        for parameters in PARAMETERS {
            let mut found = [[0.0; 6]; 6];
            let mut expected = [[0.0; 6]; 6];
            for i in 0..n * n {
                let u = [i % n, i / n].map(|i| (i as f32 + 0.5) / n as f32);
                let bin = |v: f32| ((v * bins as f32) as usize).min(bins - 1);
                let [x, y] = warp.sample(u, parameters).uv.map(bin);
                found[y][x] += 1.0 / f64::from(n * n);
                let [x, y] = u.map(bin);
                expected[y][x] += f64::from(warp.at(u, parameters)) / f64::from(n * n);
            }
            for (found, expected) in found.as_flattened().iter().zip(expected.as_flattened()) {
                // A bin's edge cuts through 4 n / 6 of the n^2 points.
                assert!((found - expected).abs() < 1.5e-3, "{found}, expected {expected}");
            }
        }
    }

    #[test]
    fn extreme_numbers_and_empty_cells_give_finite_points() {
        let mut values = vec![0.0; 9];
        values[8] = 1.0;
        let size = [3, 3];
        let corner = Grid { size, parameters: [vec![0.0], vec![0.0]], channels: 1, values };
        let warp = Warp::new(corner.clone()).expect("a density");
        let last = 1.0 - f32::EPSILON / 2.0;
        for u in [[0.0, 0.0], [0.0, last], [last, 0.0], [last, last]] {
            let sample = warp.sample(u, [0.0; 2]);
            assert!(sample.uv.iter().all(|v| (0.0..=1.0).contains(v)), "{sample:?}");
            assert!(sample.density.is_finite());
        }
        assert!(Warp::new(Grid { values: vec![0.0; 9], ..corner }).is_none());
    }
}
