//! Analysis of lenses: image quality, calibration, tolerances and optimisation.
//!
//! ```
//! use petzval_optics::{CalibrationSetup, FieldRay, PixelGrid};
//!
//! # std::env::set_current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))?;
//! let lens = petzval_lens_formats::read("lenses/wide.22mm.dat".as_ref())?;
//! let film_distance = petzval_lens::RealRayFocus::new(&lens).film_distance(f64::INFINITY)?;
//! let setup = CalibrationSetup {
//!     lens: &lens,
//!     film_distance,
//!     film_pose: petzval_lens::Pose::ALIGNED,
//!     pixels: PixelGrid::new([600, 400], 36.0),
//!     ray: FieldRay::Centroid,
//! };
//! // The camera model of computer vision that describes the lens best.
//! assert!(setup.calibrate_quickly()?.suggested().is_some());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub(crate) mod calibration;
pub(crate) mod damped_least_squares;
pub(crate) mod film_error;
pub(crate) mod imaging;
pub(crate) mod optimize;
pub(crate) mod tolerance;

pub use calibration::channel::ChannelFields;
pub use calibration::fit::Residual;
pub use calibration::focused_lens::{FocusedLens, FocusedLensError};
pub use calibration::model::{CameraMatrix, DistortionModel};
pub use calibration::pixel_grid::{PixelGrid, SightLine};
pub use calibration::projection_centre::ProjectionCentre;
pub use calibration::radial::{Falloff, LateralColour, RadialDistortion};
pub use calibration::raw_correction::RawCorrection;
pub use calibration::ray_field::{FieldRay, RayField};
pub use calibration::spot::SpotGrid;
pub use calibration::suitability::{FittedModel, Misfit};
pub use calibration::{Calibration, CalibrationError, CalibrationSetup};
pub use damped_least_squares::StopReason;
pub use film_error::{FilmError, film_error};
pub use imaging::aberration_fan::{AberrationFan, AberrationPoint};
pub use imaging::axial::ZoneFocus;
pub use imaging::chief::{ChiefRay, ObjectPoint};
pub use imaging::conditions::{ConditionChoices, ConditionsError, ImagingConditions};
pub use imaging::field_curve::FieldCurvePoint;
pub use imaging::frozen_imaging::{FieldSpot, FrozenImaging, FrozenImagingError, RimPolicy};
pub use imaging::ghost_focus::{GhostFocus, MOST_GHOST_SURFACES};
pub use imaging::image_quality::{FieldRays, ImageQuality, ImagingGrid, in_parallel};
pub use imaging::lens_at_wavelength::SceneRay;
pub use imaging::point_image::PointImage;
pub use imaging::pupil_grid::{PupilCell, PupilGrid};
pub use imaging::reference_sphere::ReferenceSphere;
pub use imaging::seidel::{Seidel, SeidelSums};
pub use imaging::spot::{SpotDiagram, SpotRay, SpotSize};
pub use imaging::transfer::{FrequencyAxis, TransferMethod};
pub use imaging::zernike::{ZernikeFit, noll, zernike};
pub use optimize::design_optimization::{
    DesignGoal, DesignState, OptimizationError, OptimizedDesign, optimize_design,
};
pub use optimize::target::{DesignTarget, TargetKind};
pub use optimize::variable::{DesignVariable, VariableError, VariableKind};
pub use tolerance::distribution::{correlation, percentile};
pub use tolerance::figure::{LensFigures, Refocus};
pub use tolerance::grade::{FRINGE_WAVELENGTH, RadiusLimit, ToleranceGrade, ToleranceLimits};
pub use tolerance::monte_carlo::{
    DeviationShape, ToleranceAnalysis, ToleranceEffect, ToleranceSettings, ToleranceTrial,
};
pub use tolerance::parameter::{ToleranceKind, ToleranceParameter};
