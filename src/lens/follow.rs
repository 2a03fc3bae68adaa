//! The pupil followed from film point to film point: where it is known, it is soon found nearby.

use super::outline::{Finder, Frame, Light};
use super::paraxial::Paraxial;
use super::prescription::Axis;
use super::survey::{Place, Survey};

/// Steps along the film radius that follow the light to its end, and halvings that find it.
const SEARCHES: [usize; 2] = [48, 20];

/// Follows the pupil across the film.
pub(super) struct Follow<'a> {
    survey: &'a Survey<'a>,
    pub finder: &'a mut Finder,
    /// How far the pupil moves per mm on the film, along x and y, by where it stands on the axis.
    drift: [f64; 2],
    /// The pupil of the middle of the film, as first-order optics has it.
    paraxial: Frame,
}

impl<'a> Follow<'a> {
    pub fn new(survey: &'a Survey<'a>, finder: &'a mut Finder) -> Self {
        let pupils =
            [Axis::X, Axis::Y].map(|axis| Paraxial::in_plane(survey.lens, axis).exit_pupil);
        let behind = pupils.map(|pupil| -pupil.position);
        let drift = behind.map(|behind| behind / (survey.distance + behind));
        // Seen from the film in the plane of the rear vertex.
        let half = [0, 1].map(|i| {
            let half = pupils[i].diameter / 2.0 * survey.distance;
            half / (survey.distance + behind[i]).abs()
        });
        let paraxial = Frame::around(&[half, half.map(|v| -v)]);
        Self { survey, finder, drift, paraxial }
    }

    /// The radius at which the light ends, mm, or that of the film.
    pub fn end(&mut self, radius: f64) -> f64 {
        let mut last = None;
        for i in 0..=SEARCHES[0] {
            let r = radius * i as f64 / SEARCHES[0] as f64;
            if let Some(light) = self.at(r, last) {
                last = Some((r, light.frame));
                continue;
            }
            let Some((mut lit, mut frame)) = last else { continue };
            let mut dark = r;
            for _ in 0..SEARCHES[1] {
                let middle = (lit + dark) / 2.0;
                match self.at(middle, Some((lit, frame))) {
                    Some(light) => (lit, frame) = (middle, light.frame),
                    None => dark = middle,
                }
            }
            return lit;
        }
        radius
    }

    /// The light of a film point on the u axis, near that of another if one is known.
    pub fn at(&mut self, r: f64, known: Option<(f64, Frame)>) -> Option<Light> {
        self.at_point([r, 0.0, 0.0], known.map(|(from, frame)| ([from, 0.0, 0.0], frame)))
    }

    /// The light of a film point, near that of another if one is known.
    pub fn at_point(&mut self, film: Place, known: Option<(Place, Frame)>) -> Option<Light> {
        let (expected, whole) = self.expected(film, known);
        self.finder.find(film, expected, whole)
    }

    /// A frame around that light.
    pub fn frame(&mut self, film: Place, known: Option<(Place, Frame)>) -> Option<Frame> {
        let (expected, whole) = self.expected(film, known);
        self.finder.frame(film, expected, whole)
    }

    /// Where the light of a film point is to be expected, and where at all it could be.
    fn expected(&self, film: Place, known: Option<(Place, Frame)>) -> (Frame, Frame) {
        let [cos, sin] = self.finder.turn;
        let turned = |[x, y]: [f64; 2]| [cos * x + sin * y, cos * y - sin * x];
        let by = |from: Place| turned([0, 1].map(|i| (film[i] - from[i]) * self.drift[i]));
        let (from, frame) = known.unwrap_or(([0.0; 3], self.paraxial));
        let seen: Vec<_> = self.survey.rear_outline(film).into_iter().map(turned).collect();
        (frame.moved(by(from)), Frame::around(&seen))
    }

    /// How far along a line from the axis, whose light is known, the light reaches, mm.
    pub fn end_along(&mut self, along: impl Fn(f64) -> Place, reach: f64, known: Frame) -> f64 {
        let (mut lit, mut frame) = (0.0, known);
        let steps = SEARCHES[0] / 2;
        let mut dark = None;
        for i in 1..=steps {
            let r = reach * i as f64 / steps as f64;
            match self.frame(along(r), Some((along(lit), frame))) {
                Some(found) => (lit, frame) = (r, found),
                None => {
                    dark = Some(r);
                    break;
                }
            }
        }
        let Some(mut dark) = dark else { return reach };
        // To a hundred thousandth of the film.
        for _ in 0..12 {
            let middle = (lit + dark) / 2.0;
            match self.frame(along(middle), Some((along(lit), frame))) {
                Some(found) => (lit, frame) = (middle, found),
                None => dark = middle,
            }
        }
        lit.max(1e-6 * reach)
    }
}
