//! Pupils over the film on spokes and rings about the axis, for a lens that is nearly round or a
//! tilted film behind a round lens.
//!
//! The light ends at a radius of its own on every spoke, and rings are narrow there, because the
//! pupil closes ever faster. Fans are in the frame of their film point, u away from the axis and v
//! across, so that they change little from spoke to spoke.

use super::fan::{Fan, TRIANGLES};
use super::target::{PupilTarget, TriangleRows};

/// Number of directions from the axis.
pub(crate) const SPOKES: usize = 24;
/// Number of rings between the axis and the end of the light.
pub(crate) const POLAR_RINGS: usize = 24;

/// Fans on spokes and rings about a point of the film.
#[derive(Clone, Debug)]
pub(crate) struct PolarGrid {
    /// Intersection of the axis with the film, from the centre of the film (mm).
    pole: [f32; 2],
    /// Reciprocal of the radius at which the light ends, by spoke (1/mm).
    per_end: [f32; SPOKES],
    /// Fans from the pole outwards, spoke after spoke.
    fans: Vec<Fan>,
    rows: TriangleRows,
}

/// Place of a film point among the fans.
struct Interpolation {
    /// Cosine of its direction from the pole.
    cos: f32,
    /// Sine of its direction from the pole.
    sin: f32,
    /// Indices and weights of the four fans around it.
    around: [(usize, f32); 4],
}

/// Returns the unit direction of a spoke number, which may be fractional. Spokes are evenly spaced
/// on the diamond |x| + |y| = 1, so that no arc tangent is needed.
pub(crate) fn direction(spoke: f64) -> [f64; 2] {
    let along = spoke * 4.0 / SPOKES as f64 - 1.0;
    let [x, y] = match along <= 1.0 {
        true => [1.0 - along.abs(), along],
        false => [(along - 2.0).abs() - 1.0, 2.0 - along],
    };
    let length = x.hypot(y);
    [x / length, y / length]
}

/// Returns the radius of a ring over that of the end of the light.
pub(crate) fn ring_fraction(ring: f64) -> f64 {
    let rest = 1.0 - ring / POLAR_RINGS as f64;
    1.0 - rest * rest
}

/// Returns the fractional spoke number of a direction; the inverse of [`direction`].
fn spoke([x, y]: [f32; 2]) -> f32 {
    let across = x.abs() + y.abs();
    let along = if across > 0.0 { y / across } else { 0.0 };
    let along = if x >= 0.0 { along } else { 2.0 - along };
    (along + 1.0) * (SPOKES as f32 / 4.0)
}

impl PolarGrid {
    /// Creates a grid. `fans` go from the pole outwards, spoke after spoke; `ends` are the radii at
    /// which the light ends (mm).
    pub fn new(pole: [f64; 2], ends: &[f64; SPOKES], fans: Vec<Fan>) -> Self {
        Self {
            pole: pole.map(|v| v as f32),
            per_end: ends.map(|end| (1.0 / end) as f32),
            rows: TriangleRows::of(&fans),
            fans,
        }
    }

    /// Returns the index of a fan.
    pub fn index(spoke: usize, ring: usize) -> usize {
        spoke % SPOKES * (POLAR_RINGS + 1) + ring
    }

    /// Returns the place of a film point among the fans; `None` beyond the end of the light.
    #[inline(always)]
    fn interpolation(&self, film: [f32; 2]) -> Option<Interpolation> {
        let from = [film[0] - self.pole[0], film[1] - self.pole[1]];
        let radius = (from[0] * from[0] + from[1] * from[1]).sqrt();
        let along = spoke(from).clamp(0.0, SPOKES as f32);
        let near = (along as usize).min(SPOKES - 1);
        let (far, s) = ((near + 1) % SPOKES, along - near as f32);
        let per_end = self.per_end[near] + s * (self.per_end[far] - self.per_end[near]);
        let rest = 1.0 - radius * per_end;
        if rest < 0.0 {
            return None;
        }
        let position = POLAR_RINGS as f32 * (1.0 - rest.sqrt());
        let ring = (position as usize).min(POLAR_RINGS - 1);
        let t = position - ring as f32;
        let (cos, sin) =
            if radius > 0.0 { (from[0] / radius, from[1] / radius) } else { (1.0, 0.0) };
        let at = Self::index;
        let around = [
            (at(near, ring), (1.0 - s) * (1.0 - t)),
            (at(far, ring), s * (1.0 - t)),
            (at(near, ring + 1), (1.0 - s) * t),
            (at(far, ring + 1), s * t),
        ];
        Some(Interpolation { cos, sin, around })
    }

