//! Where to aim: the part of the rear element through which a film point sees the scene.
//!
//! Points of the pupil live in the plane of the rear vertex, in the frame of their film
//! point: u away from the axis through the film point, v across. The lens is a body of
//! revolution, so a table over the film radius says it all: ellipses that bound the light at
//! this radius, found by tracing. The sampler mixes in a small
//! share of points of the whole rear element, with the mixture's density, so that light
//! which the ellipse should miss is still counted and the picture stays unbiased.

use super::paraxial::Paraxial;
use super::prescription::Prescription;
use super::surface::{From, Surface, sequence};
use super::trace::trace;
use crate::lanes::f32x8;
use crate::rays::{LensBatch, WAVE};

/// Rings of the film; their edges have an ellipse each.
const RINGS: usize = 64;
/// Columns and rows of the last grid that measures a pupil; the rows cover half of it.
const GRID: [usize; 2] = [96, 48];
/// Share of the samples that go to the whole rear element.
pub const REAR_SHARE: f32 = 1.0 / 64.0;

/// By how much the ellipses around the rear element are widened, so that between two rings,
/// where they are mixed, nothing of it is left out.
const REAR_MARGIN: f32 = 1.002;

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

    #[inline(always)]
    fn mix(&self, other: &Self, t: f32) -> Self {
        let mix = |a: f32, b: f32| a + (b - a) * t;
        Self {
            centre: mix(self.centre, other.centre),
            half: [0, 1].map(|i| mix(self.half[i], other.half[i])),
        }
    }
}

/// Bounds for one film radius.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Bound {
    /// Holds the light, as far as tracing found it; of no width where there is none.
    pub pupil: Ellipse,
    /// Holds everything that could hit the rear element.
    pub rear: Ellipse,
}

impl Bound {
    /// Whether any light comes to this radius at all.
    pub fn open(&self) -> bool {
        self.pupil.half[0] > 0.0
    }
}

/// The bounds of a lens's exit pupil for every film radius.
#[derive(Clone, Debug)]
pub struct PupilBound {
    /// Inner and outer edge of every ring. Where light ends inside a ring, both edges have the
    /// bound of the lit one.
    rings: Vec<[Bound; 2]>,
    rings_per_mm: f32,
    /// Share of samples that go to the rear element instead of the pupil.
    pub rear_share: f32,
}

impl PupilBound {
    /// Finds the bounds for a film at `distance` mm behind the rear vertex that reaches to
    /// `radius` mm from the axis. Takes some milliseconds.
    pub fn new(lens: &Prescription, distance: f64, radius: f64, aim: Aim) -> Self {
        let rings_per_mm = (RINGS as f64 / radius) as f32;
        if aim == Aim::RearDisk {
            let half = lens.rear().diameter as f32 / 2.0;
            let disk = Ellipse { centre: 0.0, half: [half; 2] };
            let bound = Bound { pupil: disk, rear: disk };
            return Self { rings: vec![[bound; 2]; RINGS], rings_per_mm, rear_share: 0.0 };
        }
        let mut finder = Finder {
            surfaces: sequence::<f32x8>(lens, From::Film(distance)),
            batch: Box::default(),
            distance,
        };
        // How far the pupil moves per mm on the film, at first by where it stands on the axis.
        let behind = -Paraxial::of(lens).exit_pupil.position;
        let mut drift = behind / (distance + behind);
        let mut last: Option<(f64, Frame)> = None;
        let edges: Vec<Bound> = (0..=RINGS)
            .map(|i| {
                let r = radius * i as f64 / RINGS as f64;
                let outline = rear_outline(lens, distance, r);
                let expected = last.map(|(from, frame)| frame.moved((r - from) * drift));
                let light = finder.find(r, expected, Frame::around(&outline));
                if !light.points.is_empty() {
                    if let Some((from, frame)) = last {
                        drift = (light.frame.middle() - frame.middle()) / (r - from);
                    }
                    last = Some((r, light.frame));
                }
                let rear = bounding_ellipse(&outline, [0.0; 2]).scaled(REAR_MARGIN);
                Bound { pupil: bounding_ellipse(&light.points, light.cell), rear }
            })
            .collect();
        let rings = edges
            .windows(2)
            .map(|pair| match [pair[0], pair[1]] {
                [inner, outer] if inner.open() && !outer.open() => {
                    [inner, Bound { pupil: inner.pupil, ..outer }]
                }
                [inner, outer] if !inner.open() && outer.open() => {
                    [Bound { pupil: outer.pupil, ..inner }, outer]
                }
                both => both,
            })
            .collect();
        Self { rings, rings_per_mm, rear_share: REAR_SHARE }
    }

