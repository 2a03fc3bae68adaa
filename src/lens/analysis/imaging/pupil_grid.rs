//! Regular grid of rays over the real, vignetted exit pupil of a field point.
//!
//! The coordinates are the optical direction cosines T_x, T_y at the film. In them the pupil has
//! its true shape, irradiance is an area (dE = L dT_x dT_y) and an optical transfer function is an
//! autocorrelation (Hopkins 1957), however wide the field. Rays start at the object point. A coarse
//! grid finds the pupil, polynomials of degree 7 invert the map from the pupil coordinates before
//! the lens to T, and the rays of the dense grid miss their places by so little that their
//! transverse aberration, the exact gradient of the phase, corrects the rest.

use super::chief::{ChiefRay, ObjectPoint};
use super::lens_at_wavelength::{FilmRay, LensAtWavelength};
use super::polynomial_map::PolynomialMap;
use super::vector::{dot, solve2};

/// Rays along each side of the coarse grid.
const COARSE: usize = 24;
/// Attempts to enclose the pupil.
const ATTEMPTS: u32 = 8;
/// Rays along each side of a cell at the edge of the pupil, for the share that passes.
const EDGE: usize = 4;

/// A cell of the grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PupilCell {
    /// Share of the cell that passes the lens.
    pub share: f64,
    /// Light that enters per unit of T_x T_y, relative to its mean over the pupil.
    pub density: f64,
    /// Optical path to the plane wave of this direction through the reference point, minus that of
    /// the chief ray (mm).
    pub phase: f64,
    /// Point on the film (mm).
    pub point: [f64; 2],
    /// T_z, the optical direction cosine along the axis.
    pub t_z: f64,
    /// Point in the stop, relative to its radius.
    pub stop: [f64; 2],
    /// Optical path difference to the reference sphere of the exit pupil (mm).
    pub path_difference: f64,
}

/// Rays of a field point and a wavelength on a regular grid over the exit pupil.
#[derive(Clone, Debug)]
pub struct PupilGrid {
    /// Wavelength (nm).
    pub nm: f64,
    /// Relative weight of the wavelength.
    pub weight: f64,
    /// Cells along each side.
    pub side: usize,
    /// T_x and T_y of the middle of the first cell.
    pub first: [f64; 2],
    /// Distance of neighbouring cells in T.
    pub step: f64,
    /// Cells, row by row along T_x; `None` where no ray passes.
    pub cells: Vec<Option<PupilCell>>,
    /// Reference point on the film (mm): that of the chief ray at the primary wavelength.
    pub reference: [f64; 2],
    /// Point of this wavelength's own chief ray (mm).
    pub chief_point: [f64; 2],
}

impl PupilGrid {
    /// Returns the T of a cell.
    pub fn direction(&self, i: usize) -> [f64; 2] {
        [
            self.first[0] + self.step * (i % self.side) as f64,
            self.first[1] + self.step * (i / self.side) as f64,
        ]
    }

    /// Returns the cells through which light passes, with their numbers.
    pub fn open(&self) -> impl Iterator<Item = (usize, &PupilCell)> {
        self.cells.iter().enumerate().filter_map(|(i, cell)| cell.as_ref().map(|cell| (i, cell)))
    }

    /// Returns the area of the pupil in T: the irradiance of a unit radiance.
    pub fn area(&self) -> f64 {
        self.open().map(|(_, cell)| cell.share).sum::<f64>() * self.step * self.step
    }

    /// Returns the light of a cell: share times density.
    pub fn light(cell: &PupilCell) -> f64 {
        cell.share * cell.density
    }
}

/// Box of T.
#[derive(Clone, Copy, Debug)]
struct Extent {
    low: [f64; 2],
    high: [f64; 2],
}

impl LensAtWavelength {
    pub(super) fn traced(&self, chief: &ChiefRay, pupil: [f64; 2]) -> Option<FilmRay> {
        let (start, direction, before) = self.scene_ray(chief, pupil)?;
        let mut ray = self.to_film(start, direction)?;
        ray.length += before;
        Some(ray)
    }

