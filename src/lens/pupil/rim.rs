//! Rim of a fan: shells just outside it, where the fan may have missed light.
//!
//! A fan that misses a sliver of the pupil would leave it to the sparse samples of large regions.
//! Their weight is as large as the region: hundreds to millions of times that of a sample in the
//! fan. Rim samples are drawn close to the fan instead. A copy of a triangle, scaled by s about the
//! centre of the fan, exceeds the triangle by y = s^2 - 1 of its area. Shells end at the excesses
//! [`SHELL_ENDS`]. Each triangle and each shell is chosen equally often, and a point uniformly over
//! the area of the shell.
//!
//! # Limit of the weight
//!
//! The weight of a sample is proportional to the reciprocal of its density. For T triangles, a
//! triangle of area A and N shells, the density in a shell from y1 to y2 is q / (N T A (y2 - y1)),
//! with q = [`RIM_SHARE`](super::RIM_SHARE). Samples of the fan have the density (1 - ...) / (T A)
//! in the triangle. The ratio, and so the largest weight relative to samples in the triangle, is
//!
//! w = N (y2 - y1) / q
//!
//! or 48 where the fan misses at most 1/64 of its area, 144 up to 1/16 and 576 up to 1/4. Light
//! farther out is left to the [vicinity](super::vicinity).
//!
//! The density is constant in a shell. A density that fell continuously from the fan outwards would
//! be steep, and two strategies that compute it from slightly different points would disagree.

use super::fan::{Fan, TRIANGLES};

/// Excesses of the area of a scaled triangle over its own at which the shells end.
pub const SHELL_ENDS: [f32; 3] = [1.0 / 64.0, 1.0 / 16.0, 1.0 / 4.0];
const SHELLS: usize = SHELL_ENDS.len();

/// Returns the excesses between which a shell lies.
fn shell(index: usize) -> [f32; 2] {
    [if index == 0 { 0.0 } else { SHELL_ENDS[index - 1] }, SHELL_ENDS[index]]
}

/// Returns the density of rim samples outside a triangle, relative to that of the fan inside it.
/// `scale` is the scale at which the triangle reaches the point, more than 1.
pub(super) fn relative_density(scale: f32) -> f32 {
    let excess = (scale - 1.0) * (scale + 1.0);
    let within = (0..SHELLS).map(shell).find(|[_, end]| excess <= *end);
    within.map_or(0.0, |[start, end]| 1.0 / (SHELLS as f32 * (end - start)))
}

impl Fan {
    /// Returns the rim sample of two random numbers, mm; `None` if its triangle has no area.
    pub(super) fn rim_point(&self, [u, v]: [f32; 2]) -> Option<[f32; 2]> {
        let place = u * (SHELLS * TRIANGLES) as f32;
        let chosen = (place as usize).min(SHELLS * TRIANGLES - 1);
        let along = place - chosen as f32;
        let triangle = self.triangle(chosen % TRIANGLES);
        if triangle.area2() <= 0.0 {
            return None;
        }
        let [start, end] = shell(chosen / TRIANGLES);
        let scale = (1.0 + start + v * (end - start)).sqrt();
        let [a, b] = triangle.corners;
        Some([0, 1].map(|i| self.centre[i] + scale * (a[i] + along * (b[i] - a[i]))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a square fan of 2 mm about a point, with corners of its triangles on its sides.
    fn square() -> Fan {
        let corner = |k: usize| {
            let (sin, cos) = (k as f32 / TRIANGLES as f32 * std::f32::consts::TAU).sin_cos();
            let to_side = 1.0 / cos.abs().max(sin.abs());
            [cos * to_side, sin * to_side]
        };
        let mut corners = std::array::from_fn(corner);
        corners[TRIANGLES] = corners[0];
        Fan { centre: [3.0, -1.0], corners }
    }

    #[test]
    fn rim_samples_lie_in_the_shells_equally_often() {
        const SIDE: usize = 960;
        let fan = square();
        let mut counts = [0; SHELLS];
        for i in 0..SIDE * SIDE {
            let random = [i % SIDE, i / SIDE].map(|k| (k as f32 + 0.5) / SIDE as f32);
            let [x, y] = fan.rim_point(random).expect("triangles with an area");
            let scale = (x - 3.0).abs().max((y + 1.0).abs());
            let excess = scale * scale - 1.0;
            assert!(excess > 0.0 && excess < SHELL_ENDS[SHELLS - 1], "{excess}");
            counts[SHELL_ENDS.iter().filter(|&&end| end < excess).count()] += 1;
        }
        let each = (SIDE * SIDE / SHELLS) as f32;
        assert!(counts.iter().all(|&count| (count as f32 / each - 1.0).abs() < 1e-3), "{counts:?}");
    }

    #[test]
    fn the_density_of_the_rim_sums_to_one() {
        let sum: f32 = (0..SHELLS)
            .map(shell)
            .map(|[start, end]| {
                let middle = (1.0 + (start + end) / 2.0).sqrt();
                relative_density(middle) * (end - start)
            })
            .sum();
        assert!((sum - 1.0).abs() < 1e-6, "{sum}");
        assert_eq!(relative_density((1.0 + SHELL_ENDS[SHELLS - 1]).sqrt() * 1.001), 0.0);
    }
}
