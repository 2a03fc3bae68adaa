//! The lens: prescriptions, first-order optics, and the stage that takes film samples to
//! rays in the world.
//!
//! Public numbers are in millimetres. Inside the trace +z is the direction of travel and
//! positions are relative to the vertex of the surface last crossed.

mod aim;
mod camera;
mod dat;
mod draw;
mod glass;
mod iris;
mod paraxial;
mod prescription;
mod pupil;
mod surface;
mod trace;

pub use camera::{Camera, LensColumns, Model, RealLens, ThinLens};
pub use dat::{LensError, parse, read};
pub use draw::draw;
pub use glass::Glass;
pub use iris::{Iris, Mask};
pub use paraxial::{FocusError, Matrix, Paraxial, Pupil, marginal_f_number};
pub use prescription::{Axis, Prescription, Row};
pub use pupil::{Aim, Bound, Ellipse, PupilBound, REAR_SHARE};
pub use surface::{From, Kind, Surface, sequence};
pub use trace::{Blocked, LensRay, Why, trace, trace_one};
