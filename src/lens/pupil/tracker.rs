//! Tracking of the pupil from film point to film point: a known pupil locates that of a neighbour.

use petzval_base::bisection::bisect;

use super::outline::{OutlineFinder, PupilBox, PupilOutline};
use super::table::{FilmPosition, TableBuilder};
use crate::focus::paraxial::Paraxial;
use crate::prescription::TransverseAxis;

/// Steps along the film radius towards the edge of the light.
const STEPS: usize = 48;
/// Bisections that locate the edge on a round lens.
const BISECTIONS: u32 = 20;
/// Bisections that locate the edge along a line, to 1e-5 of the film.
const LINE_BISECTIONS: u32 = 12;

/// Tracker of the pupil across the film.
pub(crate) struct PupilTracker<'a> {
    builder: &'a TableBuilder<'a>,
    pub finder: &'a mut OutlineFinder,
    /// Displacement of the pupil in the rear vertex plane per displacement on the film, along x and
    /// y, by first-order optics.
    drift: [f64; 2],
    /// Pupil of the middle of the film by first-order optics.
    paraxial: PupilBox,
}

impl<'a> PupilTracker<'a> {
    pub fn new(builder: &'a TableBuilder<'a>, finder: &'a mut OutlineFinder) -> Self {
        let pupils = [TransverseAxis::X, TransverseAxis::Y]
            .map(|axis| Paraxial::in_plane(builder.lens, axis).exit_pupil);
        let behind = pupils.map(|pupil| -pupil.position);
        let drift = behind.map(|behind| behind / (builder.distance + behind));
        // Projected from the film to the plane of the rear vertex.
        let half = [0, 1].map(|i| {
            let half = pupils[i].diameter / 2.0 * builder.distance;
            half / (builder.distance + behind[i]).abs()
        });
        let paraxial = PupilBox::around(&[half, half.map(|v| -v)]);
        Self { builder, finder, drift, paraxial }
    }

    /// Returns the film radius at which the light ends, or `radius` if that is smaller (mm).
    pub fn light_radius(&mut self, radius: f64) -> f64 {
        let mut last = None;
        for i in 0..=STEPS {
            let r = radius * i as f64 / STEPS as f64;
            if let Some(light) = self.outline_at_radius(r, last) {
                last = Some((r, light.bounds));
                continue;
            }
            let Some(mut known) = last else { continue };
            let ends = [known.0, r];
            let lit = |middle: f64| {
                let light = self.outline_at_radius(middle, Some(known));
                light.map(|light| known = (middle, light.bounds)).is_some()
            };
            return bisect(ends, BISECTIONS, lit)[0];
        }
        radius
    }

    /// Finds the pupil of a film point on the u axis, near that of another if one is known.
    pub fn outline_at_radius(
        &mut self,
        r: f64,
        known: Option<(f64, PupilBox)>,
    ) -> Option<PupilOutline> {
        self.outline([r, 0.0, 0.0], known.map(|(from, frame)| ([from, 0.0, 0.0], frame)))
    }

    /// Finds the pupil of a film point, near that of another if one is known.
    pub fn outline(
        &mut self,
        film: FilmPosition,
        known: Option<(FilmPosition, PupilBox)>,
    ) -> Option<PupilOutline> {
        let (expected, whole) = self.expected(film, known);
        self.finder.find(film, expected, whole)
    }

    /// Finds a box around that pupil.
    pub fn bounding_box(
        &mut self,
        film: FilmPosition,
        known: Option<(FilmPosition, PupilBox)>,
    ) -> Option<PupilBox> {
        let (expected, whole) = self.expected(film, known);
        self.finder.find_bounds(film, expected, whole)
    }

    /// Returns the box in which the pupil of a film point is expected, and the box that contains
    /// it.
    fn expected(
        &self,
        film: FilmPosition,
        known: Option<(FilmPosition, PupilBox)>,
    ) -> (PupilBox, PupilBox) {
        let [cos, sin] = self.finder.turn;
        let rotated = |[x, y]: [f64; 2]| [cos * x + sin * y, cos * y - sin * x];
        let by = |from: FilmPosition| rotated([0, 1].map(|i| (film[i] - from[i]) * self.drift[i]));
        let (from, frame) = known.unwrap_or(([0.0; 3], self.paraxial));
        let seen: Vec<_> = self.builder.rear_outline(film).into_iter().map(rotated).collect();
        (frame.moved(by(from)), PupilBox::around(&seen))
    }

    /// Returns the distance along a line from the axis at which the light ends, at most `reach`
    /// (mm). `known` is the box on the axis.
    pub fn light_end_along(
        &mut self,
        along: impl Fn(f64) -> FilmPosition,
        reach: f64,
        known: PupilBox,
    ) -> f64 {
        let (mut lit, mut frame) = (0.0, known);
        let steps = STEPS / 2;
        let mut dark = None;
        for i in 1..=steps {
            let r = reach * i as f64 / steps as f64;
            match self.bounding_box(along(r), Some((along(lit), frame))) {
                Some(found) => (lit, frame) = (r, found),
                None => {
                    dark = Some(r);
                    break;
                }
            }
        }
        let Some(dark) = dark else { return reach };
        let mut known = (lit, frame);
        let lights = |middle: f64| {
            let found = self.bounding_box(along(middle), Some((along(known.0), known.1)));
            found.map(|found| known = (middle, found)).is_some()
        };
        let [lit, _] = bisect([lit, dark], LINE_BISECTIONS, lights);
        lit.max(1e-6 * reach)
    }
}
