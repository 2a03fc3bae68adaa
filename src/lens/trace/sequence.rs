//! Sequence of the surfaces that rays meet on their way through a lens.

use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use super::frame_transform::FrameTransform;
use super::surface::{Approach, Surface, SurfaceKind, push};
use crate::prescription::Prescription;
use crate::prescription::coating::{Coating, CoatingModel};
use crate::prescription::pose::Outside;
use petzval_base::lanes::Real;
use petzval_spectrum::D_LINE;

/// Side of the lens that rays come from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Side {
    /// From a film at this distance behind the rear vertex (mm); rays go to the scene.
    Film(f64),
    /// From a plane at this distance before the front vertex (mm); rays go to the film.
    Scene(f64),
}

/// Direction of travel.
#[derive(Clone, Copy, PartialEq)]
enum Travel {
    ToFilm,
    ToScene,
}

/// Returns the surfaces of a lens in the order in which rays from a side meet them, with coatings
/// and absorption at the d line. A row that blocks in several ways gives several surfaces. Rays start in the plane
/// of [`Side`], and come out relative to the last vertex of the centred lens.
pub fn sequence<R: Real>(lens: &Prescription, from: Side) -> Vec<Surface<R::Scalar>> {
    sequence_at::<R>(lens, from, D_LINE)
}

/// Returns the same surfaces with coatings and absorption at a wavelength (nm). The indices are those of the lens.
pub fn sequence_at<R: Real>(lens: &Prescription, from: Side, nm: f64) -> Vec<Surface<R::Scalar>> {
    let count = lens.rows.len();
    let mut path = Builder::<R>::new(lens, nm);
    for i in 0..count {
        let first = |distance: f64| (i == 0).then_some(distance);
        match from {
            Side::Film(distance) => {
                path.refract(count - 1 - i, first(distance), Travel::ToScene);
            }
            Side::Scene(distance) => path.refract(i, first(distance), Travel::ToFilm),
        }
    }
    path.finish(match from {
        Side::Film(_) => Travel::ToScene,
        Side::Scene(_) => Travel::ToFilm,
    })
}

/// Returns the surfaces that light of a wavelength (nm) meets from the scene to the film if the
/// second of two rows reflects it back to the first, and the first reflects it to the film again.
/// Rays start at the front vertex.
pub fn ghost_sequence<R: Real>(
    lens: &Prescription,
    [first, second]: [usize; 2],
    nm: f64,
) -> Vec<Surface<R::Scalar>> {
    let mut path = Builder::<R>::new(lens, nm);
    for row in 0..second {
        path.refract(row, (row == 0).then_some(0.0), Travel::ToFilm);
    }
    path.reflect(second, (second == 0).then_some(0.0), Travel::ToFilm);
    for row in (first + 1..second).rev() {
        path.refract(row, None, Travel::ToScene);
    }
    path.reflect(first, None, Travel::ToScene);
    for row in first + 1..lens.rows.len() {
        path.refract(row, None, Travel::ToFilm);
    }
    path.finish(Travel::ToFilm)
}

/// Builder of a sequence, row by row.
struct Builder<'a, R: Real> {
    lens: &'a Prescription,
    nm: f64,
    /// Semi-diameter of the row crossed before.
    height: f64,
    /// Sag at its rim, in the direction of travel.
    sag: f64,
    /// Index of that row.
    crossed: Option<usize>,
    /// Transforms of the rows from their own frames; empty if the lens is centred.
    placements: Vec<DAffine3>,
    /// Directions of travel before each row and behind the last, as of [`Prescription::travels`].
    travels: Vec<f64>,
    surfaces: Vec<Surface<R::Scalar>>,
}

impl Travel {
    /// Returns the direction of travel along z in a lens without mirrors.
    fn sign(self) -> f64 {
        match self {
            Self::ToFilm => 1.0,
            Self::ToScene => -1.0,
        }
    }
}

impl<'a, R: Real> Builder<'a, R> {
    fn new(lens: &'a Prescription, nm: f64) -> Self {
        let placements = if lens.is_misaligned() { lens.surface_transforms() } else { Vec::new() };
        let surfaces = Vec::with_capacity(lens.rows.len());
        let travels = lens.travels();
        Self { lens, nm, height: 0.0, sag: 0.0, crossed: None, placements, travels, surfaces }
    }

    /// Appends a row that refracts, at its thickness or another distance from the one before.
    fn refract(&mut self, row: usize, distance: Option<f64>, travel: Travel) {
        self.push(row, distance, travel, false);
    }

    /// Appends a row that reflects.
    fn reflect(&mut self, row: usize, distance: Option<f64>, travel: Travel) {
        self.push(row, distance, travel, true);
    }

