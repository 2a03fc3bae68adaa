//! Vignetting: the share of a film point's light that each surface blocks.
//!
//! Rays from a film point go to points spread uniformly over a part of the plane of the rear vertex
//! and are weighted as in exposure: by cos^4 / Z^2 from untilted film (Kolb, Mitchell & Hanrahan
//! 1995, eq. 3), from tilted film with the cosine at its own normal. A ray is lost at the first row
//! that it does not pass, on its way from the film to the scene.
//!
//! Most rays over the rear element end at the stop, even on the axis, which is not vignetting. The
//! losses at rims are therefore measured against a copy of the lens in which all rims but that of
//! the stop are open: the light that passes the stop of the copy is the total, and the rows of the
//! lens itself block shares of it.

pub(crate) mod open_rims;

mod ray_end;
mod stop_finder;

use rayon::prelude::*;

use ray_end::{FilmPoint, RayEnd, RayEndTracer};
use stop_finder::StopFinder;

use crate::prescription::Prescription;
use crate::prescription::pose::Pose;
use crate::pupil::outline::PupilBox;
use crate::pupil::scan::rough_surfaces;
use crate::pupil::table::TableBuilder;
use crate::trace::chief_ray::ChiefRayFinder;
use crate::trace::kernel::LensRay;
use crate::trace::sequence::{Side, sequence};
use crate::trace::surface::{Surface, open_surfaces};
use crate::trace::trace_one;
use crate::vignetting::open_rims::{KeptRims, open_rims};
use petzval_base::bisection::bisect;
use petzval_base::rays::WAVE_SIZE;
use petzval_base::sampler::{Dimension, sample_2d};

/// The light to which shares are normalized.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Normalization {
    /// The light that would pass the stop if all other rims were open and without obstructions.
    /// Losses from it are mechanical vignetting.
    Stop,
    /// The light that enters the rear element.
    Rear,
}

/// The losses at a row, as shares of the light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct RowLoss {
    /// Loss at its rim, its obstruction, and the blades or the mask of its opening.
    pub rim: f64,
    /// Loss by total reflection, or because the ray misses the surface. 0 at the stop, all of whose
    /// losses count as `rim`.
    pub refraction: f64,
}

impl RowLoss {
    /// Returns the sum of both.
    pub fn share(&self) -> f64 {
        self.rim + self.refraction
    }
}

/// The light budget of a film point: all shares add up to 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LightBudget {
    /// Losses by row of the prescription.
    pub rows: Vec<RowLoss>,
    /// Share that leaves the lens.
    pub pass: f64,
    /// Irradiance of the film under a scene of radiance 1 (the integral of the ray weights over the
    /// visible pupil). Its ratio to that of the film's centre is the relative illumination.
    pub irradiance: f64,
}

/// Computes the light budgets of a lens.
#[derive(Clone, Debug)]
pub struct Vignetting {
    lens: Prescription,
    distance: f64,
    /// Tilt and decentre of the film.
    pose: Pose,
    itself: Vec<Surface<f32>>,
    /// The surfaces with all rims open but that of the stop.
    open: Vec<Surface<f32>>,
    stop_finder: StopFinder,
    chief_rays: ChiefRayFinder,
    /// Sample points of the unit square.
    points: Vec<[f32; 2]>,
}

impl Vignetting {
    /// Makes the analysis for a film at `distance` mm behind the rear vertex. With 2^16 rays a
    /// light budget is exact to about 0.1 % of the light; with a quarter of the rays the error
    /// grows less than threefold.
    pub fn new(lens: &Prescription, distance: f64, rays: u32) -> Self {
        Self::for_pose(lens, distance, Pose::ALIGNED, rays)
    }

    /// Makes the analysis for a tilted or decentred film. Film points are in the film's own frame,
    /// mm from its centre.
    pub fn for_pose(lens: &Prescription, distance: f64, pose: Pose, rays: u32) -> Self {
        let open = rough_surfaces(&open_rims(lens, KeptRims::Stop), distance);
        Self {
            lens: lens.clone(),
            distance,
            pose,
            itself: rough_surfaces(lens, distance),
            stop_finder: StopFinder::new(lens, distance, &open),
            chief_rays: ChiefRayFinder::new(lens),
            open,
            points: (0..rays.max(1)).map(|i| sample_2d(0, i, Dimension::Pupil)).collect(),
        }
    }

