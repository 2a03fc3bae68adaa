//! Aim of rays at points of the stop.

use super::chief::ChiefRay;
use super::lens_at_wavelength::{FilmRay, LensAtWavelength};
use super::vector::solve2;

impl LensAtWavelength {
    /// Returns the pupil coordinates of the ray through a point of the stop, relative to its
    /// radius, by Newton's method; `None` if there is none.
    pub(super) fn aim(&self, chief: &ChiefRay, stop: [f64; 2]) -> Option<FilmRay> {
        let [p, q] = self.stop_slopes(chief)?;
        let centre = self.traced(chief, [0.0; 2])?.stop;
        let mut at = solve2([p, q], [0, 1].map(|i| stop[i] - centre[i]))?;
        let mut ray = self.nearest_traced(chief, &mut at)?;
        let unit = self.pupil_unit(chief) * 1e-5;
        for _ in 0..30 {
            let miss = [0, 1].map(|i| stop[i] - ray.stop[i]);
            if miss[0].hypot(miss[1]) < 1e-11 {
                return Some(ray);
            }
            let slope = |d: [f64; 2]| -> Option<[f64; 2]> {
                let near = self.traced(chief, [0, 1].map(|i| at[i] + d[i]))?;
                Some([0, 1].map(|i| (near.stop[i] - ray.stop[i]) / unit))
            };
            let step = solve2([slope([unit, 0.0])?, slope([0.0, unit])?], miss)?;
            let (next, closer) = (0..10).find_map(|halving| {
                let part = 0.5_f64.powi(halving);
                let next = [0, 1].map(|i| at[i] + part * step[i]);
                let ray = self.traced(chief, next)?;
                let left = [0, 1].map(|i| stop[i] - ray.stop[i]);
                (left[0].hypot(left[1]) < miss[0].hypot(miss[1])).then_some((next, ray))
            })?;
            (at, ray) = (next, closer);
        }
        let miss = [0, 1].map(|i| stop[i] - ray.stop[i]);
        (miss[0].hypot(miss[1]) < 1e-6).then_some(ray)
    }

    /// Traces the ray of pupil coordinates, or one closer to the chief ray if there is none.
    fn nearest_traced(&self, chief: &ChiefRay, at: &mut [f64; 2]) -> Option<FilmRay> {
        for _ in 0..20 {
            if let Some(ray) = self.traced(chief, *at) {
                return Some(ray);
            }
            *at = at.map(|x| 0.8 * x);
        }
        None
    }
}
