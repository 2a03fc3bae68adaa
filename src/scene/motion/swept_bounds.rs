//! Bounds of a moving box.

use glam::{DAffine3, DMat3, DVec3};

use super::{Form, Interpolation, Motion};

/// Upper bounds on the magnitude of a function of time and of its first and second derivative.
type Magnitudes = [f64; 3];

/// Rotation between two samples of a path, radians.
const STEP: f64 = 1.0 / 16.0;
/// Most samples of a path.
const MAX_SAMPLES: f64 = 4096.0;

impl Motion {
    /// Returns a box around a box that moves during a time range.
    ///
    /// The result is conservative, rotation included: between two samples a path deviates from
    /// their chord by at most an eighth of its second derivative times the square of the step.
    pub fn swept_bounds(&self, [low, high]: [DVec3; 2], [from, to]: [f64; 2]) -> [DVec3; 2] {
        let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        // A transformed box is the convex hull of its transformed corners.
        let corners: [DVec3; 8] = std::array::from_fn(|corner| {
            let pick = |bit: usize| if corner >> bit & 1 == 0 { low } else { high };
            DVec3::new(pick(0).x, pick(1).y, pick(2).z)
        });
        let steps = self.steps(to - from);
        for place in 0..=steps {
            let time = from + (to - from) * f64::from(place) / f64::from(steps);
            let transform = self.at(time);
            for corner in corners {
                let p = transform.transform_point3(corner);
                (least, most) = (least.min(p), most.max(p));
            }
        }
        let step = (to - from) / f64::from(steps);
        let reach = from.abs().max(to.abs());
        let bend = corners
            .iter()
            .fold(0.0f64, |most, &p| most.max(self.second_derivative_bound(p, reach)));
        let beyond = DVec3::splat(bend * step * step / 8.0);
        [least - beyond, most + beyond]
    }

    fn steps(&self, range: f64) -> u32 {
        let Form::Moving(parts) = &self.0 else { return 1 };
        let angle: f64 = parts.iter().map(|part| part.angle).sum();
        // A single interpolation without rotation follows a line; the product of several need not.
        let least = if parts.len() > 1 { 16.0 } else { 1.0 };
        (range * angle / STEP).ceil().clamp(least, MAX_SAMPLES) as u32
    }

    /// Returns a bound on the second derivative of the path of a point, for times up to `reach` on
    /// either side of 0.
    fn second_derivative_bound(&self, p: DVec3, reach: f64) -> f64 {
        let Form::Moving(parts) = &self.0 else { return 0.0 };
        let Some((innermost, outer)) = parts.split_last() else { return 0.0 };
        let point = |term: &DAffine3| term.transform_point3(p).length();
        let mut path = innermost.magnitudes(point, reach);
        for part in outer.iter().rev() {
            let linear = part.magnitudes(|term| frobenius_norm(&term.matrix3), reach);
            let place = part.magnitudes(|term| term.translation.length(), reach);
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

impl Interpolation {
    fn magnitudes(&self, of: impl Fn(&DAffine3) -> f64, reach: f64) -> Magnitudes {
        let [[c0, c1], [a0, a1], [b0, b1]] = self.terms.each_ref().map(|term| {
            let [constant, per_time] = term;
            [of(constant), of(per_time)]
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

/// Returns the Frobenius norm, an upper bound on the factor by which a matrix stretches a vector.
fn frobenius_norm(m: &DMat3) -> f64 {
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
    fn swept_bounds_enclose_the_path_tightly() {
        let mut random = Random(5);
        let mut waste: f64 = 0.0;
        for round in 0..300 {
            let mut motion = || Motion::between([random.transform(), random.transform()]).unwrap();
            let motion = if round % 3 == 0 { motion().compose(&motion()) } else { motion() };
            let middle = random.vector(4.0);
            let size = random.vector(1.0).abs();
            let bounds = [middle - size, middle + size];
            let from = random.next();
            let range = [from, from + random.next().abs() + 0.01];
            let [low, high] = motion.swept_bounds(bounds, range);
            let (mut least, mut most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
            for i in 0..=2000 {
                let time = range[0] + (range[1] - range[0]) * f64::from(i) / 2000.0;
                for corner in 0..8 {
                    let sign = [0, 1, 2].map(|bit| f64::from(corner >> bit & 1) * 2.0 - 1.0);
                    let p = motion.at(time).transform_point3(middle + size * DVec3::from(sign));
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