    /// Returns the fans at the corners of a cell.
    pub fn around(&self, spoke: usize, ring: usize) -> impl Iterator<Item = &Fan> + Clone {
        let corners = [(0, 0), (1, 0), (0, 1), (1, 1)].into_iter();
        corners.map(move |(i, j)| &self.fans[Self::index(spoke + i, ring + j)])
    }

    /// Returns the cell of a film point, spoke after spoke, and its direction from the pole; `None`
    /// beyond the end of the light.
    pub fn cell(&self, film: [f32; 2]) -> Option<(usize, [f32; 2])> {
        let Interpolation { cos, sin, around } = self.interpolation(film)?;
        let (spoke, ring) = (around[0].0 / (POLAR_RINGS + 1), around[0].0 % (POLAR_RINGS + 1));
        Some((spoke * POLAR_RINGS + ring, [cos, sin]))
    }

    /// Returns the pupil of a film point, in the frame of the lens.
    pub fn fan(&self, film: [f32; 2]) -> Fan {
        let Some(Interpolation { cos, sin, around }) = self.interpolation(film) else {
            return Fan::EMPTY;
        };
        Fan::mix(&around.map(|(i, weight)| (&self.fans[i], weight))).turned(cos, sin)
    }

    /// Returns one triangle of that pupil, as a target without the density; of no area if the film
    /// point is dark.
    #[inline(always)]
    pub fn target(&self, film: [f32; 2], triangle: usize) -> PupilTarget {
        let mut target = [0.0; 8];
        let Some(Interpolation { cos, sin, around }) = self.interpolation(film) else {
            return target;
        };
        for (i, weight) in around {
            let row = &self.rows.0[i][triangle % TRIANGLES];
            for k in 0..8 {
                target[k] += weight * row[k];
            }
        }
        for k in [0, 2, 4] {
            let (u, v) = (target[k], target[k + 1]);
            (target[k], target[k + 1]) = (cos * u - sin * v, sin * u + cos * v);
        }
        target
    }

    /// Returns whether light may reach any film point of a rectangle (mm).
    pub fn any_light(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        let pole = self.pole.map(f64::from);
        let nearest = |i: usize| (low[i] - pole[i]).max(pole[i] - high[i]).max(0.0);
        let nearest = nearest(0).hypot(nearest(1));
        if nearest == 0.0 {
            return true;
        }
        let corner = |x: f64, y: f64| spoke([(x - pole[0]) as f32, (y - pole[1]) as f32]);
        let first = corner(low[0], low[1]);
        let half = SPOKES as f32 / 2.0;
        // The rectangle subtends less than half a turn at the pole.
        let from_first = |at: f32| (at - first + half).rem_euclid(2.0 * half) - half;
        let corners = [corner(high[0], low[1]), corner(low[0], high[1]), corner(high[0], high[1])];
        let spans = corners.map(from_first);
        let least = (first + spans.iter().fold(0.0f32, |a, &b| a.min(b))).floor() as i32;
        let most = (first + spans.iter().fold(0.0f32, |a, &b| a.max(b))).ceil() as i32;
        (least..=most).any(|k| {
            let per_end = self.per_end[k.rem_euclid(SPOKES as i32) as usize];
            nearest * f64::from(per_end) <= 1.0 + 1e-6
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spoke_of_a_direction_inverts_the_direction_of_a_spoke() {
        for i in 0..240 {
            let at = f64::from(i) / 10.0;
            let [x, y] = direction(at);
            let found = spoke([x as f32, y as f32]);
            assert!((f64::from(found) - at).abs() < 1e-4, "{at}: {found}");
        }
    }
}
