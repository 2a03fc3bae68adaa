//! Density of pupil samples: with which probability the sampler draws a given point.
//!
//! The sampler draws from a mixture of three: the fan, its [rim](super::rim) with the share
//! [`RIM_SHARE`](super::RIM_SHARE), and with the share [`REAR_SHARE`](super::REAR_SHARE) the
//! ellipse around the rear element, uniformly. The density of a point is the sum of all, because
//! any may have drawn it.
//!
//! A path that was found from the scene is compared with the sampler by this density. A lens
//! conserves the etendue n^2 cos dA dw (Born & Wolf 1999; Boyd 1983). The density over area and
//! direction at a light is therefore that at the film, times n^2 cos at the light over n^2 cos at
//! the film.

use super::Ellipse;
use super::bounds::{FanTable, PupilBounds};
use super::fan::{Fan, TRIANGLES};
use super::rim::relative_density;

impl PupilBounds {
    /// Returns the density of samples at a point of the plane of the rear vertex, mm^-2, for a film
    /// point in mm. It is 0 where nothing is drawn or where samples have no weight. The point is in
    /// the frame in which [`PupilBounds::fan`] returns the fan of the film point.
    pub fn density(&self, film: [f32; 2], point: [f32; 2]) -> f32 {
        self.mixture_density(&self.fan(film), &self.rear(film), point)
    }

    /// Returns that density for a film point with this fan and this rear element.
    pub(super) fn mixture_density(&self, fan: &Fan, rear: &Ellipse, point: [f32; 2]) -> f32 {
        let rear = if rear.contains(point) { self.rear_share / rear.area() } else { 0.0 };
        if matches!(self.table, FanTable::RearOnly) {
            return rear;
        }
        let (mut inside, mut rim) = (0.0, 0.0);
        for (scale, area) in fan.sectors(point) {
            let per_area = 1.0 / (TRIANGLES as f32 * area);
            match scale <= 1.0 {
                true => inside += per_area,
                false => rim += per_area * relative_density(scale),
            }
        }
        if !fan.is_open() || self.fans_only && inside <= 0.0 {
            return 0.0;
        }
        (1.0 - self.outside_share()) * inside + self.rim_share * rim + rear
    }
}
