//! Entry points of light paths in the plane of the front vertex, for a point of the scene.

use std::f64::consts::PI;

use glam::DVec3;

use crate::lens::{Paraxial, RealLens};
use crate::sampler::concentric_disk;

/// Share of the entry points that are uniform over the square, so that every path can be sampled.
const UNIFORM: f64 = 0.125;
/// Radius of the disk, relative to that of the paraxial entrance pupil.
const WIDER: f64 = 1.1;
/// Largest ratio of the distances of a point from the entrance pupil and from the front vertex.
const LARGEST_RATIO: f64 = 5.0;

/// Samples entry points: over the paraxial entrance pupil as the point sees it, and a share over
/// the square about the front vertex.
#[derive(Clone, Debug)]
pub(super) struct EntrySampler {
    /// Distance of the entrance pupil behind the front vertex (mm).
    behind: f64,
    /// Radius of the disk in its plane (mm).
    radius: f64,
    /// Half side of the square (mm).
    half: f64,
}

/// An entry point.
pub(super) struct EntryPoint {
    /// Place in the plane of the front vertex (mm).
    pub at: [f64; 2],
    /// Density (mm^-2).
    pub density: f64,
}

impl EntrySampler {
    /// Prepares the sampler for a square of this half side (mm).
    pub fn new(lens: &RealLens, half: f64) -> Self {
        let pupil = Paraxial::new(&lens.prescription).entrance_pupil;
        let radius = WIDER * pupil.diameter / 2.0;
        Self { behind: pupil.position, radius, half }
    }

    /// Samples an entry point for a point of the scene: right, up and before the front vertex (mm).
    pub fn sample(&self, from: DVec3, [u, v]: [f32; 2]) -> EntryPoint {
        let square = |u: f64, v: f64| [u, v].map(|u| (2.0 * u - 1.0) * self.half);
        let Some(ratio) = self.ratio(from.z) else {
            let at = square(f64::from(u), f64::from(v));
            return EntryPoint { at, density: 1.0 / (4.0 * self.half * self.half) };
        };
        let at = match f64::from(u) < UNIFORM {
            true => square(f64::from(u) / UNIFORM, f64::from(v)),
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
        let in_square = at.iter().all(|v| v.abs() <= self.half);
        let disk = (1.0 - UNIFORM) * ratio * ratio / (PI * self.radius * self.radius);
        let square = UNIFORM / (4.0 * self.half * self.half);
        f64::from(u8::from(in_disk)) * disk + f64::from(u8::from(in_square)) * square
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampler::{Dimension, sample_2d};

    #[test]
    fn the_density_is_that_of_the_samples() {
        let sampler = EntrySampler { behind: 20.0, radius: 8.0, half: 15.0 };
        let from = DVec3::new(30.0, -10.0, 200.0);
        // Samples over their density measure areas: of the square and of a part of it.
        let (count, mut whole, mut part) = (200_000, 0.0, 0.0);
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
        assert!((whole / count / 900.0 - 1.0).abs() < 0.03, "{}", whole / count);
        assert!((part / count / (16.0 * PI) - 1.0).abs() < 0.02, "{}", part / count);
    }
}
