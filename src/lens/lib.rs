//! Real camera lenses: prescription, exact ray trace, pupil, focus and camera.
//!
//! Lengths are in millimetres. Inside the trace, +z is the direction of travel, and positions are
//! relative to the vertex of the surface last crossed. The length of a direction is the refractive index
//! of the medium.
//!
//! ```
//! use petzval_lens::{LensRay, Prescription, RealRayFocus, Row, Side, sequence, trace_one};
//!
//! // A biconvex singlet of BK7 with its stop in front, light from the scene first.
//! let stop = Row { stop: true, diameter: 8.0, thickness: 1.0, ..Row::default() };
//! let front = Row { radius: 50.0, index: 1.5168, thickness: 4.0, diameter: 20.0, ..Row::default() };
//! let back = Row { radius: -50.0, diameter: 20.0, ..Row::default() };
//! let lens = Prescription::new("singlet", vec![stop, front, back])?;
//!
//! let film = RealRayFocus::new(&lens).film_distance(f64::INFINITY)?;
//! let surfaces = sequence::<f64>(&lens, Side::Film(film));
//! let ray = trace_one(LensRay::new([0.0; 3], [0.0, 0.05, (1.0f64 - 0.05 * 0.05).sqrt()]), &surfaces);
//! assert!(ray.is_ok_and(|ray| ray.t[1].abs() < 0.01), "the ray leaves almost parallel to the axis");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The crate `petzval-lens-formats` reads lens files, and `petzval-optics` analyses lenses.
//! [`RealLens`] and [`Camera`] make waves of rays for a renderer, eight lanes at a time.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod camera;
mod film_size;
mod focus;
mod prescription;
mod pupil;
pub mod trace;
mod vignetting;
mod wavefront;

pub use camera::band::Band;
pub use camera::fidelity::{Fidelity, PupilPoint, launched, on_axis_irradiance};
pub use camera::film_map::FilmMap;
pub use camera::orthographic::Orthographic;
pub use camera::ray_path::{RayPath, SurfaceCrossing};
pub use camera::spherical::SphericalMapping;
pub use camera::thin_lens::ThinLens;
pub use camera::throughput::{AxialLight, Throughput};
pub use camera::{Camera, LensColumns, LensModel, RealLens};
pub use film_size::{FILM_SIZES, FilmSize, film_size};
pub use focus::focus_model::FocusModel;
pub use focus::paraxial::{FocusError, Paraxial, Pupil, RayTransferMatrix};
pub use focus::real_ray::RealRayFocus;
pub use focus::stop_diameter::{FNumberError, RoundedFNumber};
pub use prescription::coating::{
    ASSUMED_COATING, BROADBAND_REFLECTANCE, BareInterface, Coating, CoatingLayer, CoatingModel,
    DESIGN_WAVELENGTH, LayerStack, MGF2_INDEX, QuarterWaveLayer, StackModel,
};
pub use prescription::configuration::{Zoom, ZoomError};
pub use prescription::design::{
    Configuration, Design, FieldKind, Fields, Quantity, Setting, SpectralLine,
};
pub use prescription::error::LensError;
pub use prescription::iris::{ApertureMask, Iris, MaskConvention};
pub use prescription::limits::{INFINITE, MAX_INDEX, MIN_INDEX};
pub use prescription::named_mask::MASK_NAMES;
pub use prescription::pose::{
    CoordinateBreak, FilmPlane, MAX_DECENTRE, MAX_TILT, Pose, TiltDecenter,
};
pub use prescription::surface_aperture::{ApertureForm, SurfaceAperture};
pub use prescription::system;
pub use prescription::{CrossSection, Prescription, Row, Rows, TransverseAxis};
pub use pupil::fan::Fan;
pub use pupil::rim::SHELL_ENDS;
pub use pupil::vicinity::Vicinity;
pub use pupil::{Ellipse, PupilBounds, PupilSampling, REAR_SHARE, RIM_SHARE, VICINITY_SHARE};
pub use trace::asphere::Asphere;
pub use trace::biradial::Biradial;
pub use trace::chief_ray::{ChiefRayFinder, StopRay};
pub use trace::frame_transform::FrameTransform;
pub use trace::kernel::LensRay;
pub use trace::path::{OpticalPath, PASSES, trace_past_rims};
pub use trace::stop::ApertureShape;
pub use trace::{
    BlockReason, Blocked, retrace_in_f64, retrace_in_f64_lossy, trace, trace_ghost, trace_lossy,
    trace_one,
};
pub use trace::{
    sequence::{Side, ghost_sequence, sequence, sequence_at},
    surface::{Surface, SurfaceKind, open_surfaces},
};
pub use vignetting::{LightBudget, Normalization, RowLoss, Vignetting};
pub use wavefront::exit_pupil::raster::PupilRaster;
pub use wavefront::exit_pupil::{ExitPupil, PupilEdge};
pub use wavefront::path_difference::{Wavefront, WavefrontPoint};
pub use wavefront::wavefront_fit::WavefrontFit;
