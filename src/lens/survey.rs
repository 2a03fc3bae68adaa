//! Measuring the pupil of a lens all over the film.

use glam::{DAffine3, DVec3};

use super::fan::Fan;
use super::outline::{Finder, Frame, Light};
use super::paraxial::Paraxial;
use super::pose::Pose;
use super::prescription::{Axis, Prescription};
use super::pupil::{CELLS, Ellipse, Field, RINGS, Rows};

/// By how much the ellipses around the rear element are widened, so that nothing of it is left
/// out.
const REAR_MARGIN: f32 = 1.002;
/// By how much fans are widened beyond the light that was found.
const FAN_MARGIN: f64 = 1.001;
/// The most that a fan is widened for the light between it and the next; what is still beyond
/// it, at the very rim of the image circle, is left to the share of the rear element.
const MOST_WIDENED: f64 = 1.5;

/// Measures a lens.
pub(super) struct Survey<'a> {
    pub lens: &'a Prescription,
    pub distance: f64,
    /// How the film stands.
    pub pose: Pose,
}

/// A point of the film as rays start from it, mm: x, y, and z towards the scene, from where the
/// square film's plane meets the axis.
type Place = [f64; 3];

impl Survey<'_> {
    /// Fans along a radius of the film, up to where the light ends.
    pub fn rings(&self, radius: f64) -> Field {
        let mut finder = Finder::new(self.lens, self.distance, true);
        let mut follow = Follow::new(self, &mut finder);
        let end = follow.end(radius);
        let mut fans = Vec::with_capacity(RINGS + 3);
        let mut between = Vec::with_capacity(RINGS);
        let mut last = None;
        for i in 0..=2 * RINGS {
            // The inverse of `place`.
            let rest = 1.0 - i as f64 / (2 * RINGS) as f64;
            let r = end * (1.0 - rest * rest);
            let light = follow.at(r, last);
            if let Some(light) = &light {
                last = Some((r, light.frame));
            }
            match i % 2 {
                0 => fans.push(fan(light.as_ref())),
                _ => between.push(light),
            }
        }
        let pairs: Vec<_> = (0..RINGS).map(|i| ([i, i + 1], between[i].as_ref())).collect();
        widen(&mut fans, &pairs);
        fans.push(Fan::EMPTY);
        fans.push(Fan::EMPTY);
        let open = fans.iter().rev().fold(0, |bits, fan| bits << 1 | u128::from(fan.open()));
        let rows = Rows::of(&fans);
        let fans = fans.try_into().expect("an edge for every ring, and two beyond");
        // The last point of the film, where it is lit, is not beyond the light.
        Field::Round { fans, rows, open, per_end: ((1.0 - 1e-6) / end) as f32 }
    }

    /// Fans over the square around the film, and what could hit the rear element from each of its
    /// cells.
    pub fn grid(&self, radius: f64) -> (Field, Vec<Ellipse>) {
        let mut finder = Finder::new(self.lens, self.distance, false);
        let mut follow = Follow::new(self, &mut finder);
        let pitch = 2.0 * radius / CELLS as f64;
        let place = |i: usize, j: usize, by: f64| {
            self.pose.film_point([i, j].map(|i| -radius + pitch * (i as f64 + by)))
        };
        let side = CELLS + 1;
        let mut lights: Vec<Option<Light>> = Vec::with_capacity(side * side);
        for j in 0..side {
            for i in 0..side {
                // What is next to it, and known.
                let beside = (i > 0).then(|| (lights.len() - 1, place(i - 1, j, 0.0)));
                let under = (j > 0).then(|| (lights.len() - side, place(i, j - 1, 0.0)));
                let known = [beside, under]
                    .into_iter()
                    .flatten()
                    .find_map(|(k, at)| Some((at, lights[k].as_ref()?.frame)));
                lights.push(follow.at_point(place(i, j, 0.0), known));
            }
        }
        let mut fans: Vec<Fan> = lights.iter().map(|light| fan(light.as_ref())).collect();
        let mut cells = Vec::with_capacity(CELLS * CELLS);
        for j in 0..CELLS {
            for i in 0..CELLS {
                let corners =
                    [(i, j), (i + 1, j), (i, j + 1), (i + 1, j + 1)].map(|(i, j)| j * side + i);
                let known = corners.iter().find_map(|&k| {
                    Some((place(k % side, k / side, 0.0), lights[k].as_ref()?.frame))
                });
                cells.push((corners, follow.at_point(place(i, j, 0.5), known)));
            }
        }
        // A corner in the dark takes the fan of a lit one that shares a cell with it.
        let dark: Vec<usize> = (0..fans.len()).filter(|&k| !fans[k].open()).collect();
        let lit = fans.clone();
        for k in dark {
            let beside = cells.iter().filter(|(corners, _)| corners.contains(&k));
            let mut around = beside.clone().flat_map(|(corners, _)| corners);
            if let Some(&other) = around.find(|&&other| lit[other].open()) {
                fans[k] = lit[other];
            } else if let Some(light) = beside.filter_map(|(_, light)| light.as_ref()).next() {
                fans[k] = fan(Some(light));
            }
        }
        let pairs: Vec<_> =
            cells.iter().map(|(corners, light)| (*corners, light.as_ref())).collect();
        widen(&mut fans, &pairs);
        // Seen from a point of a cell, the rear element lies within what it is seen as from the
        // cell's corners: a projection keeps what is between points between them.
        let seen: Vec<_> =
            (0..side * side).map(|k| self.rear_outline(place(k % side, k / side, 0.0))).collect();
        let rear = |corners: &[usize; 4]| oval(&corners.map(|k| seen[k].clone()).concat());
        let rear = cells.iter().map(|(corners, _)| rear(corners).scaled(REAR_MARGIN)).collect();
        (Field::Grid { fans, per_mm: (1.0 / pitch) as f32, half: radius as f32 }, rear)
    }

    /// The rear element seen from a film point and projected on the plane of its square vertex.
    pub fn rear_outline(&self, [x, y, z]: Place) -> Vec<[f64; 2]> {
        let rear = self.lens.rear();
        let placed = self.rear_motion();
        let ahead = self.distance - z;
        let mut points = Vec::new();
        for ring in 0..=8 {
            let h = rear.diameter / 2.0 * f64::from(ring) / 8.0;
            // A cylinder stands level along one of the axes.
            let sags: &[f64] =
                if rear.axis.is_some() { &[0.0, rear.sag(h)] } else { &[rear.sag(h)] };
            for sag in sags {
                for step in 0..64 {
                    let (sin, cos) = (std::f64::consts::PI * f64::from(step) / 32.0).sin_cos();
                    let rim = placed.transform_point3(DVec3::new(h * cos, h * sin, *sag));
                    // z of the lens counts towards the film, which stands behind all of it.
                    let scale = ahead / (ahead - rim.z).max(1e-3 * ahead);
                    points.push([x + (rim.x - x) * scale, y + (rim.y - y) * scale]);
                }
            }
        }
        points
    }

    /// Where points of the rear surface stand relative to the vertex of the square lens.
    fn rear_motion(&self) -> DAffine3 {
        if !self.lens.is_askew() {
            return DAffine3::IDENTITY;
        }
        let placed = self.lens.placements()[self.lens.rows.len() - 1];
        DAffine3::from_translation(DVec3::new(0.0, 0.0, -self.lens.length())) * placed
    }

    /// What holds the rear element seen from two radii, and from between them.
    pub fn rear_ellipse(&self, radii: [f64; 2]) -> Ellipse {
        let [inner, outer] = radii.map(|r| self.rear_outline([r, 0.0, 0.0]));
        bounding_ellipse(&[inner, outer].concat()).scaled(REAR_MARGIN)
    }
}

