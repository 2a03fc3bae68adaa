//! Sequential system as optical-design programs state it, before it becomes a prescription.
//!
//! The readers of foreign formats fill a [`SequentialSystem`] with what their files state, in mm.
//! [`SequentialSystem::build`] does what all of them need: it joins dummy planes and coordinate
//! breaks with the spaces around them, finds the media before and behind each surface, sets the
//! stop and completes unknown diameters.

mod build;
mod choose_stop;
mod diameters;
mod join;
mod object_space;
mod wide_field;

pub use choose_stop::choose_stop;

use glam::DAffine3;

use super::design::Design;
use super::row::Row;
use petzval_spectrum::Glass;

/// Greatest number of surfaces of a system. Real lenses have fewer than 100.
pub const MAX_SURFACES: usize = 2000;

/// A sequential optical system: the surfaces between object and image, without both.
#[derive(Clone, Debug, Default)]
pub struct SequentialSystem {
    /// Name; empty for that of the file.
    pub name: String,
    /// Source of the figures.
    pub source: Option<String>,
    /// Focal length that the file states (mm).
    pub focal_length: Option<f64>,
    /// f-number that the file states beside the aperture.
    pub f_number: Option<f64>,
    /// Aperture of the system; none leaves the stop at its own diameter.
    pub aperture: Option<SystemAperture>,
    /// Wavelengths, fields, conjugates and configurations. Rows of settings are indices of
    /// [`Self::surfaces`].
    pub design: Design,
    /// Medium of the object, before the first surface.
    pub object_medium: MediumBehind,
    /// Surfaces from the scene to the film. The thickness of the last one leads to the film.
    pub surfaces: Vec<SystemSurface>,
    /// Half-diameters of which the file says that they are semi-diameters. If they exceed the
    /// radii of their surfaces, they are diameters.
    pub column_of_semi_diameters: bool,
}

/// Aperture of a system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SystemAperture {
    /// Diameter of the entrance pupil (mm).
    EntrancePupil(f64),
    /// Focal length over the diameter of the entrance pupil.
    FNumber(f64),
    /// Numerical aperture behind the lens.
    ImageNa(f64),
    /// Numerical aperture before the lens, for an object at a finite distance.
    ObjectNa(f64),
}

/// A surface of a sequential system, a dummy plane or a coordinate break.
#[derive(Clone, Debug)]
pub struct SystemSurface {
    /// Line of the file, from 1.
    pub line: usize,
    /// Shape, thickness, stop, obstruction and pose. Index, glass, diameter and mirror are set by
    /// [`SequentialSystem::build`].
    pub row: Row,
    /// Medium behind the surface.
    pub medium: MediumBehind,
    /// Semi-diameter (mm), if the file states one.
    pub semi_diameter: Option<f64>,
    /// Whether the semi-diameter is a true aperture and not one that a program computed.
    pub clips: bool,
    /// Coordinate break: position and directions of the following axes in those of the axes before.
    /// All else but the thickness is then unused.
    pub coordinate_break: Option<DAffine3>,
}

impl Default for SystemSurface {
    fn default() -> Self {
        Self {
            line: 0,
            row: Row::default(),
            medium: MediumBehind::Air,
            semi_diameter: None,
            clips: false,
            coordinate_break: None,
        }
    }
}

/// Medium behind a surface.
#[derive(Clone, Debug, Default)]
pub enum MediumBehind {
    /// Air or vacuum.
    #[default]
    Air,
    /// The medium before the surface.
    Same,
    /// The surface reflects.
    Mirror,
    /// A glass.
    Glass(Glass),
    /// A medium of constant index.
    Index(f64),
}
