//! Rays of a drawing, traced from the film.

use std::slice;

use glam::DAffine3;
use petzval_base::bisection::bisect;

use petzval_lens::{
    ChiefRayFinder, Iris, LensRay, Prescription, Row, Side, Surface, SurfaceKind, sequence,
    trace_one,
};

use super::element::drawn;
use crate::svg::Position;

/// Number of aims tried for every film point before bisection.
const AIMS: u32 = 128;

/// Steps of a bisection: exact enough even for a lens of a micrometre and a film of a metre.
const HALVINGS: u32 = 48;

/// A ray that starts in the y-z plane, seen from the side.
#[derive(Clone, Debug)]
pub(super) struct DrawnRay {
    /// The film point and the intersection with every surface, from the film to the scene (mm).
    pub points: Vec<Position>,
    /// Direction in which it leaves the lens, not normalised.
    pub towards: Position,
}

/// The rays of one film point.
#[derive(Debug)]
pub(super) struct Bundle {
    /// Height of the film point (mm).
    pub height: f64,
    /// The chief ray, if nothing blocks it.
    pub chief: Option<DrawnRay>,
    /// The two outermost rays that pass.
    pub rims: [DrawnRay; 2],
    /// Two rays between these.
    pub between: Vec<DrawnRay>,
}

impl Bundle {
    /// Returns all rays.
    pub(super) fn rays(&self) -> impl Iterator<Item = &DrawnRay> {
        self.chief.iter().chain(&self.rims).chain(&self.between)
    }
}

/// A lens and its film, ready for rays in the y-z plane.
pub(super) struct Tracer<'a> {
    lens: &'a Prescription,
    placed: &'a [DAffine3],
    distance: f64,
    /// Directions of travel before each row and behind the last.
    travels: Vec<f64>,
    /// Axis of the film.
    film_axis: DAffine3,
    surfaces: Vec<Surface<f64>>,
    chief_rays: ChiefRayFinder,
    /// The surfaces with wider rims, for heights in the stop.
    wide: Vec<Surface<f64>>,
}

impl<'a> Tracer<'a> {
    /// Prepares a lens; `placed` are the poses of its surfaces, and the film is `distance` behind
    /// the rear vertex (mm).
    pub(super) fn new(lens: &'a Prescription, placed: &'a [DAffine3], distance: f64) -> Self {
        let mut wide = lens.clone();
        for row in &mut wide.rows {
            // An aspheric polynomial is not valid far beyond its rim.
            let wider = if row.asphere.is_empty() && row.across.is_none() { 4.0 } else { 1.25 };
            *row = Row {
                diameter: wider * row.diameter,
                obstruction: 0.0,
                iris: Iris::Round,
                apertures: Vec::new(),
                ..row.clone()
            };
        }
        let from = Side::Film(distance);
        // An arm of a spider in the plane of the drawing would block all of its rays.
        let mut open = lens.clone();
        for row in &mut open.rows {
            let semi_diameter = row.diameter / 2.0;
            row.apertures.retain(|aperture| !aperture.is_arm(semi_diameter));
        }
        let surfaces = sequence::<f64>(&open, from);
        let (travels, film_axis) = (lens.travels(), lens.film_axis());
        let wide = sequence::<f64>(&wide, from);
        let chief_rays = ChiefRayFinder::new(lens);
        Self { lens, placed, distance, travels, film_axis, surfaces, chief_rays, wide }
    }

    /// Traces the ray from a film height to a height in the plane of the rear vertex, if it passes,
    /// and shows it behind every surface, with the row.
    fn trace(
        &self,
        surfaces: &[Surface<f64>],
        [height, aim]: [f64; 2],
        mut show: impl FnMut(usize, &LensRay<f64>),
    ) -> Option<LensRay<f64>> {
        let (dy, dz) = (aim - height, self.distance);
        let scale = self.lens.rear().index / dy.hypot(dz);
        let mut ray = LensRay::new([0.0, height, 0.0], [0.0, dy * scale, dz * scale]);
        for surface in surfaces {
            ray = trace_one::<f64>(ray, slice::from_ref(surface)).ok()?;
            if !matches!(surface.kind, SurfaceKind::FrameTransform(_)) {
                show(surface.row, &ray);
            }
        }
        let finite = ray.p.iter().chain(&ray.t).all(|v| v.is_finite());
        finite.then_some(ray)
    }

    /// Returns the ray from a film height to a height in the plane of the rear vertex, if it
    /// passes.
    fn ray(&self, height: f64, aim: f64) -> Option<DrawnRay> {
        let travel = self.travels[self.travels.len() - 1];
        let mut points = vec![drawn(&self.film_axis, [0.0, height, travel * self.distance])];
        let ray = self.trace(&self.surfaces, [height, aim], |row, ray| {
            let [x, y, z] = ray.p;
            points.push(drawn(&self.placed[row], [x, y, -self.travels[row] * z]));
        })?;
        let towards = [-ray.t[2], ray.t[1]];
        let finite = points.iter().flatten().all(|v| v.is_finite());
        finite.then_some(DrawnRay { points, towards })
    }