/// Steps along the film radius that follow the light to its end, and halvings that find it.
const SEARCHES: [usize; 2] = [48, 20];

/// The fan that holds some light, if there is any.
fn fan(light: Option<&Light>) -> Fan {
    light.map_or(Fan::EMPTY, |light| Fan::around(light.centre, &light.outline))
}

/// Widens fans until their mixture holds the light half-way between them.
fn widen<const N: usize>(fans: &mut [Fan], between: &[([usize; N], Option<&Light>)]) {
    let mut by = vec![FAN_MARGIN; fans.len()];
    for (corners, light) in between {
        let Some(light) = light else { continue };
        let mixed = Fan::mix(&corners.map(|k| (&fans[k], 1.0 / N as f32)));
        let reach = light.outline.iter().fold(0.0f64, |reach, point| {
            reach.max(mixed.reach([0, 1].map(|axis| light.centre[axis] + point[axis])))
        });
        for &k in corners {
            by[k] = by[k].max((reach * FAN_MARGIN).min(MOST_WIDENED));
        }
    }
    for (fan, by) in fans.iter_mut().zip(by) {
        *fan = fan.scaled(by as f32);
    }
}

/// Follows the pupil across the film.
struct Follow<'a> {
    survey: &'a Survey<'a>,
    finder: &'a mut Finder,
    /// How far the pupil moves per mm on the film, along x and y, by where it stands on the axis.
    drift: [f64; 2],
    /// The pupil of the middle of the film, as first-order optics has it.
    paraxial: Frame,
}