    /// The bounds for a film point at this distance from the axis, mm: between those of the
    /// edges of its ring, because the pupil moves evenly across the film.
    #[inline(always)]
    pub fn at(&self, radius: f32) -> Bound {
        let place = radius * self.rings_per_mm;
        let ring = (place as usize).min(RINGS - 1);
        let [inner, outer] = &self.rings[ring];
        let t = (place - ring as f32).min(1.0);
        Bound { pupil: inner.pupil.mix(&outer.pupil, t), rear: inner.rear.mix(&outer.rear, t) }
    }

    /// Whether light comes to any film point between two distances from the axis, mm.
    pub fn any_open(&self, inner: f32, outer: f32) -> bool {
        let ring = |r: f32| ((r * self.rings_per_mm) as usize).min(RINGS - 1);
        self.rings[ring(inner)..=ring(outer)].iter().any(|[inner, _]| inner.open())
    }
}

/// A rectangle of pupil points, u from `low` to `high`, v from 0 to `height`.
#[derive(Clone, Copy, Debug)]
struct Frame {
    low: f64,
    high: f64,
    height: f64,
}

impl Frame {
    fn around(points: &[[f64; 2]]) -> Self {
        points.iter().fold(
            Self { low: f64::INFINITY, high: f64::NEG_INFINITY, height: 0.0 },
            |frame, &[u, v]| Self {
                low: frame.low.min(u),
                high: frame.high.max(u),
                height: frame.height.max(v),
            },
        )
    }

    fn grown(self, by: [f64; 2]) -> Self {
        Self { low: self.low - by[0], high: self.high + by[0], height: self.height + by[1] }
    }

    fn moved(self, by: f64) -> Self {
        Self { low: self.low + by, high: self.high + by, ..self }
    }

    fn middle(self) -> f64 {
        (self.low + self.high) / 2.0
    }

    fn width(self) -> f64 {
        self.high - self.low
    }
}

/// The outline of the pupil through which one film point sees light.
#[derive(Clone, Debug)]
struct Light {
    points: Vec<[f64; 2]>,
    /// Spacing of the grid that found them.
    cell: [f64; 2],
    frame: Frame,
}

struct Finder {
    surfaces: Vec<Surface<f32>>,
    batch: Box<LensBatch<f32>>,
    distance: f64,
}

impl Finder {
    /// The light of a film point, searched first around where it is expected and then over the
    /// whole rear element.
    fn find(&mut self, r: f64, expected: Option<Frame>, whole: Frame) -> Light {
        let around = |frame: Frame| {
            [1.0, 5.0, 12.0].map(|by| frame.grown([by * frame.width(), by * frame.height]))
        };
        let mut frame = whole;
        for start in expected.map(around).into_iter().flatten().chain([whole]) {
            frame = start;
            // Zoom in until the light fills a good part of the frame: a small stop is a
            // needle in the haystack of the first grid.
            for _ in 0..16 {
                let light = self.grid(r, frame, [33, 16]);
                if light.points.is_empty() {
                    break;
                }
                let tight = light.frame.grown(light.cell);
                if tight.width() > 0.6 * frame.width() && tight.height > 0.6 * frame.height {
                    return self.grid(r, tight, GRID);
                }
                frame = tight;
            }
        }
        Light { points: Vec::new(), cell: [0.0; 2], frame }
    }