    /// Returns the height (mm) at which a ray meets the stop of the lens with wider rims, if it
    /// passes.
    fn stop_height(&self, height: f64, aim: f64) -> Option<f64> {
        let mut stop = f64::NAN;
        self.trace(&self.wide, [height, aim], |row, ray| {
            if self.lens.rows[row].stop {
                stop = ray.p[1];
            }
        })?;
        stop.is_finite().then_some(stop)
    }

    fn aims(&self, height: f64) -> Vec<f64> {
        aims(self.lens, self.distance, height, AIMS)
    }

    fn passes(&self, height: f64, aim: f64) -> bool {
        self.trace(&self.surfaces, [height, aim], |_, _| {}).is_some()
    }

    /// Returns the aim of the chief ray, if that ray passes.
    fn chief(&self, height: f64) -> Option<f64> {
        let ray = self.chief_rays.of_film_point([0.0, height, 0.0], self.distance)?;
        let aim = ray.film_point(0.0)[1];
        self.passes(height, aim).then_some(aim)
    }

    /// Returns the aims around the chief ray over which the height in the stop is monotonic. Beyond
    /// them other rays may pass a lens with strong aberrations, such as a ball.
    fn around(&self, height: f64, chief: f64) -> Vec<f64> {
        let aims = self.aims(height);
        let side = |aims: &mut dyn Iterator<Item = f64>| -> Vec<f64> {
            let mut last = 0.0;
            let farther = |&aim: &f64| match self.stop_height(height, aim) {
                Some(stop) if stop.abs() >= last => {
                    last = stop.abs();
                    true
                }
                _ => false,
            };
            aims.take_while(farther).collect()
        };
        let mut around = side(&mut aims.iter().copied().rev().filter(|&aim| aim < chief));
        around.reverse();
        around.push(chief);
        around.extend(side(&mut aims.iter().copied().filter(|&aim| aim > chief)));
        around
    }

    /// Returns the greatest film height, up to `most`, that a chief ray reaches, or any ray if an
    /// obstruction blocks chief rays.
    pub(super) fn field(&self, most: f64) -> f64 {
        let chief = self.chief(0.0).is_some();
        let seen = |height: f64| match chief {
            true => self.chief(height).is_some(),
            false => self.aims(height).into_iter().any(|aim| self.passes(height, aim)),
        };
        match seen(most) {
            true => most,
            false if seen(0.0) => bisect([0.0, most], HALVINGS, seen)[0],
            false => 0.0,
        }
    }

    /// Returns the rays of a film point, if any pass.
    pub(super) fn bundle(&self, height: f64) -> Option<Bundle> {
        let passes = |aim: f64| self.passes(height, aim);
        let ray = |aim: f64| self.ray(height, aim);
        let chief = self.chief(height);
        let aims = match chief {
            Some(chief) => self.around(height, chief),
            None => self.aims(height),
        };
        let first = aims.iter().position(|&aim| passes(aim))?;
        let last = aims.iter().rposition(|&aim| passes(aim))?;
        let low = first
            .checked_sub(1)
            .map_or(aims[first], |i| bisect([aims[first], aims[i]], HALVINGS, passes)[0]);
        let high = aims
            .get(last + 1)
            .map_or(aims[last], |&aim| bisect([aims[last], aim], HALVINGS, passes)[0]);
        let share = |share: f64| ray(low + share * (high - low));
        Some(Bundle {
            height,
            chief: chief.and_then(ray),
            rims: [ray(low)?, ray(high)?],
            between: [0.25, 0.75].into_iter().filter_map(share).collect(),
        })
    }
}

/// Returns heights in the plane of the rear vertex for rays from a film height (mm), from rim to rim
/// of the rear surface and a little beyond, in so many steps. The film is `distance` behind that
/// plane (mm).
pub fn aims(lens: &Prescription, distance: f64, height: f64, steps: u32) -> Vec<f64> {
    let rear = lens.rear();
    let half = rear.diameter / 2.0;
    let travel = lens.travel_before(lens.rows.len());
    let ahead = distance - travel * rear.sag_at(0.0, half);
    let spread = if ahead > 0.0 { (distance / ahead).min(10.0) } else { 10.0 };
    let seen = |rim: f64| height + (rim - height) * spread;
    let low = seen(-half).min(-half) - 0.02 * half;
    let high = seen(half).max(half) + 0.02 * half;
    let share = |i: u32| f64::from(i) / f64::from(steps);
    (0..=steps).map(|i| low * (1.0 - share(i)) + high * share(i)).collect()
}
