//! Rays of object points that are chosen once for many similar lenses.
//!
//! The rays go to the same cells of the stop of each lens. They are aimed exactly in a nominal lens;
//! in a changed one, the chief ray is found again, and the rays before the lens follow the change of
//! the map from them to the stop, to first order. A cell at the edge of the light is divided, so
//! that no figure of merit jumps when a rim moves by a micrometre, or it keeps the light that it has
//! in the nominal lens.

use super::chief::ChiefRay;
use super::hexapolar_cell::HexapolarCell;
use super::lens_at_wavelength::LensAtWavelength;
use petzval_base::lanes::{Real, f32x8};
use petzval_base::plane_newton::solve2;
use petzval_base::rays::{LensBatch, WAVE_SIZE};
use petzval_lens::LensRay;
use petzval_lens::Surface;
use petzval_lens::trace::trace;

/// Rays along each side of a cell, for the share of it that passes the rims.
const PARTS: usize = 4;

/// A cell of the stop with its ray.
#[derive(Clone, Debug)]
pub(super) struct FrozenRay {
    /// Pupil coordinates in the nominal lens, relative to its chief ray: of the middle of the cell,
    /// or of the part of it that passes.
    pub(super) pupil: [f64; 2],
    /// Light of the part that passes.
    pub(super) light: f64,
    /// Light of the whole cell.
    pub(super) whole: f64,
    /// Pupil coordinates of the parts of a cell near the edge of the light.
    parts: Option<Box<[[f64; 2]; PARTS * PARTS]>>,
}

/// Rays of an object point.
#[derive(Clone, Debug)]
pub(super) struct FrozenPupil {
    /// Chief ray of the nominal lens at the primary wavelength.
    pub(super) chief: ChiefRay,
    /// Stop coordinates by pupil coordinates at that chief ray.
    slopes: [[f64; 2]; 2],
    pub(super) rays: Vec<FrozenRay>,
}

impl FrozenPupil {
    /// Returns the columns of the map from pupil coordinates of the nominal lens to those of a
    /// changed one that meet the same point of the stop, to first order.
    pub(super) fn carried(
        &self,
        lens: &LensAtWavelength,
        chief: &ChiefRay,
    ) -> Option<[[f64; 2]; 2]> {
        let slopes = lens.stop_slopes(chief)?;
        Some([solve2(slopes, self.slopes[0])?, solve2(slopes, self.slopes[1])?])
    }

    /// Returns the pupil coordinates and the light of each cell, as rims cut it.
    pub(super) fn lit(
        &self,
        surfaces: &[Surface<f32>],
        batch: &mut LensBatch<f32>,
        blocked: &mut [u64],
        start: impl Fn([f64; 2]) -> Option<LensRay<f64>>,
    ) -> Vec<([f64; 2], f64)> {
        let edges: Vec<&[[f64; 2]; PARTS * PARTS]> =
            self.rays.iter().filter_map(|ray| ray.parts.as_deref()).collect();
        // Whole cells to a batch. A part without a start is dark.
        let mut passes = Vec::with_capacity(edges.len());
        for edges in edges.chunks(WAVE_SIZE / (PARTS * PARTS)) {
            let parts: Vec<Option<LensRay<f64>>> =
                edges.iter().flat_map(|parts| parts.iter().map(|part| start(*part))).collect();
            let dark = LensRay::new([f64::NAN; 3], [0.0, 0.0, 1.0]);
            fill::<f32x8>(batch, parts.len(), |i| parts[i].unwrap_or(dark));
            trace::<f32x8>(batch, surfaces, blocked);
            for cell in 0..edges.len() {
                passes.push((0..PARTS * PARTS).fold(0u32, |bits, i| {
                    bits | u32::from(!batch.x[cell * PARTS * PARTS + i].is_nan()) << i
                }));
            }
        }
        let mut passes = passes.into_iter();
        self.rays
            .iter()
            .map(|ray| match &ray.parts {
                None => (ray.pupil, ray.whole),
                Some(parts) => ray.cut(parts, passes.next().unwrap_or(0)),
            })
            .collect()
    }
}

impl FrozenRay {
    /// Returns the pupil coordinates of the middle of those parts that pass, given as bits, and
    /// their light.
    fn cut(&self, parts: &[[f64; 2]; PARTS * PARTS], passes: u32) -> ([f64; 2], f64) {
        let count = passes.count_ones();
        if count == 0 || count as usize == PARTS * PARTS {
            return (self.pupil, if count == 0 { 0.0 } else { self.whole });
        }
        let passing = || (0..PARTS * PARTS).filter(|i| passes >> i & 1 == 1);
        let mean = |axis: usize| passing().map(|i| parts[i][axis]).sum::<f64>() / f64::from(count);
        ([mean(0), mean(1)], self.whole * f64::from(count) / (PARTS * PARTS) as f64)
    }
}

