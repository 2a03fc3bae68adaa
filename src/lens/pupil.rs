//! Where to aim: the part of the rear element through which a film point sees the scene.
//!
//! Points of the pupil live in the plane of the rear vertex, in the frame of their film point:
//! u away from the axis through the film point, v across. For some film points the outline of
//! the light is found by tracing and held by a [`Fan`]; between them fans are mixed, corner by
//! corner, because the pupil moves and closes evenly across the film. For a round lens the
//! points are a line of radii, for any other a grid over the film.
//!
//! The sampler mixes in a small share of points of the whole rear element, with the mixture's
//! density, so that light which a fan should miss is still counted and the picture stays
//! unbiased.

use super::fan::{Fan, TRIANGLES, Triangle};
use super::outline::{Finder, Frame, Light};
use super::paraxial::Paraxial;
use super::prescription::{Axis, Prescription};
use crate::rays::{Column, WAVE};

/// Rings of the film of a round lens; their edges have a fan each.
const RINGS: usize = 64;
/// Cells along each side of the film behind any other lens; their corners have a fan each.
const CELLS: usize = 24;
/// Share of the samples that go to the whole rear element.
pub const REAR_SHARE: f32 = 1.0 / 256.0;

/// By how much the ellipses around the rear element are widened, so that nothing of it is left
/// out.
const REAR_MARGIN: f32 = 1.002;
/// By how much fans are widened beyond the light that was found.
const FAN_MARGIN: f64 = 1.001;
/// The most that a fan is widened for the light between it and the next; what is still beyond
/// it, at the very rim of the image circle, is left to the share of the rear element.
const MOST_WIDENED: f64 = 1.5;

/// How film points choose where to aim.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Aim {
    /// At the bound of the exit pupil: few rays are lost, none are missed.
    #[default]
    Pupil,
    /// At the disk of the rear element's diameter in its vertex plane, as the course of 2016
    /// did: most rays are lost, and those that cross the rim outside the disk are missed.
    RearDisk,
}

/// An ellipse in the plane of the rear vertex, mm.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Ellipse {
    /// Its centre on the u axis.
    pub centre: f32,
    /// Half its width along u and along v.
    pub half: [f32; 2],
}

impl Ellipse {
    /// Its area, mm^2.
    pub fn area(&self) -> f32 {
        std::f32::consts::PI * self.half[0] * self.half[1]
    }

    fn scaled(self, by: f32) -> Self {
        Self { half: self.half.map(|half| half * by), ..self }
    }
}

/// The bounds of a lens's exit pupil for every film point.
#[derive(Clone, Debug)]
pub struct PupilBound {
    field: Field,
    /// What could hit the rear element from each of RINGS rings of equal width.
    rear: Vec<Ellipse>,
    rings_per_mm: f32,
    /// Share of samples that go to the rear element instead of the pupil.
    pub rear_share: f32,
}

/// Fans over the film.
#[derive(Clone, Debug)]
enum Field {
    /// No fans: all samples go to the rear element.
    Bare,
    /// By film radius, in the frame of the film point. Behind the edges of all rings stand two empty ones for the dark beyond.
    Round { fans: Box<[Fan; RINGS + 3]>, per_end: f32 },
    /// Row by row over the square around the film, in the frame of the film.
    Square { fans: Vec<Fan>, per_mm: f32, half: f32 },
}

/// Where among the rings a film point stands, by its share of the radius at which the light
/// ends: the pupil closes ever faster there, so rings grow narrow.
#[inline(always)]
fn place(share: f32) -> f32 {
    RINGS as f32 * (1.0 - (1.0 - share).max(0.0).sqrt())
}

/// The ring of a place; beyond the light, that of the dark.
#[inline(always)]
fn ring(place: f32) -> u32 {
    let ring = whole(place);
    if ring < RINGS as u32 { ring } else { RINGS as u32 + 1 }
}

/// The whole part of a number from 0 to 2^22; of a whole number perhaps the one before. By the
/// bits of a sum, because the conversion has no vector form.
#[inline(always)]
fn whole(number: f32) -> u32 {
    const UNIT: f32 = 8_388_608.0;
    ((number - 0.5).max(0.0) + UNIT).to_bits() & 0x7f_ffff
}

