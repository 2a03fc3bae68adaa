//! Where to aim: the part of the rear element through which a film point sees the scene.
//!
//! Points of the pupil live in the plane of the rear vertex. For some film points the outline of
//! the light is found by tracing and held by a [`Fan`]; between them fans are mixed, corner by
//! corner, because the pupil moves and closes evenly across the film. For a round lens behind which
//! the film stands level the points are a line of radii, and the pupil is in the frame of its film
//! point: u away from the axis through the film point, v across. For any other lens or film they
//! are a grid over the film, and u and v are the x and y of the lens.
//!
//! The sampler mixes in a small share of points of the whole rear element, with the mixture's
//! density, so that light which a fan should miss is still counted and the picture stays
//! unbiased.

use super::cells::Cells;
use super::fan::{Fan, TRIANGLES, Triangle};
use super::polar::Polar;
use super::pose::FilmPlane;
use super::prescription::{Prescription, Row};
use super::survey::Survey;
use super::target::{Steps, Target, Targets, lone};
use crate::rays::{Column, WAVE};

/// Rings of the film of a round lens; their edges have a fan each.
pub(super) const RINGS: usize = 64;
/// Cells along each side of any other film; their corners have a fan each.
pub(super) const CELLS: usize = 24;
/// Share of the samples that go to the whole rear element.
pub const REAR_SHARE: f32 = 1.0 / 256.0;

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
    /// Its centre.
    pub centre: [f32; 2],
    /// Half its width along u and along v.
    pub half: [f32; 2],
}

impl Ellipse {
    /// Its area, mm^2.
    pub fn area(&self) -> f32 {
        std::f32::consts::PI * self.half[0] * self.half[1]
    }

    pub(super) fn scaled(self, by: f32) -> Self {
        Self { half: self.half.map(|half| half * by), ..self }
    }
}

/// The bounds of a lens's exit pupil for every film point.
#[derive(Clone, Debug)]
pub struct PupilBound {
    field: Field,
    /// What could hit the rear element: from each of RINGS rings of equal width, or from each cell
    /// of a grid.
    rear: Vec<Ellipse>,
    /// By each of those, the density of the samples that go there, mm^-2.
    rear_density: Vec<f32>,
    cells: Cells,
    rings_per_mm: f32,
    /// Share of samples that go to the rear element instead of the pupil.
    pub rear_share: f32,
    /// Whether light beyond the fans counts for nothing, because what traces it knows of no rims.
    pub(super) strict: bool,
}

/// Fans over the film.
#[derive(Clone, Debug)]
pub(super) enum Field {
    /// No fans: all samples go to the rear element.
    Bare,
    /// By film radius, in the frame of the film point. Behind the edges of all rings stand two
    /// empty ones for the dark beyond. `open` has a bit for every fan that has an area.
    Round { fans: Box<[Fan; RINGS + 3]>, steps: Steps, open: u128, per_end: f32 },
    /// By spokes and rings about the axis, and how far the light reaches on each.
    Polar(Polar),
    /// Row by row over the cells of the film.
    Grid { fans: Vec<Fan> },
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

/// Columns for what is computed eight samples at a time before the fans are looked up.
#[derive(Clone, Debug, Default)]
pub(super) struct Lookup {
    /// Which of the [`Steps`] applies, and how much of it.
    step: Column<u32>,
    step_share: Column<f32>,
    rear: Column<u32>,
    /// How far along the far side of its triangle a sample is.
    pub(super) along: Column<f32>,
}

impl PupilBound {
    /// Finds the bounds for a film at `distance` mm behind the rear vertex that reaches to
    /// `radius` mm from the axis. Takes some milliseconds.
    pub fn new(lens: &Prescription, distance: f64, radius: f64, aim: Aim) -> Self {
        Self::posed(lens, &FilmPlane::square(distance, radius), aim)
    }

    /// The same for a film that may not stand square. Takes a tenth of a second where it is tilted
    /// or the lens is not round.
    pub fn posed(lens: &Prescription, film: &FilmPlane, aim: Aim) -> Self {
        Self::coloured(lens, &[], film, aim)
    }