    /// Returns the light budget of a film point (mm); `None` if there is no such light. It does not
    /// depend on the number of threads.
    pub fn budget(&self, film: [f64; 2], normalization: Normalization) -> Option<LightBudget> {
        let start = self.start(film);
        let pupil_box = match normalization {
            Normalization::Stop => self.stop_finder.find(start, &mut RayEndTracer::default())?,
            Normalization::Rear => self.rear(start),
        };
        let part = |tracers: &mut [RayEndTracer; 2], wave: &[[f32; 2]]| {
            let mut sums = BudgetSums::new(&self.lens, normalization);
            let at = |i: usize| place(pupil_box, wave[i]);
            let [itself, open] = tracers;
            let itself = itself.trace(start, wave.len(), at, &self.itself);
            // Wider rims change the end of those rays alone that a rim may have blocked.
            let undecided: Vec<usize> =
                (0..wave.len()).filter(|&i| sums.needs_open(itself[i])).collect();
            let opened = open.trace(start, undecided.len(), |k| at(undecided[k]), &self.open);
            let mut opened = undecided.iter().zip(opened).peekable();
            for (i, &end) in itself.iter().enumerate() {
                let open = opened.next_if(|(ray, _)| **ray == i).map_or(end, |(_, open)| *open);
                sums.add(start.weight(at(i)), open, end);
            }
            sums
        };
        let parts: Vec<BudgetSums> =
            self.points.par_chunks(WAVE_SIZE).map_init(Default::default, part).collect();
        // In the order of the rays, whichever thread traced them.
        let sums = parts.into_iter().reduce(BudgetSums::with)?;
        let size = pupil_box.size();
        sums.finish(size[0] * size[1] / self.points.len() as f64)
    }

    /// Returns whether any light of a film point (mm) leaves the lens, as far as the rays find it.
    pub fn is_lit(&self, film: [f64; 2]) -> bool {
        let start = self.start(film);
        let Some(pupil_box) = self.stop_finder.find(start, &mut RayEndTracer::default()) else {
            return false;
        };
        self.points.par_chunks(WAVE_SIZE).any(|wave| {
            let at = |i: usize| place(pupil_box, wave[i]);
            let mut tracer = RayEndTracer::default();
            let ends = tracer.trace(start, wave.len(), at, &self.itself);
            (0..wave.len()).any(|i| {
                let light = f64::from(ends[i].transmittance) * start.weight(at(i));
                ends[i].passes() && light > 0.0
            })
        })
    }

    /// Returns the angle to the axis (degrees) of the chief ray of the film point (x, 0): the ray
    /// through the centre of the stop, even if rims block it. If there is no such ray, or if it does
    /// not leave the lens, the ray in the middle of the light that does takes its place. `None` if
    /// no light of the point leaves the lens.
    pub fn field_angle(&self, x: f64) -> Option<f64> {
        let start = self.start([x, 0.0]);
        let mut tracer = RayEndTracer::default();
        let pupil_box = self.stop_finder.find(start, &mut tracer)?;
        let scene = match self.chief_rays.of_film_point(start.film, start.distance) {
            Some(chief) => chief.scene,
            None => {
                let point = self.middle(start, pupil_box, &mut tracer)?;
                let mut surfaces = sequence::<f64>(&self.lens, Side::Film(self.distance));
                open_surfaces(&mut surfaces);
                let ray = LensRay::new(start.film, start.direction(point));
                trace_one::<f64>(ray, &surfaces).ok()?
            }
        };
        let [tx, ty, tz] = scene.t;
        Some(tx.hypot(ty).atan2(tz).to_degrees())
    }

