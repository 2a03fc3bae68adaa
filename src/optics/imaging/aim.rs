//! Aim of rays at points of the stop.

use super::chief::ChiefRay;
use super::lens_at_wavelength::{FilmRay, LensAtWavelength};
use petzval_base::plane_newton::{PlaneNewton, solve2};

/// Step of the finite differences, relative to the entrance pupil.
const DIFFERENCE: f64 = 1e-5;
/// Distance from the point, relative to the radius of the stop, at which the search ends, and at
/// which a ray counts as aimed.
const PRECISION: [f64; 2] = [1e-11, 1e-6];
/// Steps towards the chief ray in search of a ray that comes through.
const RETREATS: u32 = 20;

impl LensAtWavelength {
    /// Returns the ray through a point of the stop, relative to its radius; `None` if there is
    /// none.
    pub(super) fn aim(&self, chief: &ChiefRay, stop: [f64; 2]) -> Option<FilmRay> {
        self.traced(chief, self.aimed_pupil(chief, stop)?)
    }

    /// Returns the pupil coordinates of that ray.
    pub(super) fn aimed_pupil(&self, chief: &ChiefRay, stop: [f64; 2]) -> Option<[f64; 2]> {
        let centre = self.traced(chief, [0.0; 2])?.stop;
        let mut start = solve2(self.stop_slopes(chief)?, [0, 1].map(|i| stop[i] - centre[i]))?;
        for _ in 0..RETREATS {
            if self.traced(chief, start).is_some() {
                break;
            }
            start = start.map(|x| 0.8 * x);
        }
        let [precision, acceptable] = PRECISION;
        let newton =
            PlaneNewton { difference: DIFFERENCE * self.pupil_unit(chief), precision, acceptable };
        newton.solve(start, |at| {
            self.traced(chief, at).map(|ray| [0, 1].map(|i| ray.stop[i] - stop[i]))
        })
    }
}