    /// The same, for all that a lens lets through in its own colour and as it is in others.
    pub(super) fn coloured(
        lens: &Prescription,
        others: &[Prescription],
        film: &FilmPlane,
        aim: Aim,
    ) -> Self {
        let &FilmPlane { distance, pose, radius, half } = film;
        let survey = Survey { lens, others, distance, pose };
        // Rings are about the axis.
        let [x, y] = pose.decentre;
        let radius = radius + x.hypot(y);
        let level = lens.is_round() && pose.is_level();
        let (rear, field, rear_share) = match aim {
            Aim::RearDisk => {
                let half = lens.rear().diameter as f32 / 2.0;
                let disk = Ellipse { centre: [0.0; 2], half: [half; 2] };
                (vec![disk; RINGS], Field::Bare, 1.0)
            }
            Aim::Pupil if level => {
                let edge = |i: usize| radius * i as f64 / RINGS as f64;
                let ring = |i: usize| survey.rear_ellipse([edge(i), edge(i + 1)]);
                ((0..RINGS).map(ring).collect(), survey.rings(radius), REAR_SHARE)
            }
            Aim::Pupil => {
                let nearly_round = lens.rows.iter().all(Row::is_round);
                let polar = if nearly_round { survey.spokes(half) } else { None };
                let field = polar.unwrap_or_else(|| survey.grid(half));
                (survey.rear_cells(half), field, REAR_SHARE)
            }
        };
        let rings_per_mm = (RINGS as f64 / radius) as f32;
        let rear_density = rear.iter().map(|ellipse| rear_share / ellipse.area()).collect();
        let cells = Cells::over(half);
        Self { field, rear, rear_density, cells, rings_per_mm, rear_share, strict: false }
    }

    /// Whether pupil points are in the frame of the lens, and film points are looked up by where
    /// they stand on the film itself.
    pub(in crate::lens) fn is_askew(&self) -> bool {
        matches!(self.field, Field::Grid { .. } | Field::Polar(_))
    }

    /// What could hit the rear element from a film point, mm.
    pub fn rear(&self, film: [f32; 2]) -> Ellipse {
        if self.is_askew() {
            let [(i, _), (j, _)] = self.cells.cell(film);
            return self.rear[j * CELLS + i];
        }
        self.rear[self.rear_ring(film[0].hypot(film[1])) as usize]
    }

    #[inline(always)]
    fn rear_ring(&self, radius: f32) -> u32 {
        whole(radius * self.rings_per_mm).min(RINGS as u32 - 1)
    }

    /// Density of the samples of a triangle times twice its area.
    pub(super) fn triangle_density(&self) -> f32 {
        2.0 * (1.0 - self.rear_share) / TRIANGLES as f32
    }

