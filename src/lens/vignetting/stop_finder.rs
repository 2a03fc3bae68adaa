//! Finder of the stop as a film point would see it if all other rims were open.

use super::ray_end::{FilmPoint, RayEndTracer};
use crate::focus::paraxial::Paraxial;
use crate::prescription::{Prescription, TransverseAxis};
use crate::pupil::outline::PupilBox;
use crate::trace::kernel::LensRay;
use crate::trace::sequence::{Side, sequence};
use crate::trace::surface::Surface;
use crate::trace::trace_one;
use crate::vignetting::open_rims::{KeptRims, open_rims};
use petzval_base::bisection::try_bisect;
use petzval_base::rays::WAVE_SIZE;

/// Columns and rows of the search grid.
const GRID: usize = 48;
/// Steps across the box in which the centre of the stop is searched.
const SCAN: u32 = 64;
/// Rounds of the search for the centre of the stop, each in a window of 8 steps of the one before.
const WINDOWS: u32 = 6;
/// Most rounds of the search for the stop.
const ROUNDS: usize = 24;
/// Tangent of the steepest direction from the film in which the stop is searched.
const STEEPEST: f64 = 6.0;

/// Finds the stop in the plane of the rear vertex.
#[derive(Clone, Debug)]
pub(super) struct StopFinder {
    /// Surfaces from the film to the stop, all rims open but that of the stop.
    open: Vec<Surface<f32>>,
    /// Surfaces from the film to the scene, all rims open.
    unobstructed: Vec<Surface<f64>>,
    /// Number of surfaces of `unobstructed` up to the stop.
    to_stop: usize,
    /// Movement of the pupil per mm on the film, along x and y, by first-order optics.
    drift: [f64; 2],
    /// The pupil of the film's centre, by first-order optics.
    paraxial: PupilBox,
}