    /// Returns the slopes of the stop coordinates by the pupil coordinates at the chief ray.
    fn stop_slopes(&self, chief: &ChiefRay) -> Option<[[f64; 2]; 2]> {
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

    /// Finds the pupil of a chief ray: returns a fit from T to pupil coordinates and the extent of
    /// the pupil in T.
    fn find_pupil(&self, chief: &ChiefRay) -> Option<(PolynomialMap, Extent)> {
        let [p, q] = self.stop_slopes(chief)?;
        // Half the size of the box along x and y in which the stop lies, to first order.
        let determinant = (p[0] * q[1] - p[1] * q[0]).abs();
        let mut half = [q[0].hypot(q[1]), p[0].hypot(p[1])].map(|reach| 1.4 * reach / determinant);
        let mut centre = [0.0; 2];
        for attempt in 0..ATTEMPTS {
            let place = |i: usize| 2.0 * (i as f64 + 0.5) / COARSE as f64 - 1.0;
            let mut rays = Vec::with_capacity(COARSE * COARSE);
            let (mut low, mut high) = ([f64::INFINITY; 2], [f64::NEG_INFINITY; 2]);
            for i in 0..COARSE * COARSE {
                let [a, b] = [place(i % COARSE), place(i / COARSE)];
                let at = [centre[0] + a * half[0], centre[1] + b * half[1]];
                let Some(ray) = self.traced(chief, at) else { continue };
                if ray.clipped.is_none() {
                    low = [0, 1].map(|i| low[i].min(at[i]));
                    high = [0, 1].map(|i| high[i].max(at[i]));
                }
                rays.push((at, ray));
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
            let reach = |at: [f64; 2]| {
                (0..2).all(|i| (low[i] - 1.6 * cell[i]..high[i] + 1.6 * cell[i]).contains(&at[i]))
            };
            return self.fit_pupil(&rays, reach);
        }
        None
    }

    fn fit_pupil(
        &self,
        rays: &[([f64; 2], FilmRay)],
        reach: impl Fn([f64; 2]) -> bool,
    ) -> Option<(PolynomialMap, Extent)> {
        let cosines = |ray: &FilmRay| [ray.t[0], ray.t[1]];
        let pairs: Vec<_> =
            rays.iter().filter(|(at, _)| reach(*at)).map(|(at, ray)| (cosines(ray), *at)).collect();
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

    /// Traces the dense grid of a chief ray, `side` cells along each side. The reference point and
    /// sphere are those of the chief ray of the primary wavelength.
    pub(super) fn pupil_grid(
        &self,
        chief: &ChiefRay,
        reference: &ReferenceSphere,
        side: usize,
    ) -> Option<PupilGrid> {
        let (map, extent) = self.find_pupil(chief)?;
        let width = (extent.high[0] - extent.low[0]).max(extent.high[1] - extent.low[1]);
        let step = width / side as f64;
        let first = [0, 1]
            .map(|i| (extent.low[i] + extent.high[i]) / 2.0 - step * (side as f64 - 1.0) / 2.0);
        let own = self.traced(chief, [0.0; 2])?;
        let mut grid = PupilGrid {
            nm: self.nm,
            weight: self.weight,
            side,
            first,
            step,
            cells: vec![None; side * side],
            reference: reference.point,
            chief_point: own.point,
        };
        let inside = |t: [f64; 2]| {
            (0..2).all(|i| (extent.low[i] - step..extent.high[i] + step).contains(&t[i]))
        };
        let rays: Vec<Option<FilmRay>> = (0..side * side)
            .map(|i| {
                let t = grid.direction(i);
                inside(t).then(|| self.traced(chief, map.value(t))).flatten()
            })
            .collect();
        let passes = |i: usize| rays[i].as_ref().is_some_and(|ray| ray.clipped.is_none());
        let open: Vec<bool> = (0..side * side).map(passes).collect();
        for i in 0..side * side {
            let neighbours = neighbours(i, side);
            let any = neighbours.clone().any(|j| open[j]);
            if !any {
                continue;
            }
            let t = grid.direction(i);
            let full = neighbours.clone().all(|j| open[j]);
            // A cell at the edge stands for the part that passes.
            let edge = match full {
                true => None,
                false => match self.edge(chief, &map, t, step) {
                    Some(edge) => Some(edge),
                    None => continue,
                },
            };
            let Some(ray) = rays[i].or(edge.as_ref().map(|edge| edge.ray)) else { continue };
            let (pupil, jacobian) = map.evaluate(t);
            grid.cells[i] = Some(PupilCell {
                share: edge.as_ref().map_or(1.0, |edge| edge.share),
                density: jacobian.abs() * self.light_per_pupil(chief, pupil),
                phase: reference.phase(&ray, t),
                point: edge.as_ref().map_or(ray.point, |edge| edge.point),
                t_z: ray.t[2],
                stop: ray.stop,
                path_difference: reference.path_difference(&ray),
            });
        }
        grid.normalize(reference, &own);
        Some(grid)
    }

    /// Returns the light per unit area of pupil coordinates, for an object that radiates evenly.
    fn light_per_pupil(&self, chief: &ChiefRay, [u, v]: [f64; 2]) -> f64 {
        match chief.object {
            ObjectPoint::Distant(_) => 1.0,
            // cos(theta) dOmega, with dOmega = du dv / w.
            ObjectPoint::Near(_) => {
                let direction = self.scene_ray(chief, [u, v]).map_or(0.0, |(_, d, _)| d[2]);
                direction / (1.0 - u * u - v * v).max(f64::EPSILON).sqrt()
            }
        }
    }

    /// Returns the part of a cell that passes; `None` if nothing does.
    fn edge(
        &self,
        chief: &ChiefRay,
        map: &PolynomialMap,
        t: [f64; 2],
        step: f64,
    ) -> Option<CellEdge> {
        let place = |i: usize| step * ((i as f64 + 0.5) / EDGE as f64 - 0.5);
        let mut passed = 0.0;
        let mut sum = [0.0; 2];
        let mut last = None;
        for i in 0..EDGE * EDGE {
            let at = [t[0] + place(i % EDGE), t[1] + place(i / EDGE)];
            let ray = self.traced(chief, map.value(at));
            if let Some(ray) = ray.filter(|ray| ray.clipped.is_none()) {
                passed += 1.0;
                sum = [0, 1].map(|i| sum[i] + ray.point[i]);
                last = Some(ray);
            }
        }
        let share = passed / (EDGE * EDGE) as f64;
        last.map(|ray| CellEdge { share, point: sum.map(|x| x / passed), ray })
    }
}

/// The part of a cell that passes.
struct CellEdge {
    /// Share of the cell.
    share: f64,
    /// Mean point on the film (mm).
    point: [f64; 2],
    /// One of its rays.
    ray: FilmRay,
}

/// Returns a cell and the up to eight cells around it.
fn neighbours(i: usize, side: usize) -> impl Iterator<Item = usize> + Clone {
    let (x, y) = (i % side, i / side);
    let rows = y.saturating_sub(1)..(y + 2).min(side);
    rows.flat_map(move |row| {
        (x.saturating_sub(1)..(x + 2).min(side)).map(move |column| row * side + column)
    })
}

impl PupilGrid {
    /// Makes the density relative to its mean and phases relative to the chief ray.
    fn normalize(&mut self, reference: &ReferenceSphere, own: &FilmRay) {
        let (mut light, mut area) = (0.0, 0.0);
        for (_, cell) in self.open() {
            light += Self::light(cell);
            area += cell.share;
        }
        let chief_phase = reference.phase(own, [own.t[0], own.t[1]]);
        let chief_path = reference.path_difference(own);
        for cell in self.cells.iter_mut().flatten() {
            cell.density *= area / light;
            cell.phase -= chief_phase;
            cell.path_difference -= chief_path;
        }
    }
}

/// Reference of phases: a point on the film and the sphere around it through the exit pupil.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ReferenceSphere {
    /// Point on the film (mm).
    pub point: [f64; 2],
    /// Position of the film behind the rear vertex (mm).
    pub film_distance: f64,
    /// Signed radius of the sphere: distance from the exit pupil to the film along the chief ray
    /// (mm), infinite for a telecentric lens.
    pub radius: f64,
}

impl ReferenceSphere {
    /// Returns the optical path of a ray to the plane wave of direction `t` through the reference
    /// point (mm). The ray may be slightly off `t`: its transverse aberration is the gradient.
    pub(super) fn phase(&self, ray: &FilmRay, t: [f64; 2]) -> f64 {
        // Second order: the aberration hardly changes within a hundredth of a cell.
        let off = [0, 1].map(|i| self.point[i] - ray.point[i]);
        ray.length + off[0] * t[0] + off[1] * t[1]
    }

    /// Returns the optical path of a ray to the reference sphere, plus the radius in the medium
    /// (mm).
    pub(super) fn path_difference(&self, ray: &FilmRay) -> f64 {
        let off = [self.point[0] - ray.point[0], self.point[1] - ray.point[1], 0.0];
        let n2 = dot(ray.t, ray.t);
        let n = n2.sqrt();
        // From the point on the film, along the ray, to the foot of the centre, and back by what
        // the sphere lies closer there: R - sqrt(R^2 - b^2).
        let foot = dot(off, ray.t) / n;
        let b2 = (dot(off, off) - foot * foot).max(0.0);
        let closer = match self.radius.is_finite() {
            // Of the same sign as the radius: paths shorten where it is positive.
            true => {
                b2 / (self.radius
                    + self.radius.signum() * (self.radius * self.radius - b2).max(0.0).sqrt())
            }
            false => 0.0,
        };
        ray.length + n * (foot + closer)
    }
}