    /// The light of a film point, mm, as far as tracing found it; an empty fan where all samples
    /// go to the rear element.
    pub fn fan(&self, film: [f32; 2]) -> Fan {
        match &self.field {
            Field::Bare => Fan::EMPTY,
            Field::Round { fans, per_end, .. } => {
                let place = place(film[0].hypot(film[1]) * per_end);
                let ring = ring(place);
                let t = place - ring as i32 as f32;
                let near = ring as usize;
                Fan::mix(&[(&fans[near], 1.0 - t), (&fans[near + 1], t)])
            }
            Field::Polar(polar) => polar.fan(film),
            Field::Grid { fans } => {
                let around = self.cells.corners(film);
                Fan::mix(&around.map(|(corner, weight)| (&fans[corner], weight)))
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
        targets: &mut Targets,
    ) {
        match &self.field {
            Field::Bare => self.bare_targets(film, pupil, targets),
            Field::Round { steps, per_end, .. } => {
                self.round_targets((steps, *per_end), film, pupil, lookup, targets);
            }
            Field::Polar(_) | Field::Grid { .. } => {
                self.askew_targets(film, pupil, lookup, targets);
            }
        }
    }

    #[inline(always)]
    fn round_targets(
        &self,
        (Steps(steps), per_end): (&Steps, f32),
        film: [&[f32]; 2],
        pupil: [&[f32]; 2],
        lookup: &mut Lookup,
        targets: &mut Targets,
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
            lookup.step_share[i] = place - ring as i32 as f32;
            lookup.rear[i] = self.rear_ring(radius);
            let place = (u[i] - share).max(0.0) * per_triangle;
            let triangle = whole(place).min(TRIANGLES as u32 - 1);
            lookup.step[i] = ring * TRIANGLES as u32 + triangle;
            lookup.along[i] = place - triangle as i32 as f32;
        }
        // Whole rows first, which are eight lanes.
        for i in 0..count {
            let [near, step] = &steps[lookup.step[i] as usize];
            let s = lookup.step_share[i];
            for k in 0..8 {
                targets[i][k] = near[k] + s * step[k];
            }
        }
        let density = &self.rear_density[..RINGS];
        for i in 0..count {
            targets[i][6] = density[lookup.rear[i] as usize % RINGS];
            if u[i] < share {
                targets[i] = self.rear_target([x[i], y[i]], [u[i] / share, v[i]]);
            }
        }
    }

    #[inline(never)]
    fn askew_targets(
        &self,
        film: [&[f32]; 2],
        pupil: [&[f32]; 2],
        lookup: &mut Lookup,
        targets: &mut Targets,
    ) {
        let share = self.rear_share;
        for i in 0..film[0].len() {
            let (point, u, v) = ([film[0][i], film[1][i]], pupil[0][i], pupil[1][i]);
            if u < share {
                targets[i] = self.rear_target(point, [u / share, v]);
                continue;
            }
            let place = (u - share) * (TRIANGLES as f32 / (1.0 - share));
            let k = (place as usize).min(TRIANGLES - 1);
            lookup.along[i] = place - k as f32;
            let mut target = match &self.field {
                Field::Polar(polar) => polar.target(point, k),
                _ => self.grid_target(point, k),
            };
            let [(column, _), (row, _)] = self.cells.cell(point);
            target[6] = self.rear_density[row * CELLS + column];
            targets[i] = target;
        }
    }

    /// One triangle of [`PupilBound::fan`] over a grid, as a target without the density.
    fn grid_target(&self, film: [f32; 2], k: usize) -> Target {
        let mut target = [0.0; 8];
        let Field::Grid { fans } = &self.field else { return target };
        for (corner, weight) in self.cells.corners(film) {
            let Triangle { centre, corners: [a, b] } = fans[corner].triangle(k);
            let row = [centre[0], centre[1], a[0], a[1], b[0] - a[0], b[1] - a[1]];
            for (sum, value) in target.iter_mut().zip(row) {
                *sum += weight * value;
            }
        }
        target
    }

    #[inline(never)]
    fn bare_targets(&self, film: [&[f32]; 2], pupil: [&[f32]; 2], targets: &mut Targets) {
        for i in 0..film[0].len() {
            targets[i] = self.rear_target([film[0][i], film[1][i]], [pupil[0][i], pupil[1][i]]);
        }
    }

    /// A sample of the whole rear element: [`REAR_SHARE`] of all, where there are fans.
    #[inline(never)]
    fn rear_target(&self, film: [f32; 2], [u, v]: [f32; 2]) -> Target {
        let rear = self.rear(film);
        let [disk_u, disk_v] = crate::sampler::disk(u, v);
        let point =
            [rear.half[0] * disk_u + rear.centre[0], rear.half[1] * disk_v + rear.centre[1]];
        let fan = self.fan(film);
        let bare = matches!(self.field, Field::Bare);
        let density = fan.density(point);
        let base = match bare || if self.strict { density > 0.0 } else { fan.open() } {
            true => (1.0 - self.rear_share) * density + self.rear_share / rear.area(),
            false => 0.0,
        };
        lone(point, base)
    }

    /// Whether light comes to any film point of a rectangle, mm.
    pub fn any_open(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        match &self.field {
            Field::Bare => true,
            Field::Round { open, per_end, .. } => {
                let near = |i: usize| low[i].max(-high[i]).max(0.0) as f32;
                let far = |i: usize| high[i].max(-low[i]) as f32;
                let at = |a: f32, b: f32| ring(place((a * a + b * b).sqrt() * per_end));
                let inner = at(near(0), near(1));
                // Mostly light comes to its nearest point.
                let lit = open >> inner;
                lit & 1 != 0 || {
                    let outer = at(far(0), far(1)) + 1;
                    lit & ((2 << (outer - inner)) - 1) != 0
                }
            }
            Field::Polar(polar) => polar.any_open(low, high),
            Field::Grid { fans } => {
                let Cells { per_mm, half } = self.cells;
                let cell = |v: f64, i: usize, up: f64| {
                    let place = (v + f64::from(half[i])) * f64::from(per_mm[i]) + up;
                    place.clamp(0.0, CELLS as f64) as usize
                };
                let range = |i: usize| cell(low[i], i, 0.0)..=cell(high[i], i, 1.0);
                range(1).any(|j| range(0).any(|i| fans[j * (CELLS + 1) + i].open()))
            }
        }
    }
}
