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
use super::reference_sphere::ReferenceSphere;

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

impl LensAtWavelength {
    pub(super) fn traced(&self, chief: &ChiefRay, pupil: [f64; 2]) -> Option<FilmRay> {
        let (start, direction, before) = self.scene_ray(chief, pupil)?;
        let mut ray = self.to_film(start, direction)?;
        ray.length += before;
        Some(ray)
    }

    /// Traces the rays of many pupil coordinates.
    pub(super) fn all_traced(&self, chief: &ChiefRay, pupil: &[[f64; 2]]) -> Vec<Option<FilmRay>> {
        let starts: Vec<_> = pupil.iter().map(|at| self.scene_ray(chief, *at)).collect();
        let rays: Vec<_> =
            starts.iter().flatten().map(|(start, direction, _)| (*start, *direction)).collect();
        let mut traced = self.all_to_film(&rays).into_iter();
        starts
            .into_iter()
            .map(|start| {
                let (.., before) = start?;
                let ray = traced.next()??;
                Some(FilmRay { length: ray.length + before, ..ray })
            })
            .collect()
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
        let within: Vec<usize> = (0..side * side).filter(|i| inside(grid.direction(*i))).collect();
        let places: Vec<[f64; 2]> = within.iter().map(|i| map.value(grid.direction(*i))).collect();
        let mut rays: Vec<Option<FilmRay>> = vec![None; side * side];
        for (i, ray) in within.iter().zip(self.all_traced(chief, &places)) {
            rays[*i] = ray;
        }
        let open: Vec<bool> =
            rays.iter().map(|ray| ray.is_some_and(|ray| ray.clipped.is_none())).collect();
        let edges: Vec<usize> = (0..side * side)
            .filter(|&i| {
                let passing = neighbours(i, side).filter(|j| open[*j]).count();
                passing > 0 && passing < neighbours(i, side).count()
            })
            .collect();
        let mut edge_cells = vec![None; side * side];
        for (i, edge) in edges.iter().zip(self.edges(chief, &map, &grid, &edges)) {
            edge_cells[*i] = Some(edge);
        }
        for i in 0..side * side {
            // A cell at the edge stands for the part that passes.
            let (share, point, ray) = match (edge_cells[i], rays[i]) {
                (Some(None), _) | (None, None) => continue,
                (Some(Some(edge)), ray) => (edge.share, edge.point, ray.unwrap_or(edge.ray)),
                (None, Some(ray)) if open[i] => (1.0, ray.point, ray),
                (None, Some(_)) => continue,
            };
            let t = grid.direction(i);
            let (pupil, jacobian) = map.evaluate(t);
            grid.cells[i] = Some(PupilCell {
                share,
                density: jacobian.abs() * self.light_per_pupil(chief, pupil),
                phase: reference.phase(&ray, t),
                point,
                t_z: ray.t[2],
                stop: ray.stop,
                path_difference: reference.path_difference(&ray),
            });
        }
        grid.normalize(reference, &own);
        Some(grid)
    }

    /// Returns the light per unit area of pupil coordinates, for an object that radiates evenly.
    pub(super) fn light_per_pupil(&self, chief: &ChiefRay, [u, v]: [f64; 2]) -> f64 {
        match chief.object {
            ObjectPoint::Distant(_) => 1.0,
            // cos(theta) dOmega, with dOmega = du dv / w.
            ObjectPoint::Near(_) => {
                let direction = self.scene_ray(chief, [u, v]).map_or(0.0, |(_, d, _)| d[2]);
                direction / (1.0 - u * u - v * v).max(f64::EPSILON).sqrt()
            }
        }
    }

    /// Returns the parts of cells that pass; `None` where nothing does.
    fn edges(
        &self,
        chief: &ChiefRay,
        map: &PolynomialMap,
        grid: &PupilGrid,
        cells: &[usize],
    ) -> Vec<Option<CellEdge>> {
        let place = |i: usize| grid.step * ((i as f64 + 0.5) / EDGE as f64 - 0.5);
        let parts = |cell: &usize| {
            let [x, y] = grid.direction(*cell);
            (0..EDGE * EDGE).map(move |i| map.value([x + place(i % EDGE), y + place(i / EDGE)]))
        };
        let places: Vec<[f64; 2]> = cells.iter().flat_map(parts).collect();
        let rays = self.all_traced(chief, &places);
        let part = |rays: &[Option<FilmRay>]| {
            let passing = || rays.iter().flatten().filter(|ray| ray.clipped.is_none());
            let count = passing().count() as f64;
            let mean = |i: usize| passing().map(|ray| ray.point[i]).sum::<f64>() / count;
            let ray = *passing().next_back()?;
            let share = count / (EDGE * EDGE) as f64;
            Some(CellEdge { share, point: [mean(0), mean(1)], ray })
        };
        rays.chunks(EDGE * EDGE).map(part).collect()
    }
}

/// The part of a cell that passes.
#[derive(Clone, Copy)]
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
