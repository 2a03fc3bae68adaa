//! Shares of a kernel inside a picture.

use super::half_kernel::HalfKernel;

/// Sums of the shares of a channel of a kernel over rectangles, from a summed-area table (Crow 1984).
pub(super) struct KernelSums {
    reach: [usize; 2],
    sums: Vec<f64>,
}

impl KernelSums {
    pub fn new(kernel: &HalfKernel, channel: usize) -> Self {
        let HalfKernel { reach, shares } = kernel;
        let [right, down] = *reach;
        let columns = 2 * right + 1;
        let mut sums = vec![0.0; (columns + 1) * (down + 2)];
        for y in 0..=down {
            let mut sum = 0.0;
            for x in 0..columns {
                sum += f64::from(shares[y * columns + x][channel]);
                let above = sums[y * (columns + 1) + x + 1];
                sums[(y + 1) * (columns + 1) + x + 1] = above + sum;
            }
        }
        Self { reach: *reach, sums }
    }

    /// Returns the share of the light of a pixel that stays in a picture of this width and height. By symmetry
    /// it is also what the pixel receives of an even picture.
    pub fn inside(&self, [x, y]: [usize; 2], [width, height]: [usize; 2]) -> f64 {
        let [right, down] = self.reach;
        let columns = 2 * right + 1;
        let part = |[x0, x1]: [usize; 2], [y0, y1]: [usize; 2]| {
            let sum = |x: usize, y: usize| self.sums[y * (columns + 1) + x];
            sum(x1, y1) - sum(x0, y1) - sum(x1, y0) + sum(x0, y0)
        };
        // The upper half is the lower one, rotated by 180 degrees.
        let (to_left, to_right) = (right.min(x), right.min(width - 1 - x));
        let below =
            part([right - to_left, right + to_right + 1], [0, down.min(height - 1 - y) + 1]);
        let above = part([right - to_right, right + to_left + 1], [1, down.min(y) + 1]);
        below + above
    }

    /// Returns the sum of the whole kernel.
    pub fn whole(&self) -> f64 {
        let far = self.reach.map(|reach| 2 * reach + 1);
        self.inside(self.reach, far)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_inside_are_those_of_the_pixels_inside() {
        let reach = [3, 2];
        let value = |x: isize, y: isize| (1 + (3 * x + 7 * y).rem_euclid(5)) as f32;
        // Symmetric about the centre.
        let at = |x: isize, y: isize| value(x, y) + value(-x, -y);
        let shares = (0..3).flat_map(|y| (-3..=3).map(move |x| [0.0, at(x, y), 0.0])).collect();
        let sums = KernelSums::new(&HalfKernel { reach, shares }, 1);
        let size = [5, 4];
        for y in 0..4isize {
            for x in 0..5isize {
                let mut expected = 0.0;
                for dy in -2..=2isize {
                    for dx in -3..=3isize {
                        if (0..5).contains(&(x + dx)) && (0..4).contains(&(y + dy)) {
                            expected += f64::from(at(dx, dy));
                        }
                    }
                }
                let found = sums.inside([x as usize, y as usize], size);
                assert!((found - expected).abs() < 1e-9, "{x}, {y}: {found}, not {expected}");
            }
        }
        let whole: f32 = (-2..=2).flat_map(|y| (-3..=3).map(move |x| at(x, y))).sum();
        assert!((sums.whole() - f64::from(whole)).abs() < 1e-9);
    }
}
