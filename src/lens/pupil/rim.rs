//! Rim of a fan: samples just outside, where the fan may have missed light.
//!
//! A fan that misses a sliver of the pupil would leave it to the few samples of the whole rear
//! element, which weigh as much as the area of that element is large: thousands to millions of
//! times the usual weight. Rim samples are drawn close to the fan instead. Each triangle is chosen
//! equally often, with a uniform position along its outer side, and a scale s about the centre. The
//! excess y = s^2 - 1, by which the area of the scaled triangle exceeds its own, has the density
//!
//! p(y) = 1 / (ln 8192 (y + d))
//!
//! with d = [`RIM_WIDTH`], up to y = 8191 d = 8, that is s = 3. Samples are thus spread evenly over the
//! orders of magnitude of the error of a fan. A scale changes area by dA = A dy, so the density of
//! points is p(y) / (A T) for T triangles of area A.
//!
//! # Limit of the weight
//!
//! The weight of a sample is proportional to the reciprocal of the mixture's density. Compared with
//! a sample inside the same triangle, one outside it weighs at most
//!
//! w(y) = 1 / (q p(y)) = (ln 8192 / q) (y + d)
//!
//! times as much, with q = [`RIM_SHARE`](super::RIM_SHARE): [`rim_weight_limit`] returns it. It is
//! 4.5 at the edge of the fan, 51 where the fan misses a hundredth of its area, and 466 at a tenth.
//! No sample weighs more than one of the rear element, with its share
//! [`REAR_SHARE`](super::REAR_SHARE). Triangles that the [enclosure](super::enclosure) widened are
//! larger than others, and their samples weigh more by as much.

use super::RIM_SHARE;
use super::fan::{Fan, TRIANGLES};

/// Excess of the area at which the density of rim samples is half of that at the fan.
pub const RIM_WIDTH: f32 = 1.0 / 1024.0;
/// Largest excess of rim samples.
const MAX_EXCESS: f32 = 8191.0 * RIM_WIDTH;
/// Binary logarithm of the ratio of the densities at the fan and at the largest excess.
const OCTAVES: f32 = 13.0;

/// Returns the largest weight of a sample outside a fan, relative to the weight inside the same
/// triangle, at an excess y = s^2 - 1 of the area, at most 8 (s is the scale at which the fan
/// reaches the sample).
pub fn rim_weight_limit(excess: f64) -> f64 {
    1.0 / (f64::from(RIM_SHARE) * f64::from(density_of_excess(excess as f32)))
}

/// Returns p(y).
fn density_of_excess(excess: f32) -> f32 {
    1.0 / (OCTAVES * std::f32::consts::LN_2 * (excess + RIM_WIDTH))
}

/// Returns the density of rim samples outside a triangle, relative to that of the fan inside it:
/// p(y), or 0 farther out than they fall.
#[inline(always)]
pub(super) fn relative_density(scale: f32) -> f32 {
    let excess = (scale - 1.0) * (scale + 1.0);
    if excess <= MAX_EXCESS { density_of_excess(excess) } else { 0.0 }
}

impl Fan {
    /// Returns the rim sample of two random numbers, mm; `None` if its triangle has no area.
    pub(super) fn rim_point(&self, [u, v]: [f32; 2]) -> Option<[f32; 2]> {
        let place = u * TRIANGLES as f32;
        let k = (place as usize).min(TRIANGLES - 1);
        let triangle = self.triangle(k);
        if triangle.area2() <= 0.0 {
            return None;
        }
        let along = place - k as f32;
        let excess = RIM_WIDTH * ((OCTAVES * v).exp2() - 1.0);
        let scale = (1.0 + excess).sqrt();
        let [a, b] = triangle.corners;
        Some([0, 1].map(|i| self.centre[i] + scale * (a[i] + along * (b[i] - a[i]))))
    }
}
