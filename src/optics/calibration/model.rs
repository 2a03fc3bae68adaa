//! Camera models of computer vision: from a direction to a pixel.

use glam::DVec3;

/// A model of lens distortion, in the definition of OpenCV's documentation (calib3d).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum DistortionModel {
    /// k1 k2 p1 p2: Brown-Conrady with two radial terms, called radtan by Kalibr and OPENCV by
    /// COLMAP.
    RadTan,
    /// k1 k2 p1 p2 k3: Brown-Conrady (Brown 1966, "Decentering distortion of lenses").
    BrownConrady,
    /// k1 k2 p1 p2 k3 k4 k5 k6: the quotient of two polynomials, FULL_OPENCV of COLMAP.
    Rational,
    /// The rational model with s1 s2 s3 s4: a thin prism (Weng, Cohen & Herniou 1992).
    ThinPrism,
    /// k1 k2 k3 k4: an odd polynomial of the angle to the axis (Kannala & Brandt 2006), the fisheye
    /// model of OpenCV.
    KannalaBrandt,
}

/// Camera matrix K (pixels); the skew is 0.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CameraMatrix {
    /// Focal lengths along x and y.
    pub focal: [f64; 2],
    /// Principal point; the centre of the first pixel is (0, 0).
    pub centre: [f64; 2],
}

impl CameraMatrix {
    /// Returns the rows of the matrix.
    pub fn rows(&self) -> [[f64; 3]; 3] {
        let Self { focal: [fx, fy], centre: [cx, cy] } = *self;
        [[fx, 0.0, cx], [0.0, fy, cy], [0.0, 0.0, 1.0]]
    }

    /// Returns the pixel of a point of the plane z = 1.
    pub fn pixel(&self, [x, y]: [f64; 2]) -> [f64; 2] {
        [self.focal[0] * x + self.centre[0], self.focal[1] * y + self.centre[1]]
    }

    /// Returns the pixel that shows a direction without distortion; `None` if it is not before the
    /// camera.
    pub fn pinhole(&self, direction: DVec3) -> Option<[f64; 2]> {
        let DVec3 { x, y, z } = direction;
        (z > 0.0).then(|| self.pixel([x / z, y / z]))
    }
}

impl DistortionModel {
    /// All models, from the fewest coefficients.
    pub const ALL: [Self; 5] =
        [Self::RadTan, Self::BrownConrady, Self::KannalaBrandt, Self::Rational, Self::ThinPrism];

