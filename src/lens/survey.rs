//! Measuring the pupil of a lens all over the film.

use glam::{DAffine3, DMat2, DVec2, DVec3};

use super::fan::Fan;
use super::follow::Follow;
use super::outline::{Finder, Frame, Light};
use super::polar::{Polar, SPOKES, STEPS, direction, share};
use super::pose::Pose;
use super::prescription::Prescription;
use super::pupil::{CELLS, Ellipse, Field, RINGS};
use super::target::Steps;

/// By how much the ellipses around the rear element are widened, so that nothing of it is left
/// out.
const REAR_MARGIN: f32 = 1.002;
/// By how much fans are widened beyond the light that was found.
const FAN_MARGIN: f64 = 1.002;
/// The most that a fan is widened for the light between it and the next; what is still beyond
/// it, at the very rim of the image circle, is left to the share of the rear element.
const MOST_WIDENED: f64 = 1.5;

/// Into how many parts the light is looked at from one ring of a round lens to the next.
const PARTS: usize = 4;

/// Measures a lens.
pub(super) struct Survey<'a> {
    pub lens: &'a Prescription,
    /// The same lens in other colours, whose light is to be found too.
    pub others: &'a [Prescription],
    pub distance: f64,
    /// How the film stands.
    pub pose: Pose,
}

/// A point of the film as rays start from it, mm: x, y, and z towards the scene, from where the
/// square film's plane meets the axis.
pub(super) type Place = [f64; 3];

