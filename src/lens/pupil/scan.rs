//! Scan of the plane of the rear vertex: the points through which a film point sees light, in f32.
//!
//! Pupil tables and exit pupils are found by it. The analysis of images has a search of its own, from
//! the object and in f64.

use super::outline::PupilBox;
use crate::prescription::Prescription;
use crate::trace::sequence::{Side, sequence};
use crate::trace::surface::Surface;
use crate::trace::trace;
use petzval_base::lanes::f32x8;
use petzval_base::rays::{LensBatch, WAVE_SIZE};

/// Most boxes of a search.
const ROUNDS: usize = 24;

/// Returns the surfaces from the film to the scene. Outlines and shares of light need no exact
/// directions, so no ray is retraced in f64.
pub(crate) fn rough_surfaces(lens: &Prescription, distance: f64) -> Vec<Surface<f32>> {
    let mut surfaces = sequence::<f32>(lens, Side::Film(distance));
    surfaces.iter_mut().for_each(|surface| surface.uncertainty = 0.0);
    surfaces
}

/// Traces rays from film points, given in the frame of the lens: x, y, and z towards the scene from
/// the plane of the untilted film (mm).
#[derive(Clone, Debug)]
pub(crate) struct PupilScan {
    surfaces: Vec<Surface<f32>>,
    /// Index of the medium before the film.
    index: f64,
    /// Distance from the rear vertex to the film (mm).
    distance: f64,
    batch: Box<LensBatch<f32>>,
    ignored: Vec<u64>,
}

impl PupilScan {
    /// Makes a scan through some of the surfaces of a lens.
    pub fn new(lens: &Prescription, distance: f64, surfaces: Vec<Surface<f32>>) -> Self {
        let (index, ignored) = (lens.rear().index, vec![0; lens.rows.len()]);
        Self { surfaces, index, distance, batch: Box::default(), ignored }
    }

    /// Returns the direction from a film point to a point of the plane, of the length of the index.
    pub fn towards(&self, [x, y, z]: [f64; 3], [u, v]: [f64; 2]) -> [f64; 3] {
        let [x, y, z] = [u - x, v - y, self.distance - z];
        let scale = self.index / (x * x + y * y + z * z).sqrt();
        [x * scale, y * scale, z * scale]
    }

    /// Traces rays from a film point to points of the plane, and gives `see` the number and the
    /// transmittance, 0 to 1, of each that passes.
    pub fn trace(
        &mut self,
        film: [f64; 3],
        count: usize,
        at: impl Fn(usize) -> [f64; 2],
        mut see: impl FnMut(usize, f32),
    ) {
        for start in (0..count).step_by(WAVE_SIZE) {
            let rays = WAVE_SIZE.min(count - start);
            for i in 0..rays {
                let [tx, ty, tz] = self.towards(film, at(start + i));
                let batch = &mut *self.batch;
                [batch.x[i], batch.y[i], batch.z[i]] = film.map(|v| v as f32);
                (batch.tx[i], batch.ty[i], batch.tz[i]) = (tx as f32, ty as f32, tz as f32);
                batch.weight[i] = 1.0;
            }
            let batch = &mut *self.batch;
            batch.resize::<f32x8>(rays);
            trace::<f32x8>(batch, &self.surfaces, &mut self.ignored);
            let passing = (0..rays).filter(|&i| !batch.x[i].is_nan());
            passing.for_each(|i| see(start + i, batch.weight[i]));
        }
    }
}

/// Points of a box in columns and rows, edges included.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxGrid {
    corner: [f64; 2],
    cell: [f64; 2],
    points: usize,
}

impl BoxGrid {
    fn new(pupil_box: PupilBox, points: usize) -> Self {
        let cell = pupil_box.size().map(|size| size / (points - 1) as f64);
        Self { corner: pupil_box.corner(), cell, points }
    }

    /// Returns the number of points.
    pub fn len(self) -> usize {
        self.points * self.points
    }

    /// Returns a point.
    #[inline(always)]
    pub fn at(self, i: usize) -> [f64; 2] {
        let at = [i % self.points, i / self.points];
        [0, 1].map(|axis| self.corner[axis] + self.cell[axis] * at[axis] as f64)
    }
}

/// Search for a tight box around the light.
#[derive(Clone, Copy, Debug)]
pub(crate) struct BoxSearch {
    /// Points along each side of a box.
    pub points: usize,
    /// Margin around the points that see light, in steps between points.
    pub margin: f64,
    /// Whether the light is symmetric in v.
    pub mirrored: bool,
}

impl BoxSearch {
    /// Zooms in until the light fills half of the box in both directions. `lit` returns which
    /// points of a grid see light. `None` if none does.
    pub fn zoom(
        self,
        mut pupil_box: PupilBox,
        mut lit: impl FnMut(BoxGrid) -> Vec<bool>,
    ) -> Option<PupilBox> {
        let Self { points, margin, mirrored } = self;
        for _ in 0..ROUNDS {
            let (grid, size) = (BoxGrid::new(pupil_box, points), pupil_box.size());
            let lit = lit(grid);
            let seen: Vec<_> = (0..lit.len()).filter(|&i| lit[i]).map(|i| grid.at(i)).collect();
            if seen.is_empty() {
                return None;
            }
            let tight = PupilBox::around(&seen).grown(grid.cell.map(|side| margin * side));
            let tight = if mirrored { tight.mirrored() } else { tight };
            let filled = (0..2).all(|i| tight.size()[i] > 0.5 * size[i]);
            pupil_box = tight;
            if filled {
                return Some(pupil_box);
            }
        }
        None
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_search_finds_a_small_pupil_and_its_mirror_image() {
        // A disk of radius 0.1 about (3, 0.2).
        let sees = |[u, v]: [f64; 2]| (u - 3.0).hypot(v - 0.2) < 0.1;
        let lit = |grid: BoxGrid| (0..grid.len()).map(|i| sees(grid.at(i))).collect();
        let first = PupilBox::around(&[[0.0, -2.0], [4.0, 2.0]]);
        for (mirrored, low) in [(false, 0.1), (true, -0.3)] {
            let search = BoxSearch { points: 65, margin: 1.0, mirrored };
            let found = search.zoom(first, lit).expect("light");
            let ([u, v], size) = (found.corner(), found.size());
            for (end, expected) in
                [u, u + size[0], v, v + size[1]].into_iter().zip([2.9, 3.1, low, 0.3])
            {
                assert!((end - expected).abs() < 0.03, "{found:?}");
            }
        }
    }
}
