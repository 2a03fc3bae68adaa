//! Density of pupil samples: with which probability the sampler draws a given point.
//!
//! The sampler draws from a mixture: the fan, its [rim](super::rim), its
//! [vicinity](super::vicinity) and the ellipse around the rear element, with the [`Shares`]. The
//! density of a point is the sum of all, because any may have drawn it.
//!
//! A path that was found from the scene is compared with the sampler by this density. A lens
//! conserves the etendue n^2 cos dA dw (Born & Wolf 1999; Boyd 1983). The density over area and
//! direction at a light is therefore that at the film, times n^2 cos at the light over n^2 cos at
//! the film.

use super::bounds::{FanTable, PupilBounds};
use super::fan::{Fan, TRIANGLES};
use super::rim::relative_density;
use super::vicinity::Vicinity;
use super::{Ellipse, REAR_SHARE, RIM_SHARE, VICINITY_SHARE};

/// Shares of the samples that are not drawn from the fan.
#[derive(Clone, Copy, Debug)]
pub(super) struct Shares {
    pub rear: f32,
    pub vicinity: f32,
    pub rim: f32,
}

impl Shares {
    /// Shares around a fan.
    pub const AROUND_FAN: Self =
        Self { rear: REAR_SHARE, vicinity: VICINITY_SHARE, rim: RIM_SHARE };
    /// Shares without a fan.
    pub const REAR_ONLY: Self = Self { rear: 1.0, vicinity: 0.0, rim: 0.0 };

    /// Returns the share of all samples that are not drawn from the fan.
    #[inline(always)]
    pub fn outside(&self) -> f32 {
        self.rear + self.vicinity + self.rim
    }
}

/// The regions that the samples of a film point are drawn from.
pub(super) struct Regions {
    pub fan: Fan,
    pub vicinity: Vicinity,
    pub rear: Ellipse,
}

impl PupilBounds {
    /// Returns the density of samples at a point of the plane of the rear vertex, mm^-2, for a film
    /// point in mm. It is 0 where nothing is drawn or where samples have no weight. The point is in
    /// the frame in which [`PupilBounds::fan`] returns the fan of the film point.
    pub fn density(&self, film: [f32; 2], point: [f32; 2]) -> f32 {
        self.mixture_density(&self.regions(film), point)
    }

    /// Returns that density for a film point with these regions.
    pub(super) fn mixture_density(&self, regions: &Regions, point: [f32; 2]) -> f32 {
        let Regions { fan, vicinity, rear } = regions;
        let base = self.shares.rear * rear.density(point);
        if matches!(self.table, FanTable::RearOnly) {
            return base;
        }
        let sector = fan.sector(point);
        let is_inside = sector.is_some_and(|(scale, _)| scale <= 1.0);
        if !fan.is_open() || self.fans_only && !is_inside {
            return 0.0;
        }
        let relative = |scale: f32| match scale <= 1.0 {
            true => 1.0 - self.shares.outside(),
            false => self.shares.rim * relative_density(scale),
        };
        let fan = sector.map_or(0.0, |(scale, area)| relative(scale) / (TRIANGLES as f32 * area));
        fan + self.shares.vicinity * vicinity.density(point) + base
    }
}