    fn push(&mut self, row: usize, distance: Option<f64>, travel: Travel, mirror: bool) {
        let Self { lens, nm, .. } = *self;
        let rows = &lens.rows;
        let between = if travel == Travel::ToFilm { row.wrapping_sub(1) } else { row };
        let [before, behind] = lens.indices(row);
        let (sign, n, n_after) = match travel {
            Travel::ToFilm => (self.travels[row], before, behind),
            Travel::ToScene => (-self.travels[row + 1], behind, before),
        };
        // Behind an odd number of mirrors thicknesses are negative.
        let unfolded = sign * travel.sign();
        let advance = distance.unwrap_or_else(|| unfolded * rows[between].thickness);
        let mirror = mirror || rows[row].mirror;
        let half = rows[row].diameter / 2.0;
        let sag = rows[row].sag(half);
        let spread = match self.crossed {
            Some(_) => [self.height, self.sag],
            None => [advance.abs() + half, 0.0],
        };
        let first = self.crossed.is_none();
        let absorption = match distance {
            None => rows[between].glass.absorption(nm),
            Some(_) => 0.0,
        };
        let mut approach =
            Approach { row, advance, sign, n, n_after, spread, first, mirror, absorption, nm };
        let start = distance.map_or(0.0, |distance| match travel {
            Travel::ToFilm => -distance,
            Travel::ToScene => unfolded * distance,
        });
        if let Some(mut motion) = self.transform_to(Some(row), start, travel, sign) {
            // The translation along z stays with the surface, as in a centred lens.
            approach.advance = -motion.translation.z;
            motion.translation.z = 0.0;
            self.push_transform(row, &motion);
        }
        (self.height, self.sag, self.crossed) = (half, sign * sag, Some(row));
        push::<R>(&rows[row], &approach, &mut self.surfaces);
    }

    /// Returns the surfaces, for rays that come out in this direction.
    fn finish(mut self, travel: Travel) -> Vec<Surface<R::Scalar>> {
        let sign = match travel {
            Travel::ToFilm => self.lens.travel_before(self.lens.rows.len()),
            Travel::ToScene => -1.0,
        };
        if let Some(motion) = self.transform_to(None, 0.0, travel, sign) {
            self.push_transform(self.crossed.unwrap_or(0), &motion);
        }
        self.surfaces
    }

    /// Returns the transform from the frame of the row crossed before to that of the next, +z along
    /// the way, unless they are aligned. Before the first row the frame is that of a plane at
    /// `start`: mm from the front vertex, or from the rear vertex along the film's axis. Behind the
    /// last row it is that of the last vertex of the centred lens. `sign` is 1 where the way leads
    /// along +z of lens space.
    fn transform_to(
        &self,
        next: Option<usize>,
        start: f64,
        travel: Travel,
        sign: f64,
    ) -> Option<DAffine3> {
        // A row of a lens is crossed before or next, so that one end at most is outside.
        let outside = match (travel, self.crossed) {
            (Travel::ToFilm, None) | (Travel::ToScene, Some(_)) => Outside::Scene,
            (Travel::ToScene, None) | (Travel::ToFilm, Some(_)) => Outside::Film,
        };
        if self.placements.is_empty() || self.lens.aligned(self.crossed, next, outside) {
            return None;
        }
        let at = |z: f64| DAffine3::from_translation(DVec3::new(0.0, 0.0, z));
        let end = |z: f64| match outside {
            Outside::Scene => at(z),
            Outside::Film => self.lens.film_axis() * at(z),
        };
        let from = self.crossed.map_or_else(|| end(start), |row| self.placements[row]);
        let to = next.map_or_else(|| end(0.0), |row| self.placements[row]);
        let flip = DAffine3::from_mat3(DMat3::from_diagonal(DVec3::new(1.0, 1.0, sign)));
        Some(flip * to.inverse() * from * flip)
    }

    /// Appends a frame transform on the way to a row, or behind it.
    fn push_transform(&mut self, row: usize, motion: &DAffine3) {
        let zero = R::from_f64(0.0);
        self.surfaces.push(Surface {
            row,
            kind: SurfaceKind::FrameTransform(Arc::new(FrameTransform::new::<R>(motion))),
            far: false,
            entrance: false,
            stop: false,
            advance: zero,
            curvature: zero,
            n2: zero,
            n2_step: zero,
            aperture2: zero,
            limit: zero,
            uncertainty: zero,
            mirror: false,
            absorption: None,
            coating: CoatingModel::new::<R>(&Coating::Bare, [1.0; 2], self.nm),
        });
    }
}

impl Prescription {
    /// Returns the number of frame transforms on the way of a ray through the lens.
    pub fn frame_transforms(&self) -> usize {
        let surfaces = sequence::<f64>(self, Side::Scene(1.0));
        let is_transform =
            |surface: &&Surface<f64>| matches!(surface.kind, SurfaceKind::FrameTransform(_));
        surfaces.iter().filter(is_transform).count()
    }
}