/// The corners of the cell around a film point, and how much each counts.
fn corners(per_mm: f32, half: f32, [x, y]: [f32; 2]) -> [(usize, f32); 4] {
    let split = |v: f32| {
        let place = ((v + half) * per_mm).clamp(0.0, CELLS as f32);
        let cell = (place as usize).min(CELLS - 1);
        (cell, place - cell as f32)
    };
    let ((i, s), (j, t)) = (split(x), split(y));
    let corner = |i: usize, j: usize| j * (CELLS + 1) + i;
    [
        (corner(i, j), (1.0 - s) * (1.0 - t)),
        (corner(i + 1, j), s * (1.0 - t)),
        (corner(i, j + 1), (1.0 - s) * t),
        (corner(i + 1, j + 1), s * t),
    ]
}

/// How a sample finds its point of the pupil: `centre + sqrt(v) edge`.
#[derive(Clone, Copy, Debug)]
pub(super) struct Target {
    pub centre: [f32; 2],
    pub edge: [f32; 2],
    /// Twice the area of the triangle that the sample is drawn from, mm^2; 0 for none.
    pub area2: f32,
    /// Density of the samples that come from elsewhere, mm^-2; 0 where the film sees no light.
    pub base: f32,
}

/// Columns for what is computed eight samples at a time before the fans are looked up.
#[derive(Clone, Debug, Default)]
pub(super) struct Lookup {
    ring: Column<u32>,
    ring_share: Column<f32>,
    rear: Column<u32>,
    triangle: Column<u32>,
    triangle_share: Column<f32>,
}

impl PupilBound {
    /// Finds the bounds for a film at `distance` mm behind the rear vertex that reaches to
    /// `radius` mm from the axis. Takes some milliseconds.
    pub fn new(lens: &Prescription, distance: f64, radius: f64, aim: Aim) -> Self {
        let outlines = Outlines { lens, distance };
        let edge = |i: usize| radius * i as f64 / RINGS as f64;
        let (rear, field, rear_share) = match aim {
            Aim::RearDisk => {
                let half = lens.rear().diameter as f32 / 2.0;
                let disk = Ellipse { centre: 0.0, half: [half; 2] };
                (vec![disk; RINGS], Field::Bare, 1.0)
            }
            Aim::Pupil => {
                let ring = |i: usize| outlines.rear_ellipse([edge(i), edge(i + 1)]);
                let rear = (0..RINGS).map(ring).collect();
                let field = match lens.is_round() {
                    true => outlines.rings(radius),
                    false => outlines.square(radius),
                };
                (rear, field, REAR_SHARE)
            }
        };
        Self { field, rear, rings_per_mm: (RINGS as f64 / radius) as f32, rear_share }
    }

    /// What could hit the rear element from a film point at this distance from the axis, mm.
    pub fn rear(&self, radius: f32) -> Ellipse {
        self.rear[self.rear_ring(radius) as usize]
    }

    #[inline(always)]
    fn rear_ring(&self, radius: f32) -> u32 {
        whole(radius * self.rings_per_mm).min(RINGS as u32 - 1)
    }

    /// Density of the samples of a triangle times twice its area.
    pub(super) fn triangle_density(&self) -> f32 {
        2.0 * (1.0 - self.rear_share) / TRIANGLES as f32
    }

    /// The light of a film point, mm, in its own frame, as far as tracing found it; an empty fan
    /// where all samples go to the rear element.
    pub fn fan(&self, [x, y]: [f32; 2]) -> Fan {
        let radius = x.hypot(y);
        match &self.field {
            Field::Bare => Fan::EMPTY,
            Field::Round { fans, per_end } => {
                let place = place(radius * per_end);
                let ring = ring(place);
                let t = place - ring as i32 as f32;
                let near = ring as usize;
                Fan::mix(&[(&fans[near], 1.0 - t), (&fans[near + 1], t)])
            }
            Field::Square { fans, per_mm, half } => {
                let (sin, cos) = if radius > 0.0 { (y / radius, x / radius) } else { (0.0, 1.0) };
                let turned = |[u, v]: [f32; 2]| [cos * u + sin * v, cos * v - sin * u];
                let around = corners(*per_mm, *half, [x, y]);
                let fan = Fan::mix(&around.map(|(corner, weight)| (&fans[corner], weight)));
                Fan { centre: turned(fan.centre), corners: fan.corners.map(turned) }
            }
        }
    }

