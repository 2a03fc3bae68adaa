//! Lens: prescription, ray trace, pupil, camera and analysis.
//!
//! Public lengths are in millimetres. Inside the trace, +z is the direction of travel, and
//! positions are relative to the vertex of the surface last crossed.

pub(crate) mod analysis;
pub(crate) mod camera;
mod least_squares;
mod plane_newton;
pub(crate) mod prescription;
pub(crate) mod pupil;
pub(crate) mod trace;

pub use crate::spectrum::glass::{
    C_LINE, CatalogueGlass, D_LINE, F_LINE, Formula, Glass, GlassError, GlassLibrary, GlassMatch,
    IndexRangeError, find_glass, parse_agf, suggest_glass,
};
pub use analysis::calibration::channel::ChannelFields;
pub use analysis::calibration::fit::Residual;
pub use analysis::calibration::model::{CameraMatrix, DistortionModel};
pub use analysis::calibration::pixel_grid::{PixelGrid, SightLine};
pub use analysis::calibration::projection_centre::ProjectionCentre;
pub use analysis::calibration::radial::{Falloff, LateralColour, RadialDistortion};
pub use analysis::calibration::ray_field::{FieldRay, RayField};
pub use analysis::calibration::spot::SpotGrid;
pub use analysis::calibration::suitability::{FittedModel, Misfit};
pub use analysis::calibration::{Calibration, CalibrationError, CalibrationSetup};
pub use analysis::exit_pupil::raster::PupilRaster;
pub use analysis::exit_pupil::{ExitPupil, PupilEdge};
pub use analysis::film_error::{FilmError, film_error};
pub use analysis::focus::RealRayFocus;
pub use analysis::focus_model::FocusModel;
pub use analysis::imaging::aberration_fan::{AberrationFan, AberrationPoint};
pub use analysis::imaging::axial::ZoneFocus;
pub use analysis::imaging::chief::{ChiefRay, ObjectPoint};
pub use analysis::imaging::conditions::{ConditionChoices, ConditionsError, ImagingConditions};
pub use analysis::imaging::field_curve::FieldCurvePoint;
pub use analysis::imaging::frozen_imaging::{
    FieldSpot, FrozenImaging, FrozenImagingError, RimPolicy,
};
pub use analysis::imaging::ghost_focus::{GhostFocus, MOST_GHOST_SURFACES};
pub use analysis::imaging::image_quality::{FieldRays, ImageQuality, ImagingGrid, in_parallel};
pub use analysis::imaging::lens_at_wavelength::SceneRay;
pub use analysis::imaging::point_image::PointImage;
pub use analysis::imaging::pupil_grid::{PupilCell, PupilGrid};
pub use analysis::imaging::reference_sphere::ReferenceSphere;
pub use analysis::imaging::seidel::{Seidel, SeidelSums};
pub use analysis::imaging::spot::{SpotDiagram, SpotRay, SpotSize};
pub use analysis::imaging::transfer::{FrequencyAxis, TransferMethod};
pub use analysis::imaging::zernike::{ZernikeFit, noll, zernike};
pub use analysis::optimize::damped_least_squares::StopReason;
pub use analysis::optimize::design_optimization::{
    DesignGoal, DesignState, OptimizationError, OptimizedDesign, optimize_design,
};
pub use analysis::optimize::target::{DesignTarget, TargetKind};
pub use analysis::optimize::variable::{DesignVariable, VariableError, VariableKind};
pub use analysis::paraxial::{FocusError, Paraxial, Pupil, RayTransferMatrix};
pub use analysis::stop_diameter::{FNumberError, RoundedFNumber};
pub use analysis::throughput::Throughput;
pub use analysis::tolerance::distribution::{correlation, percentile};
pub use analysis::tolerance::figure::{LensFigures, Refocus};
pub use analysis::tolerance::grade::{
    FRINGE_WAVELENGTH, RadiusLimit, ToleranceGrade, ToleranceLimits,
};
pub use analysis::tolerance::monte_carlo::{
    DeviationShape, ToleranceAnalysis, ToleranceEffect, ToleranceSettings, ToleranceTrial,
};
pub use analysis::tolerance::parameter::{ToleranceKind, ToleranceParameter};
pub use analysis::vignetting::{LightBudget, Normalization, RowLoss, Vignetting};
pub use analysis::wavefront::{Wavefront, WavefrontPoint};
pub use analysis::wavefront_fit::WavefrontFit;
pub use camera::band::Band;
pub use camera::fidelity::Fidelity;
pub(crate) use camera::fidelity::on_axis_irradiance;
pub use camera::orthographic::Orthographic;
pub use camera::ray_path::{RayPath, SurfaceCrossing};
pub use camera::spherical::SphericalMapping;
pub use camera::thin_lens::ThinLens;
pub use camera::{Camera, LensColumns, LensModel, RealLens};
pub use prescription::coating::{
    ASSUMED_COATING, BROADBAND_REFLECTANCE, BareInterface, Coating, CoatingModel,
    DESIGN_WAVELENGTH, MGF2_INDEX, QuarterWaveLayer,
};
pub use prescription::configuration::{Zoom, ZoomError};
pub use prescription::design::{
    Configuration, Design, FieldKind, Fields, Quantity, Setting, SpectralLine,
};
pub use prescription::error::LensError;
pub use prescription::formats::dat::parse as parse_dat;
pub use prescription::formats::mask_file::{read_mask, read_mask_by_pbrt};
pub use prescription::formats::toml::parse as parse_toml;
pub use prescription::formats::write::{WrittenLens, write_lens};
pub use prescription::formats::{read, read_with};
pub use prescription::iris::{ApertureMask, Iris, MaskConvention};
pub use prescription::named_mask::MASK_NAMES;
pub use prescription::options::LensOptions;
pub use prescription::pose::{
    CoordinateBreak, FilmPlane, MAX_DECENTRE, MAX_TILT, Pose, TiltDecenter,
};
pub use prescription::surface_aperture::{ApertureForm, SurfaceAperture};
pub use prescription::{CrossSection, Prescription, Row, Rows, TransverseAxis};
pub use pupil::fan::Fan;
pub use pupil::rim::SHELL_ENDS;
pub use pupil::{Ellipse, PupilBounds, PupilSampling, REAR_SHARE, RIM_SHARE, VICINITY_SHARE};
pub use trace::asphere::Asphere;
pub use trace::biradial::Biradial;
pub use trace::frame_transform::FrameTransform;
pub use trace::kernel::LensRay;
pub use trace::stop::ApertureShape;
pub use trace::{
    BlockReason, Blocked, retrace_in_f64, retrace_in_f64_lossy, trace, trace_ghost, trace_lossy,
    trace_one,
};
pub use trace::{
    sequence::{Side, ghost_sequence, sequence},
    surface::{Surface, SurfaceKind},
};
