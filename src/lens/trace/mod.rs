//! Ray tracing through the surfaces of a lens.
//!
//! [`surface`] and [`sequence`] prepare the surfaces, [`kernel`] selects the code of each,
//! `batch` and `single` trace rays. Whether surfaces take their losses is a compile-time
//! parameter of the loop, so that tracing without losses costs nothing. [`trace()`] is a function
//! of its own, so that this can be verified: `objdump -dC` shows the same instructions of it in
//! builds with and without effects.

pub(crate) mod absorption;
pub(crate) mod asphere;
pub(crate) mod batch;
pub(crate) mod biradial;
pub(crate) mod chief_ray;
pub(crate) mod crossing;
pub(crate) mod frame_transform;
pub(crate) mod ideal;
pub mod kernel;
pub mod path;
pub(crate) mod polynomial;
pub(crate) mod refract;
pub mod sequence;
pub(crate) mod single;
pub(crate) mod stop;
pub mod surface;

pub use batch::{retrace_in_f64, retrace_in_f64_lossy, trace, trace_ghost, trace_lossy};
pub(crate) use single::trace_one_lossy;
pub use single::{BlockReason, Blocked, trace_one};
