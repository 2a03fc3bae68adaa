//! How far a moving box comes.

use glam::{DAffine3, DMat3, DVec3};

use super::{Motion, Steps, Turn};

/// Bounds on the magnitudes of something that depends on the share, and of its first and second
/// derivative.
type Magnitudes = [f64; 3];

/// Radians from one place of a path that is looked at to the next.
const STEP: f64 = 1.0 / 16.0;
/// Places that are looked at.
const MOST_PLACES: f64 = 4096.0;

impl Motion {
    /// A box around all that a box passes between two shares of its way. It holds everything for
    /// certain, turns included: between two places a path leaves their chord by no more than an
    /// eighth of its second derivative times the square of the step.
    pub fn sweep(&self, [low, high]: [DVec3; 2], [from, to]: [f64; 2]) -> [DVec3; 2] {
        let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        // All points of a box are between the same eight, whatever the transform.
        let corners: [DVec3; 8] = std::array::from_fn(|corner| {
            let pick = |bit: usize| if corner >> bit & 1 == 0 { low } else { high };
            DVec3::new(pick(0).x, pick(1).y, pick(2).z)
        });
        let steps = self.steps(to - from);
        for place in 0..=steps {
            let share = from + (to - from) * f64::from(place) / f64::from(steps);
            let transform = self.at(share);
            for corner in corners {
                let p = transform.transform_point3(corner);
                (least, most) = (least.min(p), most.max(p));
            }
        }
        let step = (to - from) / f64::from(steps);
        let reach = from.abs().max(to.abs());
        let bend = corners.iter().fold(0.0f64, |most, &p| most.max(self.bend(p, reach)));
        let beyond = DVec3::splat(bend * step * step / 8.0);
        [least - beyond, most + beyond]
    }

    fn steps(&self, range: f64) -> u32 {
        let Steps::Moving(turns) = &self.0 else { return 1 };
        let angle: f64 = turns.iter().map(|turn| turn.angle).sum();
        // A lone turn without a rotation goes straight; several may stretch each other.
        let least = if turns.len() > 1 { 16.0 } else { 1.0 };
        (range * angle / STEP).ceil().clamp(least, MOST_PLACES) as u32
    }

    /// A bound on the second derivative of the path of a point, for shares up to `reach` on
    /// either side of 0.
    fn bend(&self, p: DVec3, reach: f64) -> f64 {
        let Steps::Moving(turns) = &self.0 else { return 0.0 };
        let Some((innermost, outer)) = turns.split_last() else { return 0.0 };
        let point = |term: &DAffine3| term.transform_point3(p).length();
        let mut path = innermost.magnitudes(point, reach);
        for turn in outer.iter().rev() {
            let linear = turn.magnitudes(|term| norm(&term.matrix3), reach);
            let place = turn.magnitudes(|term| term.translation.length(), reach);
            // The product rule.
            path = [
                linear[0] * path[0] + place[0],
                linear[1] * path[0] + linear[0] * path[1] + place[1],
                linear[2] * path[0] + 2.0 * linear[1] * path[1] + linear[0] * path[2] + place[2],
            ];
        }
        path[2]
    }
}

impl Turn {
    fn magnitudes(&self, of: impl Fn(&DAffine3) -> f64, reach: f64) -> Magnitudes {
        let [[c0, c1], [a0, a1], [b0, b1]] = self.terms.each_ref().map(|term| {
            let [constant, per_share] = term;
            [of(constant), of(per_share)]
        });
        let swing = (a0 + reach * a1).hypot(b0 + reach * b1);
        let growth = a1.hypot(b1);
        let angle = self.angle;
        [
            c0 + reach * c1 + swing,
            c1 + angle * swing + growth,
            angle * angle * swing + 2.0 * angle * growth,
        ]
    }
}

/// The Frobenius norm, which no vector grows by more than.
fn norm(m: &DMat3) -> f64 {
    m.to_cols_array().iter().map(|v| v * v).sum::<f64>().sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Uniform in [-1, 1): a linear congruence (Knuth 1997, 3.3.4, line 26).
    struct Random(u64);

    impl Random {
        fn next(&mut self) -> f64 {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1);
            (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
        }

        fn vector(&mut self, size: f64) -> DVec3 {
            DVec3::new(self.next(), self.next(), self.next()) * size
        }

        fn transform(&mut self) -> DAffine3 {
            let axis = (self.vector(1.0) + 1e-3).normalize();
            let stretch = DVec3::splat(1.5) + self.vector(1.0);
            DAffine3::from_translation(self.vector(5.0))
                * DAffine3::from_axis_angle(axis, 3.2 * self.next())
                * DAffine3::from_scale(stretch)
        }
    }

    #[test]
    fn nothing_leaves_the_box_around_its_path_and_the_box_is_not_wasteful() {
        let mut random = Random(5);
        let mut waste: f64 = 0.0;
        for round in 0..300 {
            let mut motion = || Motion::between([random.transform(), random.transform()]).unwrap();
            let motion = if round % 3 == 0 { motion().then(&motion()) } else { motion() };
            let middle = random.vector(4.0);
            let size = random.vector(1.0).abs();
            let bounds = [middle - size, middle + size];
            let from = random.next();
            let range = [from, from + random.next().abs() + 0.01];
            let [low, high] = motion.sweep(bounds, range);
            let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for i in 0..=2000 {
                let share = range[0] + (range[1] - range[0]) * f64::from(i) / 2000.0;
                for corner in 0..8 {
                    let sign = [0, 1, 2].map(|bit| f64::from(corner >> bit & 1) * 2.0 - 1.0);
                    let p = motion.at(share).transform_point3(middle + size * DVec3::from(sign));
                    (least, most) = (least.min(p), most.max(p));
                }
            }
            let slack = 1e-12 * most.abs().max(least.abs()).max_element();
            assert!((low - slack).cmple(least).all() && (high + slack).cmpge(most).all());
            if round % 3 > 0 {
                waste = waste.max(((high - low) / (most - least)).max_element());
            }
        }
        assert!(waste < 1.1, "{waste}");
    }
}