    /// Traces a grid of rays from the film point at radius r.
    fn grid(&mut self, r: f64, frame: Frame, [columns, rows]: [usize; 2]) -> Light {
        let cell = [frame.width() / (columns - 1) as f64, frame.height / (rows - 1) as f64];
        let place =
            |i: usize| [frame.low + cell[0] * (i % columns) as f64, cell[1] * (i / columns) as f64];
        let mut points = Vec::new();
        let mut ignored = vec![0; self.surfaces.len()];
        let total = columns * rows;
        for start in (0..total).step_by(WAVE) {
            let batch = &mut *self.batch;
            let count = WAVE.min(total - start);
            for i in 0..count {
                let [u, v] = place(start + i);
                let length = (u - r).hypot(v).hypot(self.distance);
                (batch.x[i], batch.y[i], batch.z[i]) = (r as f32, 0.0, 0.0);
                batch.tx[i] = ((u - r) / length) as f32;
                batch.ty[i] = (v / length) as f32;
                batch.tz[i] = (self.distance / length) as f32;
            }
            batch.resize::<f32x8>(count);
            trace::<f32x8>(batch, &self.surfaces, &mut ignored);
            points.extend((0..count).filter(|&i| !batch.x[i].is_nan()).map(|i| place(start + i)));
        }
        let frame = Frame::around(&points);
        Light { points: row_ends(points), cell, frame }
    }
}

/// The first and the last point of every row: their hull is that of all.
fn row_ends(points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    points
        .chunk_by(|one, next| one[1] == next[1])
        .flat_map(|row| row.first().into_iter().chain(row.last()))
        .copied()
        .collect()
}

/// The rear element seen from a film point at radius r and projected on its vertex plane.
fn rear_outline(lens: &Prescription, distance: f64, r: f64) -> Vec<[f64; 2]> {
    let rear = lens.rear();
    let mut points = Vec::new();
    for ring in 0..=8 {
        let h = rear.diameter / 2.0 * f64::from(ring) / 8.0;
        // The sag counts towards the film; the film is `distance` behind the vertex.
        let scale = distance / (distance - rear.sag(h));
        for step in 0..=32 {
            let (sin, cos) = (std::f64::consts::PI * f64::from(step) / 32.0).sin_cos();
            points.push([r + (h * cos - r) * scale, h * sin * scale]);
        }
    }
    points
}

/// A small ellipse, its axes along u and v and its centre on u, around points and grown by
/// a margin.
fn bounding_ellipse(points: &[[f64; 2]], margin: [f64; 2]) -> Ellipse {
    if points.is_empty() {
        return Ellipse::default();
    }
    let frame = Frame::around(points);
    let centre = (frame.low + frame.high) / 2.0;
    let half_width = (frame.width() / 2.0).max(1e-12);
    let half_height = |a: f64| {
        points.iter().fold(0.0, |b: f64, &[u, v]| {
            let x = (u - centre) / a;
            if v == 0.0 { b } else { b.max(v / (1.0 - x * x).max(0.0).sqrt()) }
        })
    };
    let candidates = (0..=30).map(|step| half_width * (1.0 + 0.02 * f64::from(step)));
    let [a, b] = candidates.map(|a| [a, half_height(a)]).fold([f64::INFINITY; 2], |best, new| {
        if new[0] * new[1] < best[0] * best[1] { new } else { best }
    });
    // Rounding to f32 must not cut anything off, nor leave a zero width.
    let grow = |half: f64, margin: f64| ((half + margin) * 1.000_001).max(1e-9) as f32;
    Ellipse { centre: centre as f32, half: [grow(a, margin[0]), grow(b, margin[1])] }
}