impl<'a> Follow<'a> {
    fn new(survey: &'a Survey<'a>, finder: &'a mut Finder) -> Self {
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
    fn end(&mut self, radius: f64) -> f64 {
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
    fn at(&mut self, r: f64, known: Option<(f64, Frame)>) -> Option<Light> {
        self.at_point([r, 0.0, 0.0], known.map(|(from, frame)| ([from, 0.0, 0.0], frame)))
    }

    /// The light of a film point.
    fn at_point(&mut self, film: Place, known: Option<(Place, Frame)>) -> Option<Light> {
        let by = |from: Place| [0, 1].map(|i| (film[i] - from[i]) * self.drift[i]);
        let (from, frame) = known.unwrap_or(([0.0; 3], self.paraxial));
        let whole = Frame::around(&self.survey.rear_outline(film));
        self.finder.find(film, frame.moved(by(from)), whole)
    }
}

/// An ellipse around points, as wide to high as they are.
fn oval(points: &[[f64; 2]]) -> Ellipse {
    let frame = Frame::around(points);
    let (middle, half) = (frame.middle(), frame.size().map(|size| (size / 2.0).max(1e-12)));
    let reach = points.iter().fold(0.0, |reach: f64, point| {
        reach.max((0..2).map(|i| ((point[i] - middle[i]) / half[i]).powi(2)).sum())
    });
    Ellipse {
        centre: middle.map(|v| v as f32),
        half: half.map(|half| rounded_up(half * reach.sqrt())),
    }
}

/// To f32 without cutting anything off or leaving a zero width.
fn rounded_up(half: f64) -> f32 {
    (half * 1.000_001).max(1e-9) as f32
}

/// A small ellipse, its axes along u and v and its centre on u, around points that are their own
/// mirror image in v.
fn bounding_ellipse(points: &[[f64; 2]]) -> Ellipse {
    let frame = Frame::around(points);
    let centre = frame.middle()[0];
    let half_width = (frame.size()[0] / 2.0).max(1e-12);
    let half_height = |a: f64| {
        points.iter().fold(0.0, |b: f64, &[u, v]| {
            let x = (u - centre) / a;
            if v <= 0.0 { b } else { b.max(v / (1.0 - x * x).max(0.0).sqrt()) }
        })
    };
    let candidates = (0..=30).map(|step| half_width * (1.0 + 0.02 * f64::from(step)));
    let [a, b] = candidates.map(|a| [a, half_height(a)]).fold([f64::INFINITY; 2], |best, new| {
        if new[0] * new[1] < best[0] * best[1] { new } else { best }
    });
    Ellipse { centre: [centre as f32, 0.0], half: [a, b].map(rounded_up) }
}