    /// Chooses where samples aim: for every entry of the columns its film point and the two
    /// random numbers of its pupil point.
    pub(super) fn targets(
        &self,
        film: [&[f32]; 2],
        pupil: [&[f32]; 2],
        lookup: &mut Lookup,
        put: impl FnMut(usize, Target),
    ) {
        match &self.field {
            Field::Bare => self.bare_targets(film, pupil, put),
            Field::Round { fans, per_end } => {
                self.round_targets((fans, *per_end), film, pupil, lookup, put);
            }
            Field::Square { .. } => self.square_targets(film, pupil, put),
        }
    }

    #[inline(always)]
    fn round_targets(
        &self,
        (fans, per_end): (&[Fan; RINGS + 3], f32),
        film: [&[f32]; 2],
        pupil: [&[f32]; 2],
        lookup: &mut Lookup,
        mut put: impl FnMut(usize, Target),
    ) {
        let count = film[0].len().min(WAVE);
        let (x, y) = (&film[0][..count], &film[1][..count]);
        let (u, v) = (&pupil[0][..count], &pupil[1][..count]);
        let share = self.rear_share;
        let per_triangle = TRIANGLES as f32 / (1.0 - share);
        // Arithmetic first, over whole columns.
        for i in 0..count {
            let radius = (x[i] * x[i] + y[i] * y[i]).sqrt();
            let place = place(radius * per_end);
            let ring = ring(place);
            lookup.ring[i] = ring;
            lookup.ring_share[i] = place - ring as i32 as f32;
            lookup.rear[i] = self.rear_ring(radius);
            let place = (u[i] - share).max(0.0) * per_triangle;
            let triangle = whole(place).min(TRIANGLES as u32 - 1);
            lookup.triangle[i] = triangle;
            lookup.triangle_share[i] = place - triangle as i32 as f32;
        }
        let rear: [f32; RINGS] = std::array::from_fn(|i| share / self.rear[i].area());
        for i in 0..count {
            let ring = (lookup.ring[i] as usize).min(RINGS + 1);
            let triangle = lookup.triangle[i] as usize % TRIANGLES;
            let base = rear[lookup.rear[i] as usize % RINGS];
            let (near, far) = (&fans[ring], &fans[ring + 1]);
            let s = lookup.ring_share[i];
            let mix = |a: f32, b: f32| a + s * (b - a);
            let pair = |fan: &Fan| {
                let [[ax, ay], [bx, by]] = [fan.corners[triangle], fan.corners[triangle + 1]];
                [ax, ay, bx, by]
            };
            let (near_pair, far_pair) = (pair(near), pair(far));
            let [ax, ay, bx, by] = [0, 1, 2, 3].map(|k| mix(near_pair[k], far_pair[k]));
            let centre = [0, 1].map(|k| mix(near.centre[k], far.centre[k]));
            let area2 = ax * by - ay * bx;
            let t = lookup.triangle_share[i];
            let edge = [ax + t * (bx - ax), ay + t * (by - ay)];
            let base = if area2 > 0.0 { base } else { 0.0 };
            put(i, Target { centre, edge, area2, base });
            if u[i] < share {
                put(i, self.rear_target([x[i], y[i]], [u[i] / share, v[i]]));
            }
        }
    }

    #[inline(never)]
    fn square_targets(
        &self,
        film: [&[f32]; 2],
        pupil: [&[f32]; 2],
        mut put: impl FnMut(usize, Target),
    ) {
        let share = self.rear_share;
        for i in 0..film[0].len() {
            let (point, u, v) = ([film[0][i], film[1][i]], pupil[0][i], pupil[1][i]);
            if u < share {
                put(i, self.rear_target(point, [u / share, v]));
                continue;
            }
            let place = (u - share) * (TRIANGLES as f32 / (1.0 - share));
            let k = (place as usize).min(TRIANGLES - 1);
            let t = place - k as f32;
            let Triangle { centre, corners: [a, b] } = self.triangle(point, k);
            let area2 = Triangle { centre, corners: [a, b] }.area2();
            let edge = [a[0] + t * (b[0] - a[0]), a[1] + t * (b[1] - a[1])];
            let rear = self.rear(point[0].hypot(point[1]));
            let base = if area2 > 0.0 { share / rear.area() } else { 0.0 };
            put(i, Target { centre, edge, area2, base });
        }
    }

