//! The lens: prescriptions, first-order optics, and the stage that takes film samples to
//! rays in the world.
//!
//! Public numbers are in millimetres. Inside the trace +z is the direction of travel and
//! positions are relative to the vertex of the surface last crossed.

mod aim;
mod camera;
mod dat;
mod error;
mod file;
mod glass;
mod iris;
mod paraxial;
mod prescription;
mod pupil;
mod surface;
mod toml;
mod trace;

pub use camera::{Camera, LensColumns, Model, RealLens, ThinLens};
pub use dat::parse;
pub use error::LensError;
pub use file::read;
pub use glass::{C_LINE, CatalogueGlass, D_LINE, F_LINE, Formula, Glass, catalogue, nearest_glass};
pub use iris::{Iris, MASKS, Mask};
pub use paraxial::{FocusError, Matrix, Paraxial, Pupil, marginal_f_number};
pub use prescription::{Axis, Prescription, Row};
pub use pupil::{Aim, Bound, Ellipse, PupilBound, REAR_SHARE};
pub use surface::{From, Kind, Surface, sequence};
pub use toml::parse as parse_toml;
pub use trace::{Blocked, LensRay, Why, trace, trace_one};
