//! Least-squares fit of a camera model to directions and their pixels.

use glam::DVec3;

use super::model::{CameraMatrix, DistortionModel};
use crate::damped_least_squares::{Residuals, minimize};

/// Most steps of a fit.
const STEPS: u32 = 60;
/// Step of the derivatives, relative to the scale of a parameter.
const DERIVATIVE: f64 = 1e-6;

/// Error (pixels) that a coefficient counts as, per unit of its effect at the edge of the picture. It
/// keeps those small that the picture hardly determines, such as equal terms of both polynomials of
/// the rational model.
const RIDGE: f64 = 1e-2;

/// A direction, and the pixel that shows it.
#[derive(Clone, Copy, Debug)]
pub(super) struct FitPoint {
    pub direction: DVec3,
    pub pixel: [f64; 2],
}

/// Distances between the pixels of a model and those of the traced rays.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Residual {
    /// The largest (pixels).
    pub max: f64,
    /// The root mean square (pixels).
    pub rms: f64,
}

/// Free parameters of a fit.
#[derive(Clone, Copy, Debug)]
pub(super) enum FitSymmetry {
    /// One focal length and radial coefficients, about a known principal point (pixels).
    Round([f64; 2]),
    /// Everything.
    None {
        /// A first estimate of the principal point (pixels).
        start: [f64; 2],
    },
}

/// Returns the camera matrix and coefficients of a model that fit best; `None` if no direction fits
/// the model.
pub(super) fn fit(
    model: DistortionModel,
    points: &[FitPoint],
    symmetry: FitSymmetry,
) -> Option<(CameraMatrix, Vec<f64>)> {
    let camera = CameraFit::new(model, points, symmetry)?;
    let (at, _) = minimize(&camera, camera.start.clone(), STEPS, |_, _| true)?;
    Some(camera.unpack(&at))
}

/// Returns the distances between the pixels of a model and those of the points; `None` if the model
/// has no pixel for one of them.
pub(super) fn residual(
    model: DistortionModel,
    matrix: &CameraMatrix,
    coefficients: &[f64],
    points: &[FitPoint],
) -> Option<Residual> {
    let (mut max, mut sum) = (0.0f64, 0.0);
    for point in points {
        let [x, y] = matrix.pixel(model.distort(coefficients, point.direction)?);
        let off = (x - point.pixel[0]).hypot(y - point.pixel[1]);
        (max, sum) = (max.max(off), sum + off * off);
    }
    Some(Residual { max, rms: (sum / points.len() as f64).sqrt() })
}

/// The free parameters of a fit: focal lengths, principal point and coefficients, each of the latter
/// scaled by its effect at the edge of the picture.
struct CameraFit<'a> {
    model: DistortionModel,
    points: &'a [FitPoint],
    symmetry: FitSymmetry,
    /// Indices of the free coefficients, and the value of each per unit of its parameter.
    free: Vec<(usize, f64)>,
    start: Vec<f64>,
}

impl<'a> CameraFit<'a> {
    fn new(model: DistortionModel, points: &'a [FitPoint], symmetry: FitSymmetry) -> Option<Self> {
        let extent = |direction: DVec3| {
            let across = direction.x.hypot(direction.y);
            if model.is_pinhole() { across / direction.z } else { across.atan2(direction.z) }
        };
        let reach = points.iter().map(|point| extent(point.direction)).fold(0.0, f64::max);
        let before = points.iter().all(|point| point.direction.z > 0.0);
        if points.is_empty() || (model.is_pinhole() && !before) {
            return None;
        }
        let scaled = |i: usize| (i, reach.powi(-model.power(i)));
        let centre = match symmetry {
            FitSymmetry::Round(centre) | FitSymmetry::None { start: centre } => centre,
        };
        // The focal length that fits the directions near the axis, or all of them.
        let focal = |largest: f64| {
            let (mut across, mut squares) = (0.0, 0.0);
            for point in points.iter().filter(|point| extent(point.direction) <= largest) {
                let off = (point.pixel[0] - centre[0]).hypot(point.pixel[1] - centre[1]);
                let extent = extent(point.direction);
                (across, squares) = (across + off * extent, squares + extent * extent);
            }
            Some(across / squares).filter(|focal| focal.is_finite() && *focal > 0.0)
        };
        let focal = focal(reach / 3.0).or_else(|| focal(reach))?;
        let coefficients = model.coefficient_names().len();
        let (free, mut start): (Vec<_>, _) = match symmetry {
            FitSymmetry::Round(_) => {
                (model.radial_coefficients().iter().copied().map(scaled).collect(), vec![focal])
            }
            FitSymmetry::None { start: [x, y] } => {
                ((0..coefficients).map(scaled).collect(), vec![focal, focal, x, y])
            }
        };
        start.resize(start.len() + free.len(), 0.0);
        Some(Self { model, points, symmetry, free, start })
    }

    fn unpack(&self, at: &[f64]) -> (CameraMatrix, Vec<f64>) {
        let (matrix, rest) = match self.symmetry {
            FitSymmetry::Round(centre) => (CameraMatrix { focal: [at[0]; 2], centre }, &at[1..]),
            FitSymmetry::None { .. } => {
                (CameraMatrix { focal: [at[0], at[1]], centre: [at[2], at[3]] }, &at[4..])
            }
        };
        let mut coefficients = vec![0.0; self.model.coefficient_names().len()];
        for ((i, scale), value) in self.free.iter().zip(rest) {
            coefficients[*i] = value * scale;
        }
        (matrix, coefficients)
    }
}

