//! Suitability of a camera model for a lens.

use super::fit::{FitPoint, FitSymmetry, Residual, fit, residual};
use super::model::{CameraMatrix, DistortionModel};

/// Largest angle to the axis at which a pinhole model is of use (degrees).
const PINHOLE_LIMIT: f64 = 82.0;

/// A camera model that describes a lens.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedModel {
    /// The model.
    pub model: DistortionModel,
    /// Its camera matrix.
    pub matrix: CameraMatrix,
    /// Its coefficients, in the order of [`DistortionModel::coefficient_names`].
    pub coefficients: Vec<f64>,
    /// Its error in the plane in focus.
    pub residual: Residual,
    /// Its error at other distances (mm from the film plane): a real lens has no single centre of
    /// projection.
    pub elsewhere: Vec<(f64, Residual)>,
}

/// Why a camera model does not describe a lens.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum Misfit {
    /// The field is too wide for a pinhole.
    #[error("the field reaches {angle:.1} degrees from the axis; a pinhole model ends before 90")]
    Wide {
        /// Largest angle to the axis (degrees).
        angle: f64,
    },
    /// The best polynomial maps two directions to one pixel.
    #[error("its best polynomial folds inside the picture")]
    Folds,
    /// The errors are too large.
    #[error("its largest error is {max:.1} pixels")]
    Coarse {
        /// Largest error (pixels).
        max: f64,
    },
}

/// Fits a model to points in the plane in focus. `others` are the points of other planes, for
/// residuals alone. `tolerance` is the largest error of a model that describes a lens (pixels).
pub(super) fn fit_model(
    model: DistortionModel,
    points: &[FitPoint],
    symmetry: FitSymmetry,
    others: &[(f64, Vec<FitPoint>)],
    tolerance: f64,
) -> Result<FittedModel, Misfit> {
    let angle =
        |point: &FitPoint| point.direction.x.hypot(point.direction.y).atan2(point.direction.z);
    let largest = points.iter().map(angle).fold(0.0, f64::max);
    if model.is_pinhole() && largest.to_degrees() > PINHOLE_LIMIT {
        return Err(Misfit::Wide { angle: largest.to_degrees() });
    }
    let (matrix, coefficients) = fit(model, points, symmetry).ok_or(Misfit::Folds)?;
    if !model.is_monotonic(&coefficients, largest) {
        return Err(Misfit::Folds);
    }
    let found = |points: &[FitPoint]| residual(model, &matrix, &coefficients, points);
    let residual = found(points).ok_or(Misfit::Folds)?;
    if residual.max.is_nan() || residual.max > tolerance {
        return Err(Misfit::Coarse { max: residual.max });
    }
    let elsewhere =
        others.iter().filter_map(|(distance, points)| Some((*distance, found(points)?))).collect();
    Ok(FittedModel { model, matrix, coefficients, residual, elsewhere })
}

impl FittedModel {
    /// Returns the pixel that shows a direction from the centre of projection (x to the right, y
    /// down, z towards the scene); `None` if the model has none.
    pub fn project(&self, direction: glam::DVec3) -> Option<[f64; 2]> {
        self.model.distort(&self.coefficients, direction).map(|point| self.matrix.pixel(point))
    }

    /// Returns the coefficient of this name; 0 if the model has none.
    pub fn coefficient(&self, name: &str) -> f64 {
        let names = self.model.coefficient_names();
        names.iter().position(|found| *found == name).map_or(0.0, |i| self.coefficients[i])
    }
}
