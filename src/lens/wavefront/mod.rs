//! Exit pupil, and path differences of the light that passes it.

pub mod exit_pupil;
pub mod path_difference;
pub mod wavefront_fit;