impl Residuals for CameraFit<'_> {
    /// Returns the differences between model and pixels, x and y of each point, and then the scaled
    /// coefficients as errors of their own.
    fn at(&self, at: &[f64]) -> Option<Vec<f64>> {
        let (matrix, coefficients) = self.unpack(at);
        let mut errors = Vec::with_capacity(2 * self.points.len());
        for point in self.points {
            let found = matrix.pixel(self.model.distort(&coefficients, point.direction)?);
            errors.extend([0, 1].map(|i| found[i] - point.pixel[i]));
        }
        errors.extend(at[at.len() - self.free.len()..].iter().map(|value| RIDGE * value));
        errors.iter().all(|error| error.is_finite()).then_some(errors)
    }

    fn derivatives(&self, at: &[f64], _: &[f64]) -> Option<Vec<Vec<f64>>> {
        let column = |i: usize| {
            let step = DERIVATIVE * at[i].abs().max(1.0);
            let moved = |by: f64| {
                let mut moved = at.to_vec();
                moved[i] += by;
                self.at(&moved)
            };
            let (below, above) = (moved(-step)?, moved(step)?);
            Some(below.iter().zip(above).map(|(a, b)| (b - a) / (2.0 * step)).collect())
        };
        (0..at.len()).map(column).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points(model: DistortionModel, matrix: CameraMatrix, k: &[f64]) -> Vec<FitPoint> {
        let place = |i: i32, j: i32| DVec3::new(f64::from(i) * 0.04, f64::from(j) * 0.04, 1.0);
        let all = (-10..=10).flat_map(|j| (-14..=14).map(move |i| place(i, j)));
        all.map(|direction| FitPoint {
            direction: direction.normalize(),
            pixel: matrix.pixel(model.distort(k, direction).unwrap()),
        })
        .collect()
    }

    #[test]
    fn each_model_is_recovered_from_its_own_pixels() {
        let matrix = CameraMatrix { focal: [900.0, 910.0], centre: [640.0, 355.0] };
        let all = [-0.12, 0.03, 4e-4, -3e-4, 2e-3, 0.02, 1e-3, -1e-3, 2e-4, 1e-4, -1e-4, 3e-4];
        let fisheye = [0.02, -0.004, 1e-3, -2e-4];
        for model in DistortionModel::ALL {
            let count = model.coefficient_names().len();
            let k = if model.is_pinhole() { &all[..count] } else { &fisheye[..] };
            let points = points(model, matrix, k);
            let start = FitSymmetry::None { start: [639.5, 359.5] };
            let (found, coefficients) = fit(model, &points, start).unwrap();
            let residual = residual(model, &found, &coefficients, &points).unwrap();
            assert!(residual.max < 1e-3, "{model:?}: {residual:?}");
            assert!((found.focal[0] - 900.0).abs() < 1e-2, "{model:?}: {found:?}");
            assert!((found.centre[1] - 355.0).abs() < 1e-2, "{model:?}: {found:?}");
        }
    }

    #[test]
    fn a_round_lens_keeps_its_principal_point_and_has_no_tangential_terms() {
        let matrix = CameraMatrix { focal: [800.0; 2], centre: [320.0, 240.0] };
        let points = points(DistortionModel::BrownConrady, matrix, &[0.1, -0.02, 0.0, 0.0, 0.01]);
        let round = FitSymmetry::Round([320.0, 240.0]);
        let (found, k) = fit(DistortionModel::BrownConrady, &points, round).unwrap();
        assert_eq!((found.centre, k[2], k[3]), ([320.0, 240.0], 0.0, 0.0));
        assert!((found.focal[0] - 800.0).abs() < 1e-3 && (k[0] - 0.1).abs() < 1e-4, "{k:?}");
    }

    #[test]
    fn every_pixel_moves_with_the_principal_point() {
        let model = DistortionModel::BrownConrady;
        let matrix = CameraMatrix { focal: [800.0; 2], centre: [320.0, 240.0] };
        let points = points(model, matrix, &[0.1, -0.02, 0.0, 0.0, 0.01]);
        let symmetry = FitSymmetry::None { start: [300.0, 250.0] };
        let camera = CameraFit::new(model, &points, symmetry).unwrap();
        let columns = camera.derivatives(&camera.start, &[]).unwrap();
        for (axis, column) in columns[2..4].iter().enumerate() {
            for (i, slope) in column[..2 * points.len()].iter().enumerate() {
                let expected = if i % 2 == axis { 1.0 } else { 0.0 };
                assert!((slope - expected).abs() < 1e-6, "{i}: {slope}");
            }
        }
    }

    #[test]
    fn a_pinhole_model_does_not_fit_directions_behind_the_camera() {
        let behind = FitPoint { direction: DVec3::new(1.0, 0.0, -0.1), pixel: [900.0, 200.0] };
        let round = FitSymmetry::Round([320.0, 240.0]);
        assert!(fit(DistortionModel::BrownConrady, &[behind], round).is_none());
    }
}
