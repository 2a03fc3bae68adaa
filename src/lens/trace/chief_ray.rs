//! Chief rays: the rays through the vertex of the stop.
//!
//! Chief rays start at the vertex of the stop and leave to both sides, so that they pass the middle
//! of the stop by construction, whatever rims are in the way. Newton's method finds the direction at
//! the stop that belongs to a point of the film or of the object, and follows the point from the
//! axis. The trace is in f64.
//!
//! This is the only search for chief rays. [`Paraxial::chief_slope`](crate::Paraxial::chief_slope) is
//! the chief ray of first-order optics, in closed form. Readers of lens files complete diameters by rays
//! through other points of the stop too, at a given angle to the axis and within the rims.

use super::kernel::LensRay;
use super::sequence::{Side, sequence};
use super::single::trace_one;
use super::surface::{Surface, SurfaceKind, open_surfaces};
use crate::prescription::Prescription;
use petzval_base::lanes::Real;
use petzval_base::plane_newton::PlaneNewton;

/// Step of the finite differences, as a direction cosine.
const DIFFERENCE: f64 = 1e-6;
/// Relative precision of the point.
const PRECISION: f64 = 1e-13;
/// First, longest and shortest step along the field, as shares of it.
const FIRST: f64 = 1.0 / 64.0;
const LONGEST: f64 = 1.0 / 4.0;
const SHORTEST: f64 = 1.0 / 1024.0;
/// Largest distance of a solution from its extrapolation, relative to the extrapolated step.
const LARGEST_MISS: f64 = 0.25;

/// A ray through the vertex of the stop: the chief ray of the points that it meets.
#[derive(Clone, Copy, Debug)]
pub struct StopRay {
    /// Direction cosines across the axis at the stop, towards the film.
    pub cosines: [f64; 2],
    /// The ray behind the lens, towards the film, in the frame of the rear vertex (mm, +z along
    /// the way).
    pub film: LensRay<f64>,
    /// The ray before the lens, from the film to the scene, in the frame of the front vertex (mm,
    /// +z towards the scene).
    pub scene: LensRay<f64>,
}

impl StopRay {
    /// Returns its point (mm) in a plane across the axis, `distance` mm behind the rear vertex.
    pub fn film_point(&self, distance: f64) -> [f64; 2] {
        let LensRay { p: [x, y, z], t: [tx, ty, tz], .. } = self.film;
        let s = (distance - z) / tz;
        [Real::mul_add(s, tx, x), Real::mul_add(s, ty, y)]
    }
}

/// Finder of the chief rays of a lens.
#[derive(Clone, Debug)]
pub struct ChiefRayFinder {
    /// Surfaces from the stop to the film; rays start at the vertex of the stop, before it.
    to_film: Vec<Surface<f64>>,
    /// Surfaces from the stop to the scene; rays start at the vertex of the stop.
    to_scene: Vec<Surface<f64>>,
    /// Index of the medium before the stop.
    index: f64,
}

impl ChiefRayFinder {
    /// Prepares a lens with its present indices.
    pub fn new(lens: &Prescription) -> Self {
        let stop = lens.stop();
        let mut to_film = sequence::<f64>(lens, Side::Scene(0.0));
        // The transform to the frame of the stop has its row too.
        let first = to_film.iter().position(|surface| {
            surface.row >= stop && !matches!(surface.kind, SurfaceKind::FrameTransform(_))
        });
        to_film.drain(..first.unwrap_or(0));
        to_film[0].advance = 0.0;
        let mut to_scene = sequence::<f64>(lens, Side::Film(0.0));
        let first = to_scene.iter().position(|surface| surface.row < stop);
        to_scene.drain(..first.unwrap_or(to_scene.len()));
        open_surfaces(&mut to_film);
        open_surfaces(&mut to_scene);
        Self { to_film, to_scene, index: lens.index_before(stop) }
    }

    /// Traces the chief ray with these direction cosines across the axis at the stop; `None` if it
    /// does not leave the lens on both sides.
    pub fn trace(&self, cosines: [f64; 2]) -> Option<StopRay> {
        let [a, b] = cosines;
        let along = 1.0 - a * a - b * b;
        if along <= 0.0 {
            return None;
        }
        let n = self.index;
        let along = n * along.sqrt();
        let start = |t: [f64; 3]| LensRay::new([0.0; 3], t);
        let film = trace_one::<f64>(start([n * a, n * b, along]), &self.to_film).ok()?;
        let scene = trace_one::<f64>(start([-n * a, -n * b, along]), &self.to_scene).ok()?;
        let ray = StopRay { cosines, film, scene };
        let finite = film.p.iter().chain(&scene.p).all(|x| x.is_finite());
        (finite && film.t[2] > 0.0).then_some(ray)
    }

