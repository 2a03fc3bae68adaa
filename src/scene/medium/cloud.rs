//! A cloud of noise.

use glam::Vec3;

use crate::texture::noise;

/// Density of a cloud: octaves of noise whose places another noise shifts, thinner with height
/// (pbrt-v4's medium `cloud`).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CloudPattern {
    /// Factor of the density.
    pub density: f32,
    /// Strength of the shifts.
    pub wispiness: f32,
    /// Frequency of the first octave, over unit length.
    pub frequency: f32,
    /// Point of medium space at the origin of the unit cube.
    pub low: Vec3,
    /// Extent of the unit cube in medium space.
    pub size: Vec3,
}

/// Ratio of the frequencies of successive octaves.
const LACUNARITY: f32 = 1.99;
/// Step of the differences that approximate the slope of the noise.
const STEP: f32 = 0.01;

impl CloudPattern {
    /// Returns the density at a point of the unit cube, 0 to 1.
    pub(super) fn density(&self, unit: Vec3) -> f32 {
        let at = self.low + self.size * unit;
        let mut shifted = self.frequency * at;
        if self.wispiness > 0.0 {
            let (mut amplitude, mut frequency) = (0.05 * self.wispiness, 10.0);
            for _ in 0..2 {
                shifted += amplitude * slope(frequency * shifted);
                amplitude *= 0.5;
                frequency *= LACUNARITY;
            }
        }
        let (mut sum, mut amplitude, mut frequency) = (0.0, 0.5, 1.0);
        for _ in 0..5 {
            sum += amplitude * noise(frequency * shifted);
            amplitude *= 0.5;
            frequency *= LACUNARITY;
        }
        let thinned = ((1.0 - at.y) * 4.5 * self.density * sum).clamp(0.0, 1.0);
        (thinned + 2.0 * (0.5 - at.y).max(0.0)).clamp(0.0, 1.0)
    }
}

/// Returns the slope of the noise at a point, by forward differences.
fn slope(at: Vec3) -> Vec3 {
    let here = noise(at);
    let along = |axis: Vec3| (noise(at + STEP * axis) - here) / STEP;
    Vec3::new(along(Vec3::X), along(Vec3::Y), along(Vec3::Z))
}