impl LensAtWavelength {
    /// Chooses the rays of a chief ray; `reach` is the radius of the opening of the stop relative
    /// to the stop. `None` if no light passes.
    pub(super) fn freeze(&self, chief: &ChiefRay, rings: u32, reach: f64) -> Option<FrozenPupil> {
        let slopes = self.stop_slopes(chief)?;
        let mut rays = Vec::new();
        for ring in 0..=rings {
            for place in 0..(6 * ring).max(1) {
                let cell = HexapolarCell { ring, place, rings, reach };
                rays.extend(self.freeze_cell(chief, &cell));
            }
        }
        let lit = rays.iter().any(|ray: &FrozenRay| ray.light > 0.0);
        lit.then_some(FrozenPupil { chief: *chief, slopes, rays })
    }

    /// Returns a ray before the lens by pupil coordinates of the nominal lens, which `map` carries
    /// over to this one.
    pub(super) fn start(
        &self,
        chief: &ChiefRay,
        map: &[[f64; 2]; 2],
        [u, v]: [f64; 2],
    ) -> Option<LensRay<f64>> {
        let pupil = [0, 1].map(|i| map[0][i] * u + map[1][i] * v);
        let (start, direction, _) = self.scene_ray(chief, pupil)?;
        Some(LensRay::new(start, direction.map(|d| d * self.scene_index())))
    }

    /// Aims a ray at the middle of a cell of the stop; `None` if no light comes near the cell.
    fn freeze_cell(&self, chief: &ChiefRay, cell: &HexapolarCell) -> Option<FrozenRay> {
        let (pupil, stop, map) = self.aimed(chief, cell.point(0.5, 0.5))?;
        let at = |part: [f64; 2]| {
            let off = [0, 1].map(|i| part[i] - stop[i]);
            [0, 1].map(|i| pupil[i] + map[0][i] * off[0] + map[1][i] * off[1])
        };
        let place = |i: usize| (i as f64 + 0.5) / PARTS as f64;
        let parts: [[f64; 2]; PARTS * PARTS] = std::array::from_fn(|i| at(cell.part(i, PARTS)));
        let passes =
            |pupil: [f64; 2]| self.traced(chief, pupil).is_some_and(|ray| ray.clipped.is_none());
        // A cell and its neighbours.
        let around =
            |i: usize| cell.point(3.0 * place(i % PARTS) - 1.0, 3.0 * place(i / PARTS) - 1.0);
        let open = (0..PARTS * PARTS).filter(|&i| passes(at(around(i)))).count();
        let own = (0..PARTS * PARTS).fold(0u32, |bits, i| bits | u32::from(passes(parts[i])) << i);
        let full = open + own.count_ones() as usize == 2 * PARTS * PARTS;
        if open == 0 && own == 0 {
            return None;
        }
        let area = (map[0][0] * map[1][1] - map[0][1] * map[1][0]).abs();
        let whole = cell.area() * area * self.light_per_pupil(chief, pupil);
        let mut ray = FrozenRay { pupil, light: whole, whole, parts: None };
        if !full {
            (ray.pupil, ray.light) = ray.cut(&parts, own);
            ray.parts = Some(Box::new(parts));
        }
        Some(ray)
    }

    /// Returns the pupil coordinates of the ray through a point of the stop (relative to its
    /// radius), that point, and the change of the pupil coordinates by the point.
    #[allow(clippy::type_complexity, reason = "three vectors of one ray")]
    fn aimed(
        &self,
        chief: &ChiefRay,
        stop: [f64; 2],
    ) -> Option<([f64; 2], [f64; 2], [[f64; 2]; 2])> {
        let at = self.aimed_pupil(chief, stop)?;
        let ray = self.traced(chief, at)?;
        let unit = self.pupil_unit(chief) * 1e-5;
        let slope = |d: [f64; 2]| -> Option<[f64; 2]> {
            let near = self.traced(chief, [0, 1].map(|i| at[i] + d[i]))?;
            Some([0, 1].map(|i| (near.stop[i] - ray.stop[i]) / unit))
        };
        let slopes = [slope([unit, 0.0])?, slope([0.0, unit])?];
        Some((at, ray.stop, [solve2(slopes, [1.0, 0.0])?, solve2(slopes, [0.0, 1.0])?]))
    }
}

/// Fills a batch with rays of weight 1.
pub(super) fn fill<R: Real>(
    batch: &mut LensBatch<R::Scalar>,
    count: usize,
    start: impl Fn(usize) -> LensRay<f64>,
) {
    for i in 0..count {
        let LensRay { p, t, .. } = start(i);
        [batch.x[i], batch.y[i], batch.z[i]] = p.map(R::from_f64);
        [batch.tx[i], batch.ty[i], batch.tz[i]] = t.map(R::from_f64);
        batch.weight[i] = R::from_f64(1.0);
    }
    batch.resize::<R>(count);
}
