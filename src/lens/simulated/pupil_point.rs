//! Where in the entrance pupil a ray from the film goes, by first-order optics.

use super::gaussian::{thick, unclipped};
use crate::lens::camera::RealLens;
use crate::lens::refract::LensRay;
use crate::lens::surface::{From, Surface, sequence};
use crate::lens::trace::trace_one;

/// Takes rays to the entrance pupil of a lens.
pub(in crate::lens) struct PupilPoint(Vec<Surface<f64>>);

impl PupilPoint {
    pub fn new(lens: &RealLens) -> Self {
        let ideal = unclipped(thick(&lens.plain(), &lens.film));
        Self(sequence::<f64>(&ideal, From::Film(lens.film_distance)))
    }

    /// Where a ray that leaves the film crosses the plane `z` mm before the front vertex, mm from the
    /// axis.
    pub fn of(&self, ray: LensRay<f64>, z: f64) -> Option<[f64; 2]> {
        let LensRay { p, t, .. } = trace_one::<f64>(ray, &self.0).ok()?;
        let s = (z - p[2]) / t[2];
        let point = [p[0] + s * t[0], p[1] + s * t[1]];
        point.iter().all(|v| v.is_finite()).then_some(point)
    }
}