    /// Returns a short name, for tables and files.
    pub fn name(self) -> &'static str {
        match self {
            Self::RadTan => "radtan",
            Self::BrownConrady => "brown-conrady",
            Self::Rational => "rational",
            Self::ThinPrism => "thin-prism",
            Self::KannalaBrandt => "kannala-brandt",
        }
    }

    /// Returns the names of the coefficients, in the order of OpenCV.
    pub fn coefficient_names(self) -> &'static [&'static str] {
        const PINHOLE: [&str; 12] =
            ["k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6", "s1", "s2", "s3", "s4"];
        match self {
            Self::RadTan => &PINHOLE[..4],
            Self::BrownConrady => &PINHOLE[..5],
            Self::Rational => &PINHOLE[..8],
            Self::ThinPrism => &PINHOLE,
            Self::KannalaBrandt => &["k1", "k2", "k3", "k4"],
        }
    }

    /// Returns whether the model is a pinhole with distortion, for less than 90 degrees from the
    /// axis.
    pub fn is_pinhole(self) -> bool {
        self != Self::KannalaBrandt
    }

    /// Returns the indices of the coefficients that a rotationally symmetric lens has.
    pub(super) fn radial_coefficients(self) -> &'static [usize] {
        match self {
            Self::RadTan => &[0, 1],
            Self::BrownConrady => &[0, 1, 4],
            Self::Rational | Self::ThinPrism => &[0, 1, 4, 5, 6, 7],
            Self::KannalaBrandt => &[0, 1, 2, 3],
        }
    }

    /// Returns the power of the radius (or of the angle) with which a coefficient acts, relative to
    /// the undistorted position.
    pub(super) fn power(self, coefficient: usize) -> i32 {
        match self {
            Self::KannalaBrandt => 2 * (coefficient as i32 + 1),
            _ => [2, 4, 1, 1, 6, 2, 4, 6, 1, 3, 1, 3][coefficient],
        }
    }

    /// Returns the point of the plane z = 1 to which a direction is imaged, before the camera
    /// matrix; `None` if the model has none.
    pub fn distort(self, coefficients: &[f64], direction: DVec3) -> Option<[f64; 2]> {
        let DVec3 { x, y, z } = direction;
        if self == Self::KannalaBrandt {
            let across = x.hypot(y);
            let angle = across.atan2(z);
            let t2 = angle * angle;
            let factor = coefficients.iter().rev().fold(0.0, |sum, k| (sum + k) * t2) + 1.0;
            let scale = if across > 0.0 { angle * factor / across } else { 1.0 / z };
            return Some([x * scale, y * scale]);
        }
        if z <= 0.0 {
            return None;
        }
        let (x, y) = (x / z, y / z);
        let r2 = x * x + y * y;
        let k = |i: usize| coefficients.get(i).copied().unwrap_or(0.0);
        let above = 1.0 + r2 * (k(0) + r2 * (k(1) + r2 * k(4)));
        let below = 1.0 + r2 * (k(5) + r2 * (k(6) + r2 * k(7)));
        if below <= 0.0 {
            return None;
        }
        let (radial, [p1, p2]) = (above / below, [k(2), k(3)]);
        Some([
            x * radial + 2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + r2 * (k(8) + r2 * k(9)),
            y * radial + p1 * (r2 + 2.0 * y * y) + 2.0 * p2 * x * y + r2 * (k(10) + r2 * k(11)),
        ])
    }

    /// Returns whether pictures of directions up to an angle from the axis (radians) do not fold:
    /// the image moves outwards as the angle grows.
    pub(super) fn is_monotonic(self, coefficients: &[f64], largest: f64) -> bool {
        let steps = 256;
        let mut before = 0.0;
        (1..=steps).all(|i| {
            let (sin, cos) = (largest * f64::from(i) / f64::from(steps)).sin_cos();
            let radial: Vec<f64> = (0..coefficients.len())
                .map(|k| match self.radial_coefficients().contains(&k) {
                    true => coefficients[k],
                    false => 0.0,
                })
                .collect();
            match self.distort(&radial, DVec3::new(sin, 0.0, cos)) {
                Some([x, _]) if x > before => {
                    before = x;
                    true
                }
                _ => false,
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_pinhole_models_agree_with_the_formula_of_opencv() {
        let k = [-0.1, 0.02, 1e-3, -2e-3, 3e-3, 0.05, -0.01, 2e-3, 1e-4, -2e-4, 3e-4, 4e-4];
        let (x, y) = (0.3f64, -0.2f64);
        let r2 = x * x + y * y;
        let radial = (1.0 + k[0] * r2 + k[1] * r2.powi(2) + k[4] * r2.powi(3))
            / (1.0 + k[5] * r2 + k[6] * r2.powi(2) + k[7] * r2.powi(3));
        let expected = [
            x * radial
                + 2.0 * k[2] * x * y
                + k[3] * (r2 + 2.0 * x * x)
                + k[8] * r2
                + k[9] * r2 * r2,
            y * radial
                + k[2] * (r2 + 2.0 * y * y)
                + 2.0 * k[3] * x * y
                + k[10] * r2
                + k[11] * r2 * r2,
        ];
        let direction = DVec3::new(x, y, 1.0).normalize();
        let found = DistortionModel::ThinPrism.distort(&k, direction).unwrap();
        assert!((found[0] - expected[0]).abs() < 1e-14 && (found[1] - expected[1]).abs() < 1e-14);
    }

    #[test]
    fn the_fisheye_model_images_more_than_a_half_space() {
        let k = [0.01, -0.002, 3e-4, 1e-5];
        let angle = 1.7f64;
        let (sin, cos) = angle.sin_cos();
        let t = |power: i32| angle.powi(power);
        let expected = t(1) + k[0] * t(3) + k[1] * t(5) + k[2] * t(7) + k[3] * t(9);
        let found = DistortionModel::KannalaBrandt.distort(&k, DVec3::new(0.0, sin, cos)).unwrap();
        assert!(found[0].abs() < 1e-14 && (found[1] - expected).abs() < 1e-13, "{found:?}");
        assert!(DistortionModel::Rational.distort(&[0.0; 8], DVec3::new(0.0, sin, cos)).is_none());
    }

    #[test]
    fn a_model_that_turns_back_is_seen_to_fold() {
        assert!(DistortionModel::BrownConrady.is_monotonic(&[-0.2, 0.0, 0.0, 0.0, 0.0], 0.8));
        assert!(!DistortionModel::BrownConrady.is_monotonic(&[-0.6, 0.0, 0.0, 0.0, 0.0], 0.8));
    }
}
