//! Chief rays: the rays through the centre of the stop.

use super::bundle::to_camera;
use super::pixel_grid::SightLine;
use petzval_base::plane_newton::PlaneNewton;
use petzval_lens::LensRay;
use petzval_lens::RealLens;
use petzval_lens::Surface;
use petzval_lens::trace_one;
use petzval_lens::{KeptRims, open_rims};
use petzval_lens::{Side, sequence};

/// Search for the centre of the stop (mm).
const NEWTON: PlaneNewton = PlaneNewton { difference: 1e-4, precision: 1e-9, acceptable: 1e-6 };

/// Finds chief rays, in f64, with all rims open.
pub(super) struct ChiefFinder<'a> {
    lens: &'a RealLens,
    surfaces: Vec<Surface<f64>>,
    /// Number of surfaces from the film to the stop.
    to_stop: usize,
    /// Offset of the last chief ray in the plane of the rear vertex from the line to the centre of
    /// the exit pupil (mm).
    last: [f64; 2],
}

impl<'a> ChiefFinder<'a> {
    pub fn new(lens: &'a RealLens) -> Self {
        let open = open_rims(&lens.prescription, KeptRims::None);
        let surfaces = sequence::<f64>(&open, Side::Film(lens.film_distance));
        let stop = lens.prescription.stop();
        let to_stop = surfaces.iter().filter(|surface| surface.row >= stop).count();
        Self { lens, surfaces, to_stop, last: [0.0; 2] }
    }

    /// Returns the chief ray of a film point (mm, the film's frame), by Newton's method. Each search
    /// starts where the last one ended, so that neighbours must follow each other.
    pub fn find(&mut self, film: [f64; 2]) -> Option<SightLine> {
        let place = self.lens.film_pose.film_point(film);
        let distance = self.lens.film_distance;
        // The pupil moves by this share of the film point's height.
        let behind = -self.lens.paraxial.exit_pupil.position;
        let drift = if behind.is_finite() { behind / (distance + behind) } else { 1.0 };
        let expected = [0, 1].map(|i| place[i] * drift);
        let start = [0, 1].map(|i| expected[i] + self.last[i]);
        let at = NEWTON.solve(start, |at| self.at_stop(place, at))?;
        self.last = [0, 1].map(|i| at[i] - expected[i]);
        let ray = trace_one::<f64>(self.towards(place, at), &self.surfaces).ok()?;
        let depth = self.lens.prescription.film_position(distance);
        Some(to_camera(ray.p, ray.t, depth))
    }

    fn towards(&self, [x, y, z]: [f64; 3], [u, v]: [f64; 2]) -> LensRay<f64> {
        let t = [u - x, v - y, self.lens.film_distance - z];
        let length = t.iter().map(|v| v * v).sum::<f64>().sqrt();
        let index = self.lens.prescription.rear().index;
        LensRay::new([x, y, z], t.map(|v| v * index / length))
    }

    /// Returns where the ray to a point of the plane of the rear vertex meets the stop (mm from its
    /// centre).
    fn at_stop(&self, place: [f64; 3], at: [f64; 2]) -> Option<[f64; 2]> {
        let ray = trace_one::<f64>(self.towards(place, at), &self.surfaces[..self.to_stop]).ok()?;
        Some([ray.p[0], ray.p[1]])
    }
}
