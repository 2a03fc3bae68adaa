//! Heights of the rays of a wide field: aimed from the stop, beyond 90 degrees too.
//!
//! First-order optics knows neither angles beyond 90 degrees nor the aberration of the pupil, which
//! moves and grows with the angle in a fisheye. A ray from a point of the stop needs no aim: of all
//! its directions the one is searched that leaves the lens at the angle of the field.

use petzval_base::bisection::try_bisect;

use crate::prescription::Prescription;
use crate::trace::kernel::LensRay;
use crate::trace::sequence::{Side, sequence};
use crate::trace::surface::Surface;
use crate::trace::trace_one;

/// Steepest direction in the stop (degrees), and directions tried on each side of the axis.
const STEEPEST: f64 = 80.0;
const DIRECTIONS: i32 = 160;

/// Halvings of the interval between two directions, down to the precision of f64.
const HALVINGS: u32 = 50;

/// Traces rays from the stop of a centred lens to both sides.
pub(super) struct StopRays<'a> {
    lens: &'a Prescription,
    stop: usize,
    to_scene: Vec<Surface<f64>>,
    to_film: Vec<Surface<f64>>,
}

impl<'a> StopRays<'a> {
    pub fn new(lens: &'a Prescription) -> Self {
        let stop = lens.stop();
        let mut to_scene = sequence::<f64>(lens, Side::Film(1.0));
        to_scene.retain(|surface| surface.row < stop);
        let mut to_film = sequence::<f64>(lens, Side::Scene(1.0));
        to_film.retain(|surface| surface.row >= stop);
        Self { lens, stop, to_scene, to_film }
    }

    /// Raises the heights at the rows to those of the rays that leave the lens at an angle to the
    /// axis (degrees), through the middle and two edges of the stop. Returns whether one does.
    pub fn raise(&self, angle: f64, heights: &mut [f64]) -> bool {
        let half = self.lens.rows[self.stop].diameter / 2.0;
        let mut found = false;
        for height in [0.0, half, -half] {
            let Some(direction) = self.direction(height, angle) else { continue };
            found = true;
            let [to_scene, to_film] = self.starts(height, direction);
            for (ray, surfaces) in [(to_scene, &self.to_scene), (to_film, &self.to_film)] {
                let mut ray = ray;
                for surface in surfaces {
                    let Ok(next) = trace_one::<f64>(ray, std::slice::from_ref(surface)) else {
                        break;
                    };
                    ray = next;
                    heights[surface.row] = heights[surface.row].max(ray.p[1].abs());
                }
            }
        }
        found
    }

    /// Returns the direction in the stop (degrees) of the ray through a height of the stop (mm) that
    /// leaves the lens at an angle to the axis (degrees), if there is one.
    fn direction(&self, height: f64, angle: f64) -> Option<f64> {
        let place = |i: i32| STEEPEST * f64::from(i) / f64::from(DIRECTIONS);
        let off = |direction: f64| Some(self.leave(height, direction)? - angle);
        let across = |i: &i32| matches!((off(place(*i)), off(place(i + 1))), (Some(a), Some(b)) if (a < 0.0) != (b < 0.0));
        // The direction nearest to the axis: farther out the angle may fall again.
        let step = (-DIRECTIONS..DIRECTIONS).filter(across).min_by_key(|i| (2 * i + 1).abs())?;
        let ends = [place(step), place(step + 1)];
        let below = off(ends[0])? < 0.0;
        let [low, _] = try_bisect(ends, HALVINGS, |at| Some((off(at)? < 0.0) == below))?;
        Some(low)
    }

    /// Returns the angle to the axis (degrees) at which a ray leaves for the scene.
    fn leave(&self, height: f64, direction: f64) -> Option<f64> {
        let [to_scene, _] = self.starts(height, direction);
        let [_, ty, tz] = trace_one::<f64>(to_scene, &self.to_scene).ok()?.t;
        Some(ty.atan2(tz).to_degrees())
    }

    /// Returns the rays to the scene and to the film from a point on the scene side of the stop.
    fn starts(&self, height: f64, direction: f64) -> [LensRay<f64>; 2] {
        let index = self.lens.index_before(self.stop);
        let sag = self.lens.rows[self.stop].sag(height);
        let (sin, cos) = direction.to_radians().sin_cos();
        let advance = self.to_film.first().map_or(0.0, |surface| surface.advance);
        [
            LensRay::new([0.0, height, -sag], [0.0, index * sin, index * cos]),
            LensRay::new([0.0, height, advance + sag], [0.0, -index * sin, index * cos]),
        ]
    }
}
