//! Participating media: matter between surfaces that absorbs, scatters and emits light.
//!
//! Coefficients are by RGB channel and by world unit of length. A ray carries the index of the
//! medium that it travels in, [`VACUUM`] if there is none. Surfaces with an [`MediumInterface`] change it.

mod bricks;
mod cloud;
mod colours;
mod emission;
mod field;
mod grid;
mod homogeneous;
mod majorant;
mod measured;
mod medium_pass;
pub mod phase_function;
mod spectral;
mod stage;
mod subsurface;
mod subsurface_walk;
mod track;
mod walk;

pub use bricks::BrickGrid;
pub use cloud::CloudPattern;
pub use colours::MediumColours;
pub use emission::Blackbodies;
pub use field::{Coefficients, DensityField, Field, FieldEmission, PlacedGrid, ScalarGrid};
pub use grid::{VoxelGrid, Voxels};
pub use homogeneous::Homogeneous;
pub use majorant::MajorantGrid;
pub use measured::MeasuredMedium;
pub use phase_function::{henyey_greenstein, sample_henyey_greenstein_cosine};
pub(super) use spectral::MediumSpectra;
pub use stage::{MediumColumns, Surroundings};
pub use subsurface::{DiffuseBoundary, Subsurface};
pub use track::VaryingMedium;

use std::sync::Arc;

use glam::Vec3;

use super::world::build_world;
use super::{Dispersion, MaterialModel, Scene};
use petzval_base::rays::{Hit, NO_INDEX};

/// Index of no medium.
pub const VACUUM: u32 = NO_INDEX;

/// A participating medium.
#[derive(Clone, Debug)]
pub struct Medium {
    /// Asymmetry of its phase function, of Henyey & Greenstein 1941: the mean cosine between the
    /// directions before and after scattering.
    pub g: f32,
    /// Coefficients.
    pub model: MediumModel,
    /// Boundary of a medium below a surface, through which paths walk; `None` for others.
    pub boundary: Option<DiffuseBoundary>,
    /// Refractive index of the boundary by wavelength; `None` if it is constant.
    pub boundary_dispersion: Dispersion,
    /// The coefficients as colours, if a spectrum is known; `model` has their RGB.
    pub colours: Option<Arc<MediumColours>>,
}

/// Coefficients of a medium.
#[derive(Clone, Debug)]
pub enum MediumModel {
    /// The same everywhere.
    Homogeneous(Homogeneous),
    /// Different from point to point, inside a box.
    Varying(Box<VaryingMedium>),
}

impl Medium {
    /// A medium that is not below a surface.
    pub fn new(model: MediumModel, g: f32, colours: Option<Arc<MediumColours>>) -> Self {
        Self { g, model, boundary: None, boundary_dispersion: None, colours }
    }

    /// The medium below a surface.
    pub fn below(interior: &Subsurface) -> Self {
        Self {
            boundary: Some(DiffuseBoundary::new(interior.eta)),
            boundary_dispersion: interior.dispersion.clone(),
            colours: interior.colours.clone(),
            ..Self::homogeneous(interior.medium, interior.g)
        }
    }

    /// A homogeneous medium that is not below a surface.
    pub fn homogeneous(medium: Homogeneous, g: f32) -> Self {
        Self::new(MediumModel::Homogeneous(medium), g, None)
    }

    /// Returns the name of its kind in reports.
    pub fn kind(&self) -> &'static str {
        match &self.model {
            MediumModel::Homogeneous(_) if self.boundary.is_some() => "subsurface",
            MediumModel::Homogeneous(_) => "homogeneous",
            MediumModel::Varying(varying) => varying.field.kind(),
        }
    }
}

/// Indices of the media on both sides of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MediumInterface {
    /// Medium on the side away from the geometric normal.
    pub inside: u32,
    /// Medium on the side of the geometric normal.
    pub outside: u32,
}

impl Scene {
    /// Returns whether rays may travel in a medium.
    pub fn has_media(&self) -> bool {
        !self.media.is_empty()
    }

    /// Removes all media: light passes unchanged where they were. Call it before
    /// [`Scene::freeze`].
    pub fn remove_media(&mut self) {
        if !self.has_media() {
            return;
        }
        self.media = [].into();
        self.camera_medium = VACUUM;
        // Surfaces that did nothing but separate them would block shadow rays.
        let stays = |shape: &u32| {
            let material = self.shapes[*shape as usize].material;
            !matches!(self.materials[material as usize].model, MaterialModel::Interface)
        };
        self.static_shapes = self.static_shapes.iter().copied().filter(stays).collect();
        let (shapes, included) = (&self.shapes, &self.static_shapes);
        let world = build_world(shapes, included, &self.objects, &self.instances);
        (self.world, self.frozen) = (Arc::new(world), Arc::default());
    }

    /// Returns whether a hit is on the boundary of the medium in which a ray walks. `medium` is that
    /// of the ray.
    #[inline(always)]
    pub fn leaves_subsurface(&self, hit: &Hit, medium: u32) -> bool {
        self.has_media() && self.is_boundary_of(hit, medium)
    }

    #[inline(never)]
    fn is_boundary_of(&self, hit: &Hit, medium: u32) -> bool {
        let walks = self.media.get(medium as usize).is_some_and(|medium| medium.boundary.is_some());
        let shape = if walks { self.shapes.get(hit.shape as usize) } else { None };
        shape.is_some_and(|shape| shape.interface.is_some_and(|sides| sides.inside == medium))
    }

    /// Returns the medium of a ray that leaves a surface in a direction. `current` is that of the
    /// ray that hit it, `normal` the geometric normal.
    pub fn medium_beyond(&self, hit: &Hit, current: u32, normal: Vec3, direction: Vec3) -> u32 {
        match self.shapes[hit.shape as usize].interface {
            None => current,
            Some(MediumInterface { outside, .. }) if normal.dot(direction) > 0.0 => outside,
            Some(MediumInterface { inside, .. }) => inside,
        }
    }
}