    /// Returns the chief ray of a film point: x, y, and z towards the scene (mm) from the axis, in
    /// the plane `distance` mm behind the rear vertex.
    pub fn of_film_point(&self, [x, y, z]: [f64; 3], distance: f64) -> Option<StopRay> {
        let scale = x.abs().max(y.abs()).max(1.0);
        self.follow(|ray, share| {
            let [u, v] = ray.film_point(distance - share * z);
            ([u - share * x, v - share * y], scale)
        })
    }

    /// Follows the chief ray from the axis to a point of the film or of the object. `miss` returns by
    /// how much a chief ray misses a share of the point's distance from the axis, and the scale of
    /// that difference.
    ///
    /// Beyond the clear apertures several rays from the vertex of the stop may meet one film point.
    /// Steps are therefore short enough that each solution is close to the extrapolation of those
    /// before it.
    pub fn follow(&self, miss: impl Fn(&StopRay, f64) -> ([f64; 2], f64)) -> Option<StopRay> {
        let mut at = self.newton(&miss, 0.0, [0.0; 2]).unwrap_or_default();
        let (mut reached, mut step) = (0.0, FIRST);
        // Change of the cosines by the share of the point.
        let mut slope: Option<[f64; 2]> = None;
        while reached < 1.0 {
            let next = (reached + step).min(1.0);
            let length = next - reached;
            let change = slope.map(|slope| slope.map(|s| s * length));
            let guess = change.map_or(at, |change| [0, 1].map(|i| at[i] + change[i]));
            let near = |found: &[f64; 2]| {
                let off = (found[0] - guess[0]).hypot(found[1] - guess[1]);
                change.is_none_or(|[x, y]| off <= LARGEST_MISS * x.hypot(y))
            };
            let found = self.newton(&miss, next, guess).or_else(|| self.newton(&miss, next, at));
            match found.filter(near) {
                Some(found) => {
                    slope = Some([0, 1].map(|i| (found[i] - at[i]) / length));
                    (reached, at, step) = (next, found, (2.0 * step).min(LONGEST));
                }
                None if step > SHORTEST => step /= 2.0,
                None => return None,
            }
        }
        self.trace(at)
    }

    /// Returns the chief ray of a point, from the direction cosines of one that is near.
    pub fn near(
        &self,
        cosines: [f64; 2],
        miss: impl Fn(&StopRay) -> ([f64; 2], f64),
    ) -> Option<StopRay> {
        self.trace(self.newton(&|ray: &StopRay, _| miss(ray), 1.0, cosines)?)
    }

    /// Solves for the direction cosines at the stop that belong to a share of the point.
    fn newton(
        &self,
        miss: &impl Fn(&StopRay, f64) -> ([f64; 2], f64),
        share: f64,
        start: [f64; 2],
    ) -> Option<[f64; 2]> {
        let miss = |at: [f64; 2]| Some(miss(&self.trace(at)?, share));
        let (_, scale) = miss(start)?;
        let newton = PlaneNewton {
            difference: DIFFERENCE,
            precision: PRECISION * scale,
            acceptable: 1e4 * PRECISION * scale,
        };
        newton.solve(start, |at| Some(miss(at)?.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prescription::Row;

    /// A ball of glass with a stop in its middle: rays through its centre are not refracted.
    fn ball() -> Prescription {
        let row = |radius: f64, diameter: f64, index: f64| Row {
            radius,
            diameter,
            index,
            thickness: 6.0,
            ..Row::default()
        };
        let mut rows = vec![
            row(6.0, 11.9, 1.5),
            Row { stop: true, ..row(f64::INFINITY, 4.0, 1.5) },
            row(-6.0, 11.9, 1.0),
        ];
        rows[2].thickness = 0.0;
        Prescription::new("ball", rows).expect("one stop")
    }

    #[test]
    fn the_chief_ray_of_a_film_point_passes_the_middle_of_a_ball() {
        let finder = ChiefRayFinder::new(&ball());
        // Tilted film brings the last point nearer.
        for (point, tangent) in [
            ([0.0, 0.0, 0.0], 0.0),
            ([3.0, 4.0, 0.0], 5.0 / 9.0),
            ([0.0, 60.0, 0.0], 60.0 / 9.0),
            ([-1.0, 0.0, 1.0], 1.0 / 8.0),
        ] {
            let ray = finder.of_film_point(point, 3.0).expect("a chief ray");
            let [x, y, z] = ray.scene.t;
            assert!((x.hypot(y) / z - tangent).abs() < 1e-9, "{point:?}: {ray:?}");
        }
    }

    #[test]
    fn no_chief_ray_reaches_a_film_point_that_the_stop_does_not_see() {
        // A ray along the stop needs an infinite film.
        assert!(ChiefRayFinder::new(&ball()).of_film_point([1e9, 0.0, 0.0], 3.0).is_none());
    }
}
