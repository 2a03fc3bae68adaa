//! Density of pupil samples: with which probability the sampler draws a given point.
//!
//! The sampler draws from a mixture. A share [`REAR_SHARE`](super::REAR_SHARE) falls uniformly on
//! the ellipse around the rear element, and the rest on the fan. The density of a point is the sum
//! of both, because either may have drawn it.
//!
//! A path that was found from the scene is compared with the sampler by this density. A lens
//! conserves the etendue n^2 cos dA dw (Born & Wolf 1999; Boyd 1983). The density over area and
//! direction at a light is therefore that at the film, times n^2 cos at the light over n^2 cos at
//! the film.

use super::bounds::{FanTable, PupilBounds};

impl PupilBounds {
    /// Returns the density of samples at a point of the plane of the rear vertex, mm^-2, for a film
    /// point in mm. It is 0 where nothing is drawn or where samples have no weight. The point is in
    /// the frame in which [`PupilBounds::fan`] returns the fan of the film point.
    pub fn density(&self, film: [f32; 2], point: [f32; 2]) -> f32 {
        let rear = self.rear(film);
        let relative = [0, 1].map(|i| (point[i] - rear.centre[i]) / rear.half[i]);
        let in_rear = relative[0] * relative[0] + relative[1] * relative[1] <= 1.0;
        let uniform = if in_rear { self.rear_share / rear.area() } else { 0.0 };
        if matches!(self.table, FanTable::RearOnly) {
            return uniform;
        }
        let fan = self.fan(film);
        let density = fan.density(point);
        if !fan.is_open() || self.fans_only && density <= 0.0 {
            return 0.0;
        }
        (1.0 - self.rear_share) * density + uniform
    }
}