    /// Returns the point, of those in the plane of the rear vertex whose rays leave the lens, that
    /// is nearest to their mean.
    fn middle(
        &self,
        start: FilmPoint,
        pupil_box: PupilBox,
        tracer: &mut RayEndTracer,
    ) -> Option<[f64; 2]> {
        let mut passed = Vec::new();
        for wave in self.points.chunks(WAVE_SIZE) {
            let at = |i: usize| place(pupil_box, wave[i]);
            let ends = tracer.trace(start, wave.len(), at, &self.itself);
            passed.extend((0..wave.len()).filter(|&i| ends[i].passes()).map(at));
        }
        let count = passed.len() as f64;
        let mean =
            [0, 1].map(|axis| passed.iter().map(|p: &[f64; 2]| p[axis]).sum::<f64>() / count);
        let off = |p: &[f64; 2]| (p[0] - mean[0]).hypot(p[1] - mean[1]);
        passed.into_iter().min_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// Returns the distance from the axis along x at which the light ends (mm), if that is before
    /// `reach`. It is exact to 1e-4 of `reach`, as far as the rays find the last light.
    pub fn light_radius(&self, reach: f64) -> Option<f64> {
        let lit = |x: f64| self.is_lit([x, 0.0]);
        if lit(reach) {
            return None;
        }
        // The light may have dark rings; this finds its outermost end.
        let steps = 24;
        let place = |i: u32| reach * f64::from(i) / f64::from(steps);
        let last = (0..steps).rev().map(place).find(|&x| lit(x));
        let Some(inside) = last else { return Some(0.0) };
        // Down to 8e-5 of `reach`.
        Some(bisect([inside, inside + place(1)], 9, lit)[0])
    }

    fn start(&self, film: [f64; 2]) -> FilmPoint {
        FilmPoint {
            film: self.pose.film_point(film),
            normal: self.pose.film_normal(),
            distance: self.distance,
            index: self.lens.rear().index,
        }
    }

    /// Returns a box around the rear element as seen from a film point, in the plane of its vertex.
    fn rear(&self, start: FilmPoint) -> PupilBox {
        let builder = TableBuilder {
            lens: &self.lens,
            others: &[],
            distance: self.distance,
            pose: self.pose,
        };
        let pupil_box = PupilBox::around(&builder.rear_outline(start.film));
        pupil_box.grown(pupil_box.size().map(|size| 0.01 * size))
    }
}

/// Returns a point of the plane of the rear vertex, by its place in a box: 0 to 1 along each side.
fn place(pupil_box: PupilBox, share: [f32; 2]) -> [f64; 2] {
    let (middle, size) = (pupil_box.centre(), pupil_box.size());
    [0, 1].map(|axis| middle[axis] + (f64::from(share[axis]) - 0.5) * size[axis])
}

/// Sums of a light budget.
struct BudgetSums {
    normalization: Normalization,
    stop: u32,
    rear: u32,
    rows: Vec<RowLoss>,
    all: f64,
    passed: f64,
}

impl BudgetSums {
    fn new(lens: &Prescription, normalization: Normalization) -> Self {
        let count = lens.rows.len();
        let rows = vec![RowLoss::default(); count];
        let (stop, rear) = (lens.stop() as u32, count as u32 - 1);
        Self { normalization, stop, rear, rows, all: 0.0, passed: 0.0 }
    }

    /// Returns whether the open copy may end a ray elsewhere than the lens itself, and it matters. Only
    /// the stop, which both have, transmits a part of a ray.
    fn needs_open(&self, itself: RayEnd) -> bool {
        let unseen = self.normalization == Normalization::Rear && itself.row == self.rear;
        !itself.passes() && itself.row != self.stop && !unseen
    }

    /// Adds the sums of other rays.
    fn with(mut self, other: Self) -> Self {
        for (own, other) in self.rows.iter_mut().zip(&other.rows) {
            own.rim += other.rim;
            own.refraction += other.refraction;
        }
        (self.all, self.passed) = (self.all + other.all, self.passed + other.passed);
        self
    }

    /// Adds a ray, given where it ends in the open copy and in the lens itself.
    fn add(&mut self, weight: f64, open: RayEnd, itself: RayEnd) {
        // Rows are numbered from the scene: rays meet the rows before the stop after it.
        let light = match self.normalization {
            Normalization::Stop if open.passes() || open.row < self.stop => {
                weight * f64::from(open.transmittance)
            }
            Normalization::Rear if itself.row != self.rear => weight,
            _ => return,
        };
        let share = match (itself.passes(), self.normalization) {
            (false, _) => 0.0,
            (true, Normalization::Stop) => f64::from(itself.transmittance / open.transmittance),
            (true, Normalization::Rear) => f64::from(itself.transmittance),
        };
        self.all += light;
        self.passed += light * share;
        // Only the opening of the stop transmits a part of a ray.
        let row = if itself.passes() { self.stop } else { itself.row };
        let lost = light * (1.0 - share);
        let loss = &mut self.rows[row as usize];
        if open.row == row && row != self.stop {
            loss.refraction += lost;
        } else {
            loss.rim += lost;
        }
    }

    /// Returns the budget; `area` is that of a ray in the plane of the rear vertex, mm^2.
    fn finish(self, area: f64) -> Option<LightBudget> {
        let Self { rows, all, passed, .. } = self;
        let share =
            |loss: RowLoss| RowLoss { rim: loss.rim / all, refraction: loss.refraction / all };
        (all > 0.0).then(|| LightBudget {
            rows: rows.into_iter().map(share).collect(),
            pass: passed / all,
            irradiance: passed * area,
        })
    }
}
