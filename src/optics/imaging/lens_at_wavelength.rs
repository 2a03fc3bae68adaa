//! A lens at one wavelength, prepared for rays from an object, from the stop and to the film.

use super::conditions::ImagingConditions;
use petzval_base::lanes::{Real, f32x8};
use petzval_lens::ChiefRayFinder;
use petzval_lens::LensRay;
use petzval_lens::Paraxial;
use petzval_lens::Prescription;
use petzval_lens::Side;
use petzval_lens::Surface;
use petzval_lens::sequence_at;
use petzval_lens::{OpticalPath, PASSES, trace_past_rims};
use petzval_spectrum::IndexRangeError;

/// Eight lanes of f64.
type Packet = <f32x8 as Real>::Double;

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
    /// Its chief rays.
    pub chief_rays: ChiefRayFinder,
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

/// Rays at the film, in lanes.
struct FilmRays<R> {
    point: [R; 2],
    t: [R; 3],
    length: R,
    stop: [R; 2],
    clipped: R,
}

impl<R: Real<Scalar = f64>> FilmRays<R> {
    fn lane(&self, i: usize) -> FilmRays<f64> {
        let one = |value: R| {
            let mut lanes = [0.0; 8];
            value.store(&mut lanes);
            lanes[i]
        };
        FilmRays {
            point: self.point.map(one),
            t: self.t.map(one),
            length: one(self.length),
            stop: self.stop.map(one),
            clipped: one(self.clipped),
        }
    }
}

impl FilmRays<f64> {
    /// Returns the ray; `None` if it was lost, or leaves the film behind.
    fn ray(self) -> Option<FilmRay> {
        let Self { point, t, length, stop, clipped } = self;
        let valid = t[2] > 0.0 && length.is_finite() && point.iter().all(|x| x.is_finite());
        let clipped = (clipped != PASSES).then_some(clipped as usize);
        valid.then_some(FilmRay { point, t, length, stop, clipped })
    }
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
        let size = lens.rows.iter().map(|row| row.diameter).fold(lens.length().abs(), f64::max);
        Ok(Self {
            nm: line.nm,
            weight: line.weight,
            paraxial: Paraxial::new(&lens),
            chief_rays: ChiefRayFinder::new(&lens),
            scene_index: lens.index_before(0),
            stop_radius: lens.rows[stop].diameter / 2.0,
            surfaces: sequence_at::<f64>(&lens, Side::Scene(0.0), line.nm),
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
        self.at_film(trace_past_rims::<f64>(LensRay::new(start, t), &self.surfaces)).ray()
    }

    /// Does the same for many rays, given by start and direction, eight at a time.
    pub(super) fn all_to_film(&self, rays: &[([f64; 3], [f64; 3])]) -> Vec<Option<FilmRay>> {
        let mut found = Vec::with_capacity(rays.len());
        for group in rays.chunks(Packet::LANES) {
            // The last packet is filled up with its last ray.
            let lane = |i: usize| group[i.min(group.len() - 1)];
            let load = |of: &dyn Fn(usize) -> f64| {
                let mut lanes = [0.0; Packet::LANES];
                for (i, value) in lanes.iter_mut().enumerate() {
                    *value = of(i);
                }
                Packet::load(&lanes)
            };
            let start = [0, 1, 2].map(|k| load(&|i| lane(i).0[k]));
            let t = [0, 1, 2].map(|k| load(&|i| lane(i).1[k] * self.scene_index));
            let path = trace_past_rims::<Packet>(LensRay::new(start, t), &self.surfaces);
            let rays = self.at_film(path);
            found.extend((0..group.len()).map(|i| rays.lane(i).ray()));
        }
        found
    }

    fn at_film<R: Real<Scalar = f64>>(&self, path: OpticalPath<R>) -> FilmRays<R> {
        let LensRay { p: [x, y, z], t, .. } = path.ray;
        let s = (R::splat(self.film_distance) - z) / t[2];
        let n2 = t[0].mul_add(t[0], t[1].mul_add(t[1], t[2] * t[2]));
        let radius = R::splat(self.stop_radius);
        FilmRays {
            point: [s.mul_add(t[0], x), s.mul_add(t[1], y)],
            t,
            length: s.mul_add(n2, path.length),
            stop: [path.stop[0] / radius, path.stop[1] / radius],
            clipped: path.clipped,
        }
    }
}