    /// One triangle of [`PupilBound::fan`], without the others.
    fn triangle(&self, [x, y]: [f32; 2], k: usize) -> Triangle {
        let Field::Square { fans, per_mm, half } = &self.field else {
            return self.fan([x, y]).triangle(k);
        };
        let around = corners(*per_mm, *half, [x, y]);
        let sum = |of: &dyn Fn(&Fan) -> [f32; 2]| {
            around.iter().fold([0.0; 2], |sum: [f32; 2], (corner, weight)| {
                let [x, y] = of(&fans[*corner]);
                [sum[0] + weight * x, sum[1] + weight * y]
            })
        };
        let radius = x.hypot(y);
        let (sin, cos) = if radius > 0.0 { (y / radius, x / radius) } else { (0.0, 1.0) };
        let turned = |[u, v]: [f32; 2]| [cos * u + sin * v, cos * v - sin * u];
        Triangle {
            centre: turned(sum(&|fan| fan.centre)),
            corners: [turned(sum(&|fan| fan.corners[k])), turned(sum(&|fan| fan.corners[k + 1]))],
        }
    }

    #[inline(never)]
    fn bare_targets(
        &self,
        film: [&[f32]; 2],
        pupil: [&[f32]; 2],
        mut put: impl FnMut(usize, Target),
    ) {
        for i in 0..film[0].len() {
            put(i, self.rear_target([film[0][i], film[1][i]], [pupil[0][i], pupil[1][i]]));
        }
    }

    /// A sample of the whole rear element: one in a hundred, where there are fans.
    #[inline(never)]
    fn rear_target(&self, film: [f32; 2], [u, v]: [f32; 2]) -> Target {
        let rear = self.rear(film[0].hypot(film[1]));
        let [disk_u, disk_v] = crate::sampler::disk(u, v);
        let point = [rear.half[0] * disk_u + rear.centre, rear.half[1] * disk_v];
        let fan = self.fan(film);
        let bare = matches!(self.field, Field::Bare);
        let base = match bare || fan.open() {
            true => (1.0 - self.rear_share) * fan.density(point) + self.rear_share / rear.area(),
            false => 0.0,
        };
        Target { centre: point, edge: [0.0; 2], area2: 0.0, base }
    }

    /// Whether light comes to any film point of a rectangle, mm.
    pub fn any_open(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        match &self.field {
            Field::Bare => true,
            Field::Round { fans, per_end } => {
                let near = |i: usize| low[i].max(-high[i]).max(0.0);
                let far = |i: usize| high[i].max(-low[i]);
                let at = |r: f64| ring(place(r as f32 * per_end));
                let length = |a: f64, b: f64| (a * a + b * b).sqrt();
                let (inner, outer) = (length(near(0), near(1)), length(far(0), far(1)));
                fans[at(inner) as usize..=at(outer) as usize + 1].iter().any(Fan::open)
            }
            Field::Square { fans, per_mm, half } => {
                let cell = |v: f64, up: f64| {
                    let place = (v + f64::from(*half)) * f64::from(*per_mm) + up;
                    place.clamp(0.0, CELLS as f64) as usize
                };
                let range = |i: usize| cell(low[i], 0.0)..=cell(high[i], 1.0);
                range(1).any(|j| range(0).any(|i| fans[j * (CELLS + 1) + i].open()))
            }
        }
    }
}

/// Measures a lens.
struct Outlines<'a> {
    lens: &'a Prescription,
    distance: f64,
}

