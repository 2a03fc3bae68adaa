//! Analysis of a lens: first-order optics, focus, pupils, vignetting and wavefronts.

pub(crate) mod calibration;
pub(crate) mod displacement;
pub(crate) mod exit_pupil;
pub(crate) mod film_error;
pub(crate) mod focus;
pub(crate) mod focus_model;
pub(crate) mod imaging;
pub(crate) mod open_rims;
pub(crate) mod optimize;
pub(crate) mod paraxial;
pub(crate) mod stop_diameter;
pub(crate) mod throughput;
pub(crate) mod tolerance;
pub(crate) mod vignetting;
pub(crate) mod wavefront;
pub(crate) mod wavefront_fit;
