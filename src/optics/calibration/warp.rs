//! Maps between a photograph and the picture that an ideal pinhole of the same focal length takes.

use glam::DVec3;

use super::Calibration;
use super::model::CameraMatrix;

/// Largest angle to the axis that a pinhole picture shows: its tangent.
const WIDEST: f64 = 6.0;
/// Most steps of the inverse.
const STEPS: usize = 12;
/// Error at which the inverse ends (pixels).
const PRECISION: f64 = 1e-5;

impl Calibration {
    /// Returns the camera matrix of the undistorted picture: that of the suggested model.
    pub fn pinhole_matrix(&self) -> Option<CameraMatrix> {
        self.suggested().map(|fit| fit.matrix)
    }

    /// Returns the point of the undistorted picture (pixels) that shows what a point of the
    /// photograph shows in the plane in focus, by traced rays; `None` if it is dark or too far from
    /// the axis for a pinhole.
    pub fn undistorted(&self, matrix: &CameraMatrix, pixel: [f64; 2]) -> Option<[f64; 2]> {
        let DVec3 { x, y, z } = self.seen(pixel)?;
        (x.hypot(y) < WIDEST * z).then(|| matrix.pixel([x / z, y / z]))
    }

    /// Returns the point of the photograph (pixels) that shows what a point of the undistorted
    /// picture shows: the inverse, by Newton's method from an estimate.
    pub fn distorted(
        &self,
        matrix: &CameraMatrix,
        pixel: [f64; 2],
        estimate: [f64; 2],
    ) -> Option<[f64; 2]> {
        let mut at = estimate;
        for _ in 0..STEPS {
            let here = self.undistorted(matrix, at)?;
            let off = [0, 1].map(|i| pixel[i] - here[i]);
            if off[0].hypot(off[1]) < PRECISION {
                return Some(at);
            }
            // One-sided, towards the middle, where there is light.
            let middle = self.pixels.centre();
            let step = [0, 1].map(|i| if at[i] > middle[i] { -0.5 } else { 0.5 });
            let right = self.undistorted(matrix, [at[0] + step[0], at[1]])?;
            let down = self.undistorted(matrix, [at[0], at[1] + step[1]])?;
            let [a, c] = [0, 1].map(|i| (right[i] - here[i]) / step[0]);
            let [b, d] = [0, 1].map(|i| (down[i] - here[i]) / step[1]);
            let determinant = a * d - b * c;
            at[0] += (d * off[0] - b * off[1]) / determinant;
            at[1] += (a * off[1] - c * off[0]) / determinant;
        }
        None
    }

    /// Returns the pixels of the undistorted picture that hold all of the photograph, first and end
    /// (exclusive), at least those of the photograph, and at most `most` times their number beyond
    /// each edge; and whether that is all.
    pub fn undistorted_window(&self, matrix: &CameraMatrix, most: f64) -> ([[i32; 2]; 2], bool) {
        let size = self.pixels.resolution.map(f64::from);
        let (mut low, mut high) = ([-0.5f64; 2], size.map(|n| n - 0.5));
        let mut complete = true;
        let steps = 64;
        for i in 0..=steps {
            let share = f64::from(i) / f64::from(steps);
            let [x, y] = size.map(|n| share * n - 0.5);
            for point in [[x, -0.5], [x, size[1] - 0.5], [-0.5, y], [size[0] - 0.5, y]] {
                match self.undistorted(matrix, point) {
                    Some(found) => {
                        for axis in 0..2 {
                            low[axis] = low[axis].min(found[axis]);
                            high[axis] = high[axis].max(found[axis]);
                        }
                    }
                    None => complete = false,
                }
            }
        }
        let bound = [0, 1].map(|i| {
            let (first, end) = (-most * size[i], (1.0 + most) * size[i]);
            complete &= low[i] >= first && high[i] <= end;
            let outwards = |v: f64, round: fn(f64) -> f64| round(v) as i32;
            [
                outwards((low[i] + 0.5).max(first), f64::floor),
                outwards((high[i] + 0.5).min(end), f64::ceil),
            ]
        });
        ([[bound[0][0], bound[1][0]], [bound[0][1], bound[1][1]]], complete)
    }
}
