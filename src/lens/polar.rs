//! The light of a film by spokes and rings about the axis: of a lens that is nearly round, or of a
//! tilted film behind a round one.
//!
//! On every spoke the light ends elsewhere, and rings grow narrow there, because the pupil closes
//! ever faster. Fans are in the frame of their film point, u away from the axis and v across: what
//! changes little from spoke to spoke.

use super::fan::{Fan, TRIANGLES};
use super::target::{Rows, Target};

/// Directions from the axis.
pub(super) const SPOKES: usize = 24;
/// Rings between the axis and the end of the light.
pub(super) const STEPS: usize = 24;

/// Fans about a point of the film.
#[derive(Clone, Debug)]
pub(super) struct Polar {
    /// Where the axis meets the film, mm from the film's own middle.
    pole: [f32; 2],
    /// By spoke, one over the radius at which the light ends, 1/mm.
    per_end: [f32; SPOKES],
    /// From the pole outwards, spoke after spoke.
    fans: Vec<Fan>,
    rows: Rows,
}

/// A film point among the fans.
struct Spot {
    /// The direction from the pole.
    cos: f32,
    sin: f32,
    /// Which four fans are next to it, and what they count.
    around: [(usize, f32); 4],
}

/// The direction of a spoke, or of a place between two: even in the diamond |x| + |y| = 1, which
/// takes no arc tangent.
pub(super) fn direction(spoke: f64) -> [f64; 2] {
    let along = spoke * 4.0 / SPOKES as f64 - 1.0;
    let [x, y] = match along <= 1.0 {
        true => [1.0 - along.abs(), along],
        false => [(along - 2.0).abs() - 1.0, 2.0 - along],
    };
    let length = x.hypot(y);
    [x / length, y / length]
}

/// The share of the way to the end of the light at which a ring stands.
pub(super) fn share(ring: f64) -> f64 {
    let rest = 1.0 - ring / STEPS as f64;
    1.0 - rest * rest
}

/// Between which spokes a direction lies; the inverse of [`direction`].
fn spoke([x, y]: [f32; 2]) -> f32 {
    let across = x.abs() + y.abs();
    let along = if across > 0.0 { y / across } else { 0.0 };
    let along = if x >= 0.0 { along } else { 2.0 - along };
    (along + 1.0) * (SPOKES as f32 / 4.0)
}

impl Polar {
    /// `fans` go from the pole outwards, spoke after spoke; `ends` are the radii at which the light
    /// ends.
    pub fn new(pole: [f64; 2], ends: &[f64; SPOKES], fans: Vec<Fan>) -> Self {
        Self {
            pole: pole.map(|v| v as f32),
            per_end: ends.map(|end| (1.0 / end) as f32),
            rows: Rows::of(&fans),
            fans,
        }
    }

    /// The place of a fan in the list.
    pub fn place(spoke: usize, ring: usize) -> usize {
        spoke % SPOKES * (STEPS + 1) + ring
    }

    /// Nothing beyond the end of the light.
    #[inline(always)]
    fn spot(&self, film: [f32; 2]) -> Option<Spot> {
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
        let place = STEPS as f32 * (1.0 - rest.sqrt());
        let ring = (place as usize).min(STEPS - 1);
        let t = place - ring as f32;
        let (cos, sin) =
            if radius > 0.0 { (from[0] / radius, from[1] / radius) } else { (1.0, 0.0) };
        let at = Self::place;
        let around = [
            (at(near, ring), (1.0 - s) * (1.0 - t)),
            (at(far, ring), s * (1.0 - t)),
            (at(near, ring + 1), (1.0 - s) * t),
            (at(far, ring + 1), s * t),
        ];
        Some(Spot { cos, sin, around })
    }

    /// The light of a film point, in the frame of the lens.
    pub fn fan(&self, film: [f32; 2]) -> Fan {
        let Some(Spot { cos, sin, around }) = self.spot(film) else { return Fan::EMPTY };
        let fan = Fan::mix(&around.map(|(place, weight)| (&self.fans[place], weight)));
        let turned = |[u, v]: [f32; 2]| [cos * u - sin * v, sin * u + cos * v];
        Fan { centre: turned(fan.centre), corners: fan.corners.map(turned) }
    }

    /// One triangle of it, as a target without the density; of no area where it is dark.
    #[inline(always)]
    pub fn target(&self, film: [f32; 2], triangle: usize) -> Target {
        let mut target = [0.0; 8];
        let Some(Spot { cos, sin, around }) = self.spot(film) else { return target };
        for (place, weight) in around {
            let row = &self.rows.0[place][triangle % TRIANGLES];
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

    /// Whether light may come to any film point of a rectangle, mm.
    pub fn any_open(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        let pole = self.pole.map(f64::from);
        let nearest = |i: usize| (low[i] - pole[i]).max(pole[i] - high[i]).max(0.0);
        let nearest = nearest(0).hypot(nearest(1));
        if nearest == 0.0 {
            return true;
        }
        let corner = |x: f64, y: f64| spoke([(x - pole[0]) as f32, (y - pole[1]) as f32]);
        let first = corner(low[0], low[1]);
        let half = SPOKES as f32 / 2.0;
        // The rectangle is seen from the pole under less than half a turn.
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
    fn a_direction_finds_its_spoke_again() {
        for i in 0..240 {
            let at = f64::from(i) / 10.0;
            let [x, y] = direction(at);
            let found = spoke([x as f32, y as f32]);
            assert!((f64::from(found) - at).abs() < 1e-4, "{at}: {found}");
        }
    }
}