impl Outlines<'_> {
    /// Fans along a radius of the film, up to where the light ends.
    fn rings(&self, radius: f64) -> Field {
        let mut finder = Finder::new(self.lens, self.distance);
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
        // The last point of the film, where it is lit, is not beyond the light.
        let fans = fans.try_into().expect("an edge for every ring, and two beyond");
        Field::Round { fans, per_end: ((1.0 - 1e-6) / end) as f32 }
    }

    /// Fans over the square around the film.
    fn square(&self, radius: f64) -> Field {
        let mut finder = Finder::new(self.lens, self.distance);
        let mut follow = Follow::new(self, &mut finder);
        let pitch = 2.0 * radius / CELLS as f64;
        let place = |i: usize, j: usize, by: f64| {
            [-radius + pitch * (i as f64 + by), -radius + pitch * (j as f64 + by)]
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
            let found = beside.flat_map(|(corners, _)| corners).find(|&&other| lit[other].open());
            if let Some(&other) = found {
                fans[k] = lit[other];
            }
        }
        let pairs: Vec<_> =
            cells.iter().map(|(corners, light)| (*corners, light.as_ref())).collect();
        widen(&mut fans, &pairs);
        Field::Square { fans, per_mm: (1.0 / pitch) as f32, half: radius as f32 }
    }

    /// The rear element seen from a film point at radius r and projected on its vertex plane.
    fn rear_outline(&self, r: f64) -> Vec<[f64; 2]> {
        let rear = self.lens.rear();
        let mut points = Vec::new();
        for ring in 0..=8 {
            let h = rear.diameter / 2.0 * f64::from(ring) / 8.0;
            // A cylinder stands level along one of the axes.
            let sags: &[f64] =
                if rear.axis.is_some() { &[0.0, rear.sag(h)] } else { &[rear.sag(h)] };
            for sag in sags {
                // The sag counts towards the film; the film is `distance` behind the vertex.
                let scale = self.distance / (self.distance - sag);
                for step in 0..64 {
                    let (sin, cos) = (std::f64::consts::PI * f64::from(step) / 32.0).sin_cos();
                    points.push([r + (h * cos - r) * scale, h * sin * scale]);
                }
            }
        }
        points
    }

    /// What holds the rear element seen from two radii, and from between them.
    fn rear_ellipse(&self, radii: [f64; 2]) -> Ellipse {
        let [inner, outer] = radii.map(|r| self.rear_outline(r));
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
    outlines: &'a Outlines<'a>,
    finder: &'a mut Finder,
    /// How far the pupil moves per mm on the film, along x and y, by where it stands on the axis.
    drift: [f64; 2],
    /// The pupil of the middle of the film, as first-order optics has it.
    paraxial: Frame,
}

impl<'a> Follow<'a> {
    fn new(outlines: &'a Outlines<'a>, finder: &'a mut Finder) -> Self {
        let pupils =
            [Axis::X, Axis::Y].map(|axis| Paraxial::in_plane(outlines.lens, axis).exit_pupil);
        let behind = pupils.map(|pupil| -pupil.position);
        let drift = behind.map(|behind| behind / (outlines.distance + behind));
        // Seen from the film in the plane of the rear vertex.
        let half = [0, 1].map(|i| {
            let half = pupils[i].diameter / 2.0 * outlines.distance;
            half / (outlines.distance + behind[i]).abs()
        });
        let paraxial = Frame::around(&[half, half.map(|v| -v)]);
        Self { outlines, finder, drift, paraxial }
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
        self.at_point([r, 0.0], known.map(|(from, frame)| ([from, 0.0], frame)))
    }

    /// The light of a film point in the frame of the film.
    fn at_point(&mut self, film: [f64; 2], known: Option<([f64; 2], Frame)>) -> Option<Light> {
        let r = film[0].hypot(film[1]);
        let (sin, cos) = if r > 0.0 { (film[1] / r, film[0] / r) } else { (0.0, 1.0) };
        let turned: Vec<_> = self
            .outlines
            .rear_outline(r)
            .into_iter()
            .map(|[u, v]| [cos * u - sin * v, sin * u + cos * v])
            .collect();
        let by = |from: [f64; 2]| [0, 1].map(|i| (film[i] - from[i]) * self.drift[i]);
        let (from, frame) = known.unwrap_or(([0.0; 2], self.paraxial));
        self.finder.find(film, frame.moved(by(from)), Frame::around(&turned))
    }
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
    // Rounding to f32 must not cut anything off, nor leave a zero width.
    let grow = |half: f64| (half * 1.000_001).max(1e-9) as f32;
    Ellipse { centre: centre as f32, half: [grow(a), grow(b)] }
}
