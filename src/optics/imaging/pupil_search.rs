//! Search for the pupil of a chief ray, in the coordinates of rays before the lens.
//!
//! The search is in f64 and from the object: wavefronts need exact rays of an object point. Pupil
//! tables and light budgets scan the pupil from the film, in f32, in the lens crate.

use super::chief::{ChiefRay, ObjectPoint};
use super::lens_at_wavelength::{FilmRay, LensAtWavelength};
use super::polynomial_map::PolynomialMap;
use super::vector::dot;

/// Rays along each side of the coarse grid.
const COARSE: usize = 24;
/// Attempts to enclose the pupil.
const ATTEMPTS: u32 = 8;

/// Box of T.
#[derive(Clone, Copy, Debug)]
pub(super) struct Extent {
    pub low: [f64; 2],
    pub high: [f64; 2],
}

impl LensAtWavelength {
    /// Returns the slopes of the stop coordinates by the pupil coordinates at the chief ray.
    pub(super) fn stop_slopes(&self, chief: &ChiefRay) -> Option<[[f64; 2]; 2]> {
        let unit = self.pupil_unit(chief) * 1e-4;
        let at = |pupil: [f64; 2]| self.traced(chief, pupil).map(|ray| ray.stop);
        let [x, y] = [[unit, 0.0], [0.0, unit]];
        let slope = |d: [f64; 2]| -> Option<[f64; 2]> {
            let (ahead, behind) = (at(d)?, at(d.map(|d| -d))?);
            Some([0, 1].map(|i| (ahead[i] - behind[i]) / (2.0 * unit)))
        };
        Some([slope(x)?, slope(y)?])
    }

    /// Returns about the radius of the entrance pupil in pupil coordinates.
    pub(super) fn pupil_unit(&self, chief: &ChiefRay) -> f64 {
        let radius = self.paraxial.entrance_pupil.diameter / 2.0;
        let radius = if radius.is_finite() { radius } else { self.stop_radius };
        match chief.object {
            ObjectPoint::Distant(_) => radius,
            ObjectPoint::Near(point) => {
                let way = [0, 1, 2].map(|i| chief.scene.point[i] - point[i]);
                radius / dot(way, way).sqrt().max(radius)
            }
        }
    }

    /// Finds the pupil of a chief ray: returns a fit from T to pupil coordinates and the extent of
    /// the pupil in T.
    pub(super) fn find_pupil(&self, chief: &ChiefRay) -> Option<(PolynomialMap, Extent)> {
        let [p, q] = self.stop_slopes(chief)?;
        // Half the size of the box along x and y in which the stop lies, to first order.
        let determinant = (p[0] * q[1] - p[1] * q[0]).abs();
        let mut half = [q[0].hypot(q[1]), p[0].hypot(p[1])].map(|reach| 1.4 * reach / determinant);
        let mut centre = [0.0; 2];
        for attempt in 0..ATTEMPTS {
            let place = |i: usize| 2.0 * (i as f64 + 0.5) / COARSE as f64 - 1.0;
            let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
            let places: Vec<[f64; 2]> = (0..COARSE * COARSE)
                .map(|i| [place(i % COARSE), place(i / COARSE)])
                .map(|[a, b]| [centre[0] + a * half[0], centre[1] + b * half[1]])
                .collect();
            let traced = self.all_traced(chief, &places);
            let rays: Vec<([f64; 2], FilmRay)> =
                places.into_iter().zip(traced).filter_map(|(at, ray)| Some((at, ray?))).collect();
            for (at, _) in rays.iter().filter(|(_, ray)| ray.clipped.is_none()) {
                low = [0, 1].map(|i| low[i].min(at[i]));
                high = [0, 1].map(|i| high[i].max(at[i]));
            }
            let cell = half.map(|half| 2.0 * half / COARSE as f64);
            if low[0] > high[0] {
                // Nothing passes: the pupil is narrower, or farther away.
                let factor = if attempt % 2 == 0 { 0.25 } else { 8.0 };
                half = half.map(|half| half * factor);
                continue;
            }
            let cut = (0..2).any(|i| {
                centre[i] - half[i] + cell[i] > low[i] || centre[i] + half[i] - cell[i] < high[i]
            });
            let found = [0, 1].map(|i| (high[i] - low[i]) / 2.0 + 1.5 * cell[i]);
            let small = (0..2).any(|i| found[i] < 0.5 * half[i]);
            if (cut || small) && attempt + 1 < ATTEMPTS {
                centre = [0, 1].map(|i| (low[i] + high[i]) / 2.0);
                half = found.map(|found| if cut { 1.5 * found } else { found });
                continue;
            }
            return self.fit_pupil(&rays, cell);
        }
        None
    }

    /// Fits the map to the rays that pass and to their neighbours in a grid with cells of this size.
    /// Farther out strong aspheres may deviate rays anywhere.
    fn fit_pupil(
        &self,
        rays: &[([f64; 2], FilmRay)],
        cell: [f64; 2],
    ) -> Option<(PolynomialMap, Extent)> {
        let cosines = |ray: &FilmRay| [ray.t[0], ray.t[1]];
        let passing: Vec<[f64; 2]> =
            rays.iter().filter(|(_, ray)| ray.clipped.is_none()).map(|(at, _)| *at).collect();
        let is_near = |at: [f64; 2]| {
            passing.iter().any(|near| (0..2).all(|i| (at[i] - near[i]).abs() < 1.1 * cell[i]))
        };
        let near = rays.iter().filter(|(at, _)| is_near(*at));
        let pairs: Vec<_> = near.map(|(at, ray)| (cosines(ray), *at)).collect();
        let map = PolynomialMap::fit(&pairs)?;
        let mut extent = Extent { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };
        for (_, ray) in rays.iter().filter(|(_, ray)| ray.clipped.is_none()) {
            let t = cosines(ray);
            extent.low = [0, 1].map(|i| extent.low[i].min(t[i]));
            extent.high = [0, 1].map(|i| extent.high[i].max(t[i]));
        }
        // The rim lies up to a coarse cell beyond the outermost ray that passes.
        let count = rays.iter().filter(|(_, ray)| ray.clipped.is_none()).count() as f64;
        let margin = 1.1 / count.sqrt();
        let widen = [0, 1].map(|i| margin * (extent.high[i] - extent.low[i]).max(1e-9));
        extent.low = [0, 1].map(|i| extent.low[i] - widen[i]);
        extent.high = [0, 1].map(|i| extent.high[i] + widen[i]);
        Some((map, extent))
    }
}
