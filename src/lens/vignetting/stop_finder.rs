//! Finder of the stop as a film point would see it if all other rims were open.
//!
//! Unlike the search for a pupil, this one grows its box: the stop may be seen far beyond the place
//! that first-order optics expects.

use super::ray_end::{FilmPoint, RayEndTracer};
use crate::focus::paraxial::Paraxial;
use crate::prescription::{Prescription, TransverseAxis};
use crate::pupil::outline::PupilBox;
use crate::trace::surface::Surface;
use petzval_base::rays::WAVE_SIZE;

/// Columns and rows of the search grid.
const GRID: usize = 48;
/// Most rounds of the search for the stop.
const ROUNDS: usize = 24;
/// Tangent of the steepest direction from the film in which the stop is searched.
const STEEPEST: f64 = 6.0;

/// Finds the stop in the plane of the rear vertex.
#[derive(Clone, Debug)]
pub(super) struct StopFinder {
    /// Surfaces from the film to the stop, all rims open but that of the stop.
    open: Vec<Surface<f32>>,
    /// Movement of the pupil per mm on the film, along x and y, by first-order optics.
    drift: [f64; 2],
    /// The pupil of the film's centre, by first-order optics.
    paraxial: PupilBox,
}

impl StopFinder {
    /// Makes a finder; `open` is the lens with all rims open but that of the stop.
    pub fn new(lens: &Prescription, distance: f64, open: &[Surface<f32>]) -> Self {
        let stop = lens.stop();
        let pupils = [TransverseAxis::X, TransverseAxis::Y]
            .map(|axis| Paraxial::in_plane(lens, axis).exit_pupil);
        let behind = pupils.map(|pupil| -pupil.position);
        let half =
            [0, 1].map(|i| pupils[i].diameter / 2.0 * (distance / (distance + behind[i])).abs());
        Self {
            open: open.iter().filter(|surface| surface.row >= stop).cloned().collect(),
            drift: behind.map(|behind| behind / (distance + behind)),
            paraxial: PupilBox::around(&[half, half.map(|v| -v)]),
        }
    }

    /// Returns a tight box around the stop in the plane of the rear vertex (mm), if it is visible.
    pub fn find(&self, start: FilmPoint, tracer: &mut RayEndTracer) -> Option<PupilBox> {
        let expected = self.paraxial.moved([0, 1].map(|i| start.film[i] * self.drift[i]));
        let around = [0.0, 1.0, 5.0].map(|by| expected.grown(expected.size().map(|v| by * v)));
        // The exit pupil of a telecentric lens is at infinity; first-order optics then gives no
        // estimate.
        let usable =
            around.into_iter().filter(|pupil_box| pupil_box.size().iter().all(|v| v.is_finite()));
        let [x, y, _] = start.film;
        let whole = PupilBox::around(&[[x, y]]).grown([STEEPEST * start.distance; 2]);
        usable.chain([whole]).find_map(|pupil_box| self.fit(start, pupil_box, tracer))
    }

    /// Fits a box to the stop, starting from one that contains a part of it.
    fn fit(
        &self,
        start: FilmPoint,
        mut pupil_box: PupilBox,
        tracer: &mut RayEndTracer,
    ) -> Option<PupilBox> {
        for _ in 0..ROUNDS {
            let (middle, size) = (pupil_box.centre(), pupil_box.size());
            let step = size.map(|size| size / (GRID - 1) as f64);
            let point = |i: usize| {
                let place = [i % GRID, i / GRID].map(|i| i as f64 - (GRID - 1) as f64 / 2.0);
                [0, 1].map(|axis| middle[axis] + place[axis] * step[axis])
            };
            let mut seen = Vec::new();
            for first in (0..GRID * GRID).step_by(WAVE_SIZE) {
                let count = WAVE_SIZE.min(GRID * GRID - first);
                let ends = tracer.trace(start, count, |i| point(first + i), &self.open);
                seen.extend((0..count).filter(|&i| ends[i].passes()).map(|i| point(first + i)));
            }
            if seen.is_empty() {
                return None;
            }
            let tight = PupilBox::around(&seen).grown(step);
            let sticks_out = |axis: usize| {
                let off = (tight.centre()[axis] - middle[axis]).abs();
                2.0 * off + tight.size()[axis] > size[axis]
            };
            pupil_box = if sticks_out(0) || sticks_out(1) {
                tight.grown(tight.size().map(|size| size / 2.0))
            } else if (0..2).any(|axis| tight.size()[axis] < 0.5 * size[axis]) {
                tight
            } else {
                return Some(tight);
            };
        }
        Some(pupil_box)
    }
}