impl Survey<'_> {
    fn finder(&self, mirrored: bool) -> Finder {
        let all = std::iter::once(self.lens).chain(self.others);
        Finder::new(all, self.distance, mirrored)
    }

    /// Fans along a radius of the film, up to where the light ends.
    pub fn rings(&self, radius: f64) -> Field {
        let mut finder = self.finder(true);
        let mut follow = Follow::new(self, &mut finder);
        let end = follow.end(radius);
        let mut fans = Vec::with_capacity(RINGS + 3);
        let mut between = Vec::with_capacity(RINGS * (PARTS - 1));
        let mut last = None;
        for i in 0..=PARTS * RINGS {
            // The inverse of `place`.
            let rest = 1.0 - i as f64 / (PARTS * RINGS) as f64;
            let r = end * (1.0 - rest * rest);
            let light = follow.at(r, last);
            if let Some(light) = &light {
                last = Some((r, light.frame));
            }
            let (ring, part) = (i / PARTS, i % PARTS);
            if part == 0 {
                fans.push(fan(light.as_ref()));
            } else if let Some(light) = light {
                let share = part as f32 / PARTS as f32;
                between.push(Between { around: [(ring, 1.0 - share), (ring + 1, share)], light });
            }
        }
        widen(&mut fans, &between);
        fans.push(Fan::EMPTY);
        fans.push(Fan::EMPTY);
        let open = fans.iter().rev().fold(0, |bits, fan| bits << 1 | u128::from(fan.open()));
        let steps = Steps::of(&fans);
        let fans = fans.try_into().expect("an edge for every ring, and two beyond");
        // The last point of the film, where it is lit, is not beyond the light.
        Field::Round { fans, steps, open, per_end: ((1.0 - 1e-6) / end) as f32 }
    }

    /// Fans over a film of this half width and height, mm.
    pub fn grid(&self, half: [f64; 2]) -> Field {
        let mut finder = self.finder(false);
        let mut follow = Follow::new(self, &mut finder);
        let place = |i: usize, j: usize, by: f64| self.cell(half, [i, j].map(|i| i as f64 + by));
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
        widen(&mut fans, &amid(cells));
        Field::Grid { fans }
    }

    /// A corner of a grid over a film of this half width and height, or a place between two.
    fn cell(&self, half: [f64; 2], at: [f64; 2]) -> Place {
        self.pose.film_point([0, 1].map(|i| half[i] * (2.0 * at[i] / CELLS as f64 - 1.0)))
    }

    /// What could hit the rear element from each cell of a grid over the film.
    pub fn rear_cells(&self, half: [f64; 2]) -> Vec<Ellipse> {
        // Seen from a point of a cell, the rear element lies within what it is seen as from the
        // cell's corners: a projection keeps what is between points between them.
        let cell = |k: usize| {
            let corner = |i: usize, j: usize| {
                self.rear_outline(self.cell(half, [k % CELLS + i, k / CELLS + j].map(|i| i as f64)))
            };
            let seen = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
            oval(&seen.concat()).scaled(REAR_MARGIN)
        };
        (0..CELLS * CELLS).map(cell).collect()
    }

    /// Fans by spokes and rings about where the axis meets the film; nothing where that is dark.
    pub fn spokes(&self, half: [f64; 2]) -> Option<Field> {
        let mut finder = self.finder(false);
        let mut follow = Follow::new(self, &mut finder);
        let turn = self.pose.motion().matrix3;
        let level = DMat2::from_cols(turn.x_axis.truncate(), turn.y_axis.truncate());
        let pole = level.inverse() * -DVec2::from(self.pose.decentre);
        let corners = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        let reach = corners.map(|[x, y]| pole.distance(DVec2::new(x * half[0], y * half[1])));
        let reach = reach.into_iter().fold(0.0, f64::max);
        let place = |spoke: f64, r: f64| {
            let [x, y] = direction(spoke);
            self.pose.film_point([pole.x + r * x, pole.y + r * y])
        };
        let middle = follow.frame(place(0.0, 0.0), None)?;
        let mut ends = [0.0; SPOKES];
        let mut fans = Vec::with_capacity(SPOKES * (STEPS + 1));
        let mut frames = Vec::with_capacity(SPOKES * (STEPS + 1));
        for (spoke, end) in ends.iter_mut().enumerate() {
            let along = |r: f64| place(spoke as f64, r);
            follow.finder.turn = direction(spoke as f64);
            *end = follow.end_along(along, reach, middle);
            let mut last = (along(0.0), middle);
            for ring in 0..=STEPS {
                let at = along(*end * share(ring as f64));
                let light = follow.at_point(at, Some(last));
                if let Some(light) = &light {
                    last = (at, light.frame);
                }
                fans.push(fan(light.as_ref()));
                frames.push(last);
            }
        }
        let mut between = Vec::with_capacity(SPOKES * STEPS);
        for spoke in 0..SPOKES {
            follow.finder.turn = direction(spoke as f64 + 0.5);
            let per_end = (1.0 / ends[spoke] + 1.0 / ends[(spoke + 1) % SPOKES]) / 2.0;
            for ring in 0..STEPS {
                let at = place(spoke as f64 + 0.5, share(ring as f64 + 0.5) / per_end);
                let known = frames[Polar::place(spoke, ring)];
                let around = [(0, 0), (1, 0), (0, 1), (1, 1)];
                let corners = around.map(|(i, j)| Polar::place(spoke + i, ring + j));
                between.push((corners, follow.at_point(at, Some(known))));
            }
        }
        widen(&mut fans, &amid(between));
        // The last point of the film, where it is lit, is not beyond the light.
        let ends = ends.map(|end| end * (1.0 + 1e-6));
        Some(Field::Polar(Polar::new(pole.to_array(), &ends, fans)))
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

/// The fan that holds some light, if there is any.
fn fan(light: Option<&Light>) -> Fan {
    light.map_or(Fan::EMPTY, |light| Fan::around(light.centre, &light.outline))
}

/// Light that was found between fans.
struct Between<const N: usize> {
    /// The fans around it, and the share of each in the mixture there.
    around: [(usize, f32); N],
    light: Light,
}

/// Light in the middle of four fans, where there is any.
fn amid(cells: Vec<([usize; 4], Option<Light>)>) -> Vec<Between<4>> {
    let one = |(corners, light): ([usize; 4], Option<Light>)| {
        Some(Between { around: corners.map(|k| (k, 0.25)), light: light? })
    };
    cells.into_iter().filter_map(one).collect()
}

/// Widens fans until their mixtures hold the light between them.
fn widen<const N: usize>(fans: &mut [Fan], between: &[Between<N>]) {
    let mut by = vec![FAN_MARGIN; fans.len()];
    for Between { around, light } in between {
        let mixed = Fan::mix(&around.map(|(k, share)| (&fans[k], share)));
        let reach = light.outline.iter().fold(0.0f64, |reach, point| {
            reach.max(mixed.reach([0, 1].map(|axis| light.centre[axis] + point[axis])))
        });
        for (k, _) in around {
            by[*k] = by[*k].max((reach * FAN_MARGIN).min(MOST_WIDENED));
        }
    }
    for (fan, by) in fans.iter_mut().zip(by) {
        *fan = fan.scaled(by as f32);
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
