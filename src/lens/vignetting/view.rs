//! The stop as a film point would see it if no other rim were in the way.

use super::fate::{Fates, Start};
use crate::lens::outline::Frame;
use crate::lens::paraxial::Paraxial;
use crate::lens::prescription::{Axis, Prescription};
use crate::lens::refract::LensRay;
use crate::lens::surface::{From, Surface, sequence};
use crate::lens::trace::trace_one;
use crate::lens::widened::{Keep, widened};
use crate::rays::WAVE;

/// Columns and rows of the grid that looks for the stop.
const GRID: usize = 48;
/// Steps across the frame in which the middle of the stop is looked for.
const SCAN: u32 = 64;
/// Rounds of it.
const ROUNDS: usize = 24;
/// The steepest direction from the film, by its tangent, in which the stop is looked for.
const STEEPEST: f64 = 6.0;

/// Looks at the stop.
#[derive(Clone, Debug)]
pub(super) struct View {
    /// From the film to the stop, all rims opened but that of the stop.
    open: Vec<Surface<f32>>,
    /// From the film to the scene, all rims opened.
    bare: Vec<Surface<f64>>,
    /// How many of `bare` come up to the stop.
    to_stop: usize,
    /// How far the pupil moves per mm on the film, along x and y, by first-order optics.
    drift: [f64; 2],
    /// The pupil of the middle of the film, by first-order optics.
    paraxial: Frame,
}

impl View {
    /// `open` is the lens with all rims opened but that of the stop.
    pub fn new(lens: &Prescription, distance: f64, open: &[Surface<f32>]) -> Self {
        let stop = lens.stop();
        let bare = sequence::<f64>(&widened(lens, Keep::Nothing), From::Film(distance));
        let pupils = [Axis::X, Axis::Y].map(|axis| Paraxial::in_plane(lens, axis).exit_pupil);
        let behind = pupils.map(|pupil| -pupil.position);
        let half =
            [0, 1].map(|i| pupils[i].diameter / 2.0 * (distance / (distance + behind[i])).abs());
        Self {
            open: open.iter().filter(|surface| surface.row >= stop).cloned().collect(),
            to_stop: bare.iter().filter(|surface| surface.row >= stop).count(),
            bare,
            drift: behind.map(|behind| behind / (distance + behind)),
            paraxial: Frame::around(&[half, half.map(|v| -v)]),
        }
    }

    /// A tight frame around the stop in the plane of the rear vertex, mm, if it is seen at all.
    pub fn frame(&self, start: Start, fates: &mut Fates) -> Option<Frame> {
        let expected = self.paraxial.moved([0, 1].map(|i| start.film[i] * self.drift[i]));
        let around = [0.0, 1.0, 5.0].map(|by| expected.grown(expected.size().map(|v| by * v)));
        // A telecentric lens has its pupil at infinity; first-order optics says nothing then.
        let usable = around.into_iter().filter(|frame| frame.size().iter().all(|v| v.is_finite()));
        let [x, y, _] = start.film;
        let whole = Frame::around(&[[x, y]]).grown([STEEPEST * start.distance; 2]);
        usable.chain([whole]).find_map(|frame| self.fit(start, frame, fates))
    }

    /// Fits a frame to the stop, of which it holds a part.
    fn fit(&self, start: Start, mut frame: Frame, fates: &mut Fates) -> Option<Frame> {
        for _ in 0..ROUNDS {
            let (middle, size) = (frame.middle(), frame.size());
            let step = size.map(|size| size / (GRID - 1) as f64);
            let point = |i: usize| {
                let place = [i % GRID, i / GRID].map(|i| i as f64 - (GRID - 1) as f64 / 2.0);
                [0, 1].map(|axis| middle[axis] + place[axis] * step[axis])
            };
            let mut seen = Vec::new();
            for first in (0..GRID * GRID).step_by(WAVE) {
                let count = WAVE.min(GRID * GRID - first);
                let fates = fates.of(start, count, |i| point(first + i), &self.open);
                seen.extend((0..count).filter(|&i| fates[i].alive()).map(|i| point(first + i)));
            }
            if seen.is_empty() {
                return None;
            }
            let tight = Frame::around(&seen).grown(step);
            let sticks_out = |axis: usize| {
                let off = (tight.middle()[axis] - middle[axis]).abs();
                2.0 * off + tight.size()[axis] > size[axis]
            };
            frame = if sticks_out(0) || sticks_out(1) {
                tight.grown(tight.size().map(|size| size / 2.0))
            } else if (0..2).any(|axis| tight.size()[axis] < 0.5 * size[axis]) {
                tight
            } else {
                return Some(tight);
            };
        }
        Some(frame)
    }

    /// The angle to the axis, degrees, at which the ray of a point on the film's x axis through
    /// the middle of the stop leaves for the scene; `frame` is around the stop.
    pub fn chief_angle(&self, start: Start, frame: Frame) -> Option<f64> {
        let ray = |u: f64| LensRay::new(start.film, start.towards([u, frame.middle()[1]]));
        let to_stop = &self.bare[..self.to_stop];
        let met = |u: f64| trace_one::<f64>(ray(u), to_stop).map(|ray| ray.p[0]).ok();
        // Rays at the edges of the frame may never come to the stop, or come there on wild ways.
        let (middle, size) = (frame.middle()[0], frame.size()[0]);
        let place = |i: u32| middle + size * (f64::from(i) / f64::from(SCAN) - 0.5);
        let across = |i: u32| {
            let (low, high) = (met(place(i))?, met(place(i + 1))?);
            ((low > 0.0) != (high > 0.0)).then_some((low.abs() + high.abs(), i))
        };
        let mut steps: Vec<(f64, u32)> = (0..SCAN).filter_map(across).collect();
        steps.sort_by(|one, other| one.0.total_cmp(&other.0));
        steps.into_iter().find_map(|(_, i)| {
            let (mut low, mut high) = (place(i), place(i + 1));
            let side = met(low)? > 0.0;
            // Fifty halvings leave nothing of any pupil.
            for _ in 0..50 {
                let middle = (low + high) / 2.0;
                match (met(middle)? > 0.0) == side {
                    true => low = middle,
                    false => high = middle,
                }
            }
            let [tx, ty, tz] = trace_one::<f64>(ray(low), &self.bare).ok()?.t;
            Some(tx.hypot(ty).atan2(tz).to_degrees())
        })
    }
}
