//! The lens: prescriptions, first-order optics, and the stage that takes film samples to
//! rays in the world.
//!
//! Public numbers are in millimetres. Inside the trace +z is the direction of travel and
//! positions are relative to the vertex of the surface last crossed.

mod aim;
mod asphere;
mod band;
mod camera;
mod cells;
mod coating;
mod dat;
mod displacement;
mod draw;
mod error;
mod exit_pupil;
mod fan;
mod fidelity;
mod file;
mod film_error;
mod focus;
mod glass;
mod ideal;
mod iris;
mod opening;
mod outline;
mod paraxial;
mod placement;
mod polar;
mod polynomial;
mod pose;
mod prescription;
mod pupil;
mod refract;
mod simulated;
mod surface;
mod survey;
mod target;
mod thin;
mod throughput;
mod toml;
mod trace;
mod turn;
mod vignetting;
mod wavefront;
mod widened;

pub use asphere::Asphere;
pub use band::Band;
pub use camera::{Camera, LensColumns, Model, RealLens};
pub use coating::{BROADBAND, Coat, Coating, Face, Layer, MGF2, TUNED};
pub use dat::parse;
pub use draw::draw;
pub use error::LensError;
pub use exit_pupil::{Edge, ExitPupil};
pub use fan::Fan;
pub use fidelity::Fidelity;
pub use file::read;
pub use film_error::{FilmError, film_error};
pub use focus::Focus;
pub use glass::{C_LINE, CatalogueGlass, D_LINE, F_LINE, Formula, Glass, catalogue, nearest_glass};
pub use iris::{Iris, MASKS, Mask};
pub use opening::Shape;
pub use paraxial::{FocusError, Matrix, Paraxial, Pupil};
pub use pose::{Askew, FilmPlane, MOST_DECENTRE, MOST_TILT, Pose};
pub use prescription::{Axis, Prescription, Row};
pub use pupil::{Aim, Ellipse, PupilBound, REAR_SHARE};
pub use refract::LensRay;
pub use surface::{From, Kind, Surface, ghost_sequence, sequence};
pub use thin::ThinLens;
pub use throughput::Throughput;
pub use toml::parse as parse_toml;
pub use trace::{Blocked, Why, settle, settle_lossy, trace, trace_ghost, trace_lossy, trace_one};
pub use turn::Turn;
pub use vignetting::{Ledger, Loss, Of, Vignetting};
pub use wavefront::{Delay, Wavefront};
