//! Ellipses in the plane of the rear vertex.

use super::outline::PupilBox;

/// An axis-parallel ellipse in the plane of the rear vertex, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ellipse {
    /// Its centre.
    pub centre: [f32; 2],
    /// Semi-axes along u and v.
    pub half: [f32; 2],
}

impl Ellipse {
    /// Returns its area, mm^2.
    pub fn area(&self) -> f32 {
        std::f32::consts::PI * self.half[0] * self.half[1]
    }

    /// Returns the density of points that are drawn uniformly from it, mm^-2; 0 outside. Rounding
    /// leaves points on its edge inside.
    pub(super) fn density(&self, point: [f32; 2]) -> f32 {
        let [x, y] = [0, 1].map(|i| (point[i] - self.centre[i]) / self.half[i]);
        if x * x + y * y <= 1.0 + 1e-5 { 1.0 / self.area() } else { 0.0 }
    }

    /// Returns the point at a place in the unit disk.
    pub(super) fn at(&self, disk: [f32; 2]) -> [f32; 2] {
        [0, 1].map(|i| self.half[i] * disk[i] + self.centre[i])
    }

    pub(crate) fn scaled(self, by: f32) -> Self {
        Self { half: self.half.map(|half| half * by), ..self }
    }

    /// Returns an ellipse around points with the aspect ratio of their bounding box.
    pub(super) fn proportional(points: &[[f64; 2]]) -> Self {
        let pupil_box = PupilBox::around(points);
        let (middle, half) =
            (pupil_box.centre(), pupil_box.size().map(|size| (size / 2.0).max(1e-12)));
        let reach = points.iter().fold(0.0, |reach: f64, point| {
            reach.max((0..2).map(|i| ((point[i] - middle[i]) / half[i]).powi(2)).sum())
        });
        Self {
            centre: middle.map(|v| v as f32),
            half: half.map(|half| rounded_up(half * reach.sqrt())),
        }
    }

    /// Returns a small axis-parallel ellipse around points that are symmetric in v; its centre is
    /// on the u axis.
    pub(super) fn symmetric(points: &[[f64; 2]]) -> Self {
        let pupil_box = PupilBox::around(points);
        let centre = pupil_box.centre()[0];
        let half_width = (pupil_box.size()[0] / 2.0).max(1e-12);
        let half_height = |a: f64| {
            points.iter().fold(0.0, |b: f64, &[u, v]| {
                let x = (u - centre) / a;
                if v <= 0.0 { b } else { b.max(v / (1.0 - x * x).max(0.0).sqrt()) }
            })
        };
        let candidates = (0..=30).map(|step| half_width * (1.0 + 0.02 * f64::from(step)));
        let [a, b] =
            candidates.map(|a| [a, half_height(a)]).fold([f64::INFINITY; 2], |best, new| {
                if new[0] * new[1] < best[0] * best[1] { new } else { best }
            });
        Self { centre: [centre as f32, 0.0], half: [a, b].map(rounded_up) }
    }
}

/// Rounds a half width up to f32, to more than 0.
fn rounded_up(half: f64) -> f32 {
    (half * 1.000_001).max(1e-9) as f32
}
