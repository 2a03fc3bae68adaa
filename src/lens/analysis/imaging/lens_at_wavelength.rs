//! A lens at one wavelength, prepared for rays from an object, from the stop and to the film.

use super::conditions::ImagingConditions;
use crate::lens::analysis::paraxial::Paraxial;
use crate::lens::prescription::Prescription;
use crate::lens::trace::kernel::LensRay;
use crate::lens::trace::path::{OpticalPath, trace_past_rims};
use crate::lens::trace::sequence::{Side, sequence_at};
use crate::lens::trace::surface::{Surface, SurfaceKind};
use crate::spectrum::glass::IndexRangeError;

/// Distance before the front vertex at which rays start, relative to the size of the lens.
const START: f64 = 2.0;

/// A lens at one wavelength.
#[derive(Clone, Debug)]
pub(super) struct LensAtWavelength {
    /// Wavelength (nm).
    pub nm: f64,
    /// Relative weight of the wavelength.
    pub weight: f64,
    /// First-order data at the wavelength.
    pub paraxial: Paraxial,
    /// Surfaces from the scene to the film; rays start at the front vertex.
    surfaces: Vec<Surface<f64>>,
    /// Surfaces from the stop to the film; rays start at the vertex of the stop, before it.
    behind_stop: Vec<Surface<f64>>,
    /// Surfaces from the stop to the scene, in this order; rays start at the vertex of the stop.
    before_stop: Vec<Surface<f64>>,
    /// Index of the medium before the stop.
    stop_index: f64,
    /// Index of the medium before the lens.
    scene_index: f64,
    /// Radius of the stop (mm).
    pub stop_radius: f64,
    /// Distance from the rear vertex to the film (mm).
    pub film_distance: f64,
    /// Distance from the front vertex to the object (mm).
    pub object_distance: f64,
    /// Distance before a point of the front surface from which no surface is in the way (mm).
    pub run_up: f64,
}

/// A ray before the lens, in the frame of the front vertex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SceneRay {
    /// A point on the ray (mm).
    pub point: [f64; 3],
    /// Unit direction, towards the film.
    pub direction: [f64; 3],
}

/// A ray at the film.
#[derive(Clone, Copy, Debug)]
pub(super) struct FilmRay {
    /// Point on the film (mm from the axis).
    pub point: [f64; 2],
    /// Direction times the index.
    pub t: [f64; 3],
    /// Optical path length from the start of the ray (mm).
    pub length: f64,
    /// Point in the stop, relative to its radius.
    pub stop: [f64; 2],
    /// First row that would have blocked the ray.
    pub clipped: Option<usize>,
}

impl LensAtWavelength {
    pub(super) fn new(
        lens: &Prescription,
        conditions: &ImagingConditions,
        wavelength: usize,
    ) -> Result<Self, IndexRangeError> {
        let line = conditions.wavelengths[wavelength];
        let lens = lens.at_wavelength(line.nm)?;
        let stop = lens.stop();
        let surfaces = sequence_at::<f64>(&lens, Side::Scene(0.0), line.nm);
        let mut behind_stop: Vec<Surface<f64>> = surfaces
            .iter()
            .filter(|surface| surface.row >= stop)
            .skip_while(|surface| matches!(surface.kind, SurfaceKind::FrameTransform(_)))
            .cloned()
            .collect();
        behind_stop[0].advance = 0.0;
        let before_stop = sequence_at::<f64>(&lens, Side::Film(0.0), line.nm)
            .into_iter()
            .skip_while(|surface| surface.row >= stop)
            .collect();
        let size = lens.rows.iter().map(|row| row.diameter).fold(lens.length().abs(), f64::max);
        Ok(Self {
            nm: line.nm,
            weight: line.weight,
            paraxial: Paraxial::new(&lens),
            stop_index: lens.index_before(stop),
            scene_index: lens.index_before(0),
            stop_radius: lens.rows[stop].diameter / 2.0,
            surfaces,
            behind_stop,
            before_stop,
            film_distance: conditions.film_distance,
            object_distance: conditions.object_distance,
            run_up: START * size,
        })
    }

    /// Returns the index of the medium before the lens.
    pub(super) fn scene_index(&self) -> f64 {
        self.scene_index
    }

    /// Returns the wavelength (mm).
    pub(super) fn wavelength(&self) -> f64 {
        self.nm * 1e-6
    }

    /// Traces a ray from a point before the lens (mm, frame of the front vertex) to the film, past
    /// all rims. `None` if it misses a surface or is totally reflected.
    pub(super) fn to_film(&self, start: [f64; 3], direction: [f64; 3]) -> Option<FilmRay> {
        let t = direction.map(|d| d * self.scene_index);
        let path = trace_past_rims(LensRay::new(start, t), &self.surfaces).ok()?;
        self.at_film(&path)
    }

    fn at_film(&self, path: &OpticalPath) -> Option<FilmRay> {
        let LensRay { p, t, .. } = path.ray;
        let s = (self.film_distance - p[2]) / t[2];
        let n2 = t.iter().map(|t| t * t).sum::<f64>();
        let point = [0, 1].map(|i| p[i] + s * t[i]);
        let stop = path.stop.unwrap_or([0.0; 2]).map(|x| x / self.stop_radius);
        let valid = t[2] > 0.0 && point.iter().all(|x| x.is_finite());
        valid.then_some(FilmRay {
            point,
            t,
            length: path.length + s * n2,
            stop,
            clipped: path.clipped,
        })
    }

    /// Traces the chief ray of a slope: through the vertex of the stop, with these direction
    /// cosines across the axis there. Returns it before the lens, and its point on the film.
    pub(super) fn chief(&self, cosines: [f64; 2]) -> Option<(SceneRay, [f64; 2])> {
        let [a, b] = cosines;
        let along = 1.0 - a * a - b * b;
        if along <= 0.0 {
            return None;
        }
        let n = self.stop_index;
        let along = n * along.sqrt();
        let start = |t: [f64; 3]| LensRay::new([0.0; 3], t);
        let to_film = trace_past_rims(start([n * a, n * b, along]), &self.behind_stop).ok()?;
        let film = self.at_film(&to_film)?.point;
        let back = trace_past_rims(start([-n * a, -n * b, along]), &self.before_stop).ok()?.ray;
        let [x, y, z] = back.p;
        let [tx, ty, tz] = back.t.map(|t| t / self.scene_index);
        Some((SceneRay { point: [x, y, -z], direction: [-tx, -ty, tz] }, film))
    }
}