impl StopFinder {
    /// Makes a finder; `open` is the lens with all rims open but that of the stop.
    pub fn new(lens: &Prescription, distance: f64, open: &[Surface<f32>]) -> Self {
        let stop = lens.stop();
        let unobstructed = sequence::<f64>(&open_rims(lens, KeptRims::None), Side::Film(distance));
        let pupils = [TransverseAxis::X, TransverseAxis::Y]
            .map(|axis| Paraxial::in_plane(lens, axis).exit_pupil);
        let behind = pupils.map(|pupil| -pupil.position);
        let half =
            [0, 1].map(|i| pupils[i].diameter / 2.0 * (distance / (distance + behind[i])).abs());
        Self {
            open: open.iter().filter(|surface| surface.row >= stop).cloned().collect(),
            to_stop: unobstructed.iter().filter(|surface| surface.row >= stop).count(),
            unobstructed,
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

    /// Returns the angle to the axis (degrees) at which the ray of a point on the film's x axis
    /// through the centre of the stop leaves for the scene; `pupil_box` is around the stop.
    ///
    /// Surfaces may cut rays anywhere before the stop, so the search takes only neighbours that
    /// both arrive, and halves the interval between them only where rays arrive. If no neighbours
    /// enclose the centre, the search goes on around the ray that comes nearest to it.
    pub fn chief_angle(&self, start: FilmPoint, pupil_box: PupilBox) -> Option<f64> {
        let (mut middle, mut size) = (pupil_box.centre()[0], pupil_box.size()[0]);
        for _ in 0..WINDOWS {
            let place = |i: u32| middle + size * (f64::from(i) / f64::from(SCAN) - 0.5);
            let met: Vec<Option<f64>> =
                (0..=SCAN).map(|i| self.at_stop(start, pupil_box, place(i))).collect();
            let across = |i: u32| {
                let (low, high) = (met[i as usize]?, met[i as usize + 1]?);
                ((low > 0.0) != (high > 0.0)).then_some((low.abs() + high.abs(), i))
            };
            let mut steps: Vec<(f64, u32)> = (0..SCAN).filter_map(across).collect();
            // A stray path jumps from one side to the other; the true one is continuous.
            steps.sort_by(|one, other| one.0.total_cmp(&other.0));
            let centre =
                |&(_, i): &(f64, u32)| self.centre(start, pupil_box, [place(i), place(i + 1)]);
            if let Some(angle) = steps.iter().filter_map(centre).find_map(|u| self.leave(start, u))
            {
                return Some(angle);
            }
            let off = |i: &u32| met[*i as usize].map_or(f64::INFINITY, f64::abs);
            let nearest = (0..=SCAN).min_by(|a, b| off(a).total_cmp(&off(b)))?;
            met[nearest as usize]?;
            (middle, size) = (place(nearest), size * 8.0 / f64::from(SCAN));
        }
        None
    }

    /// Returns where the ray to a point `u` of the middle row of the box meets the stop, along x
    /// from its centre (mm); none if a surface cuts it before.
    fn at_stop(&self, start: FilmPoint, pupil_box: PupilBox, u: f64) -> Option<f64> {
        let ray = LensRay::new(start.film, start.direction([u, pupil_box.centre()[1]]));
        trace_one::<f64>(ray, &self.unobstructed[..self.to_stop]).map(|ray| ray.p[0]).ok()
    }

    /// Returns the point whose ray meets the centre of the stop, between two that meet it on
    /// either side.
    fn centre(
        &self,
        start: FilmPoint,
        pupil_box: PupilBox,
        [low, high]: [f64; 2],
    ) -> Option<[f64; 2]> {
        let side = self.at_stop(start, pupil_box, low)? > 0.0;
        let same = |u: f64| Some((self.at_stop(start, pupil_box, u)? > 0.0) == side);
        // Fifty halvings reach the precision of f64.
        let [u, _] = try_bisect([low, high], 50, same)?;
        Some([u, pupil_box.centre()[1]])
    }

    /// Returns the angle to the axis (degrees) at which the ray to a point of the plane of the rear
    /// vertex leaves the lens with all rims open; more than 90 if it goes backwards.
    pub fn leave(&self, start: FilmPoint, point: [f64; 2]) -> Option<f64> {
        let ray = LensRay::new(start.film, start.direction(point));
        let [tx, ty, tz] = trace_one::<f64>(ray, &self.unobstructed).ok()?.t;
        Some(tx.hypot(ty).atan2(tz).to_degrees())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::prescription::Row;

    /// A ball of glass with a stop in its middle, 3 mm before the film: the ray to its centre is not
    /// refracted.
    fn finder() -> StopFinder {
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
        let lens = Prescription::new("ball", rows).expect("one stop");
        let open = open_rims(&lens, KeptRims::Stop);
        StopFinder::new(&lens, 3.0, &sequence::<f32>(&open, Side::Film(3.0)))
    }

    #[test]
    fn the_chief_ray_is_found_where_most_of_the_searched_rays_are_cut() {
        let finder = finder();
        let start = |x: f64| FilmPoint {
            film: [x, 0.0, 0.0],
            normal: [0.0, 0.0, 1.0],
            distance: 3.0,
            index: 1.0,
        };
        // Steps of the first search are up to 8 mm apart, where the ball takes rays over some 10 mm.
        for (x, centre, size) in [(0.0, 0.3, 4.0), (1.0, 0.4, 60.0), (1.0, 0.9, 500.0)] {
            let middle = PupilBox::around(&[[centre, 0.0]]);
            let wide = middle.grown([size / 2.0, 2.0]);
            let angle = finder.chief_angle(start(x), wide).expect("a chief ray");
            let expected = (x / 9.0).atan().to_degrees();
            assert!((angle - expected).abs() < 1e-6, "{angle} for {expected}, {size} mm wide");
        }
    }

    #[test]
    fn no_chief_ray_is_found_where_all_rays_miss_the_lens() {
        let finder = finder();
        let start =
            FilmPoint { film: [0.0; 3], normal: [0.0, 0.0, 1.0], distance: 3.0, index: 1.0 };
        let beside = PupilBox::around(&[[900.0, -1.0], [990.0, 1.0]]);
        assert_eq!(finder.chief_angle(start, beside), None);
    }
}
