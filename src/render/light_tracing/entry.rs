//! Entry of light paths into the lens: points of a square about its front vertex, and their densities.

use std::f64::consts::PI;

use glam::DVec3;

use petzval_base::distribution::Distribution;
use petzval_base::sampler::concentric_disk;
use petzval_lens::{Paraxial, RealLens};

/// Share of the entry points that are uniform over the square, so that every path can be sampled.
const UNIFORM: f64 = 0.125;
/// Radius of the disk, relative to that of the paraxial entrance pupil.
const WIDER: f64 = 1.1;
/// Largest ratio of the distances of a point from the entrance pupil and from the front vertex.
const LARGEST_RATIO: f64 = 5.0;

/// Square about the front vertex in which light paths enter the lens.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EntrySquare {
    /// Half of its side (mm).
    pub half: f64,
}

impl EntrySquare {
    /// Returns the place (mm) of a point of the square (0 to 1).
    pub fn place(self, point: [f64; 2]) -> [f64; 2] {
        point.map(|u| (2.0 * u - 1.0) * self.half)
    }

    /// Returns the point of the square (0 to 1) at a place (mm); `None` if it is outside.
    pub fn point(self, place: [f64; 2]) -> Option<[f32; 2]> {
        let point = place.map(|v| (v / self.half + 1.0) / 2.0);
        point.iter().all(|u| (0.0..1.0).contains(u)).then(|| point.map(|u| u as f32))
    }

    /// Returns its area (mm^2).
    pub fn area(self) -> f64 {
        4.0 * self.half * self.half
    }
}

/// Grid of cells over the square of entry points.
#[derive(Clone, Copy, Debug)]
pub(crate) struct EntryGrid {
    /// Number of cells along each side of the square.
    pub side: usize,
}

impl EntryGrid {
    /// Returns the number of cells.
    pub fn cells(self) -> usize {
        self.side * self.side
    }

    /// Returns the cell of a point of the square (0 to 1).
    pub fn cell(self, point: [f32; 2]) -> usize {
        let [x, y] = point.map(|u| ((u * self.side as f32) as usize).min(self.side - 1));
        y * self.side + x
    }

    /// Returns a cell and its neighbours, row by row.
    pub fn around(self, cell: usize) -> impl Iterator<Item = usize> {
        let near = move |i: usize| i.saturating_sub(1)..(i + 2).min(self.side);
        let (x, y) = (cell % self.side, cell / self.side);
        near(y).flat_map(move |y| near(x).map(move |x| y * self.side + x))
    }

    /// Returns the density of entry points over the square that is in proportion to the weight of each
    /// cell; `None` if no weight is above 0.
    pub fn density(self, weight: impl Fn(usize) -> f64) -> Option<Distribution> {
        Distribution::new([self.side; 2], |x, y| weight(y * self.side + x))
    }
}

/// Samples entry points: over the paraxial entrance pupil as the point sees it, and a share over
/// the square about the front vertex.
#[derive(Clone, Debug)]
pub(crate) struct EntrySampler {
    /// Distance of the entrance pupil behind the front vertex (mm).
    behind: f64,
    /// Radius of the disk in its plane (mm).
    radius: f64,
    square: EntrySquare,
}

/// An entry point.
pub(crate) struct EntryPoint {
    /// Place in the plane of the front vertex (mm).
    pub at: [f64; 2],
    /// Density (mm^-2).
    pub density: f64,
}

impl EntrySampler {
    /// Prepares the sampler for a square.
    pub fn new(lens: &RealLens, square: EntrySquare) -> Self {
        let pupil = Paraxial::new(&lens.prescription).entrance_pupil;
        let radius = WIDER * pupil.diameter / 2.0;
        Self { behind: pupil.position, radius, square }
    }

    /// Samples an entry point for a point of the scene: right, up and before the front vertex (mm).
    pub fn sample(&self, from: DVec3, [u, v]: [f32; 2]) -> EntryPoint {
        let Some(ratio) = self.ratio(from.z) else {
            let at = self.square.place([u, v].map(f64::from));
            return EntryPoint { at, density: 1.0 / self.square.area() };
        };
        let at = match f64::from(u) < UNIFORM {
            true => self.square.place([f64::from(u) / UNIFORM, f64::from(v)]),
            false => {
                let u = (f64::from(u) - UNIFORM) / (1.0 - UNIFORM);
                let disk = concentric_disk(u as f32, v);
                let place = |i: usize| f64::from(disk[i]) * self.radius;
                // On the line from the point to the place in the pupil.
                [
                    place(0) / ratio + from.x * (1.0 - 1.0 / ratio),
                    place(1) / ratio + from.y * (1.0 - 1.0 / ratio),
                ]
            }
        };
        EntryPoint { at, density: self.density(from, ratio, at) }
    }

    /// Returns the distance of a point from the entrance pupil over that from the front vertex;
    /// `None` if it is too large or too small to be of use.
    fn ratio(&self, z: f64) -> Option<f64> {
        let ratio = (z + self.behind) / z;
        let usable = (1.0 / LARGEST_RATIO..LARGEST_RATIO).contains(&ratio) && self.radius > 0.0;
        (usable && self.radius.is_finite()).then_some(ratio)
    }

    fn density(&self, from: DVec3, ratio: f64, at: [f64; 2]) -> f64 {
        let in_pupil = |at: f64, from: f64| from + (at - from) * ratio;
        let [x, y] = [in_pupil(at[0], from.x), in_pupil(at[1], from.y)];
        let in_disk = x.hypot(y) <= self.radius;
        let in_square = at.iter().all(|v| v.abs() <= self.square.half);
        let disk = (1.0 - UNIFORM) * ratio * ratio / (PI * self.radius * self.radius);
        let square = UNIFORM / self.square.area();
        f64::from(u8::from(in_disk)) * disk + f64::from(u8::from(in_square)) * square
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_base::sampler::{Dimension, sample_2d};

    #[test]
    fn neighbours_end_at_the_rim_of_the_square() {
        let grid = EntryGrid { side: 4 };
        let around = |cell: usize| grid.around(cell).collect::<Vec<_>>();
        assert_eq!(around(0), [0, 1, 4, 5]);
        assert_eq!(around(grid.cell([0.3, 0.6])), [4, 5, 6, 8, 9, 10, 12, 13, 14]);
        assert_eq!(around(grid.cell([1.0, 1.0])), [10, 11, 14, 15]);
    }

    #[test]
    fn the_density_is_that_of_the_samples() {
        let sampler =
            EntrySampler { behind: 20.0, radius: 8.0, square: EntrySquare { half: 15.0 } };
        let from = DVec3::new(30.0, -10.0, 200.0);
        // Samples over their density measure areas: of the square and of a part of it.
        let (count, mut whole, mut part) = (1 << 20, 0.0, 0.0);
        for i in 0..count {
            let EntryPoint { at, density } = sampler.sample(from, sample_2d(7, i, Dimension::Film));
            if at.iter().all(|v| v.abs() <= 15.0) {
                whole += 1.0 / density;
            }
            if (at[0] - 3.0).hypot(at[1]) < 4.0 {
                part += 1.0 / density;
            }
        }
        let count = f64::from(count);
        assert!((whole / count / 900.0 - 1.0).abs() < 0.004, "{}", whole / count);
        assert!((part / count / (16.0 * PI) - 1.0).abs() < 0.004, "{}", part / count);
    }
}
