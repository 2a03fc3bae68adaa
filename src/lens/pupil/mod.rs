//! Pupil bounds: the part of the rear vertex plane through which a film point sees the scene.
//!
//! Pupil points lie in the plane of the rear vertex. For some film points the outline of the light
//! is found by tracing and enclosed in a [fan](fan::Fan). Between them fans are interpolated corner
//! by corner, because the pupil moves and closes smoothly across the film. The tabulated film
//! points depend on the symmetry:
//!
//! - Round lens, untilted film: radii. Pupil points are in the frame of the film point: u points
//!   away from the axis, v across.
//! - Tilted film, or round elements of which some are tilted or decentred: spokes and rings about
//!   the axis (`polar_grid`). Here and below, u and v are x and y of the lens.
//! - Any other lens: a regular grid over the film (`film_grid`).
//!
//! Fans can miss slivers of the light. A small share of the samples is therefore drawn around them,
//! and weights use the density of the mixture, so that the picture stays unbiased. Three regions,
//! each larger than the one before, bound the weight of light that the ones before miss: the
//! rim just outside the fan, its vicinity and the whole rear element.

pub(crate) mod aim;
pub(crate) mod bounds;
mod density;
pub(crate) mod ellipse;
mod enclosure;
pub(crate) mod fan;
pub(crate) mod film_grid;
pub(crate) mod outline;
pub(crate) mod polar_grid;
pub(crate) mod rim;
pub(crate) mod sample;
pub(crate) mod scan;
pub(crate) mod table;
pub(crate) mod target;
pub(crate) mod tracker;
pub mod vicinity;

pub(crate) use bounds::FanTable;
pub use bounds::PupilBounds;
pub use ellipse::Ellipse;

/// Rings of the film of a round lens; each of their edges has a fan.
pub(crate) const RINGS: usize = 64;
/// Cells along each side of the grid for any other film; each of their corners has a fan.
pub(crate) const CELLS: usize = 24;
/// Share of the samples that are drawn from the rim of the fan.
pub const RIM_SHARE: f32 = 1.0 / 1024.0;
/// Share of the samples that are drawn from the vicinity of the fan.
pub const VICINITY_SHARE: f32 = 1.0 / 512.0;
/// Share of the samples that are drawn from the whole rear element.
pub const REAR_SHARE: f32 = 1.0 / 2048.0;

/// How pupil points are sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PupilSampling {
    /// Within the bounds of the exit pupil: few rays are lost, none are missed.
    #[default]
    Pupil,
    /// Within the bounds of the exit pupil of the lens with a round iris, which are computed in a
    /// fraction of the time if the iris alone is not round. Rays between the iris and the circle
    /// about it are lost.
    RoundIris,
    /// Within the bounds of the exit pupil of the middle of the film, which are computed in a small
    /// part of the time if the lens is round. Samples of other film points may miss light.
    Axis,
    /// Over the disk of the rear element's diameter in its vertex plane, as in the course of 2016:
    /// most rays are lost, and those that cross the rim outside the disk are missed.
    RearDisk,
}
