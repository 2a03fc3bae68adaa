//! Builder of the pupil table: traces the pupil of a lens over the whole film.

use glam::{DAffine3, DMat2, DVec2, DVec3};
use rayon::prelude::*;

use super::enclosure::{Between, enclose_light};
use super::fan::Fan;
use super::outline::{OutlineFinder, PupilOutline, PupilSymmetry};
use super::polar_grid::{POLAR_RINGS, PolarGrid, SPOKES, direction, ring_fraction};
use super::target::TriangleSteps;
use super::tracker::PupilTracker;
use super::{CELLS, Ellipse, FanTable, RINGS};
use crate::prescription::Prescription;
use crate::prescription::pose::Pose;

/// Enlargement of the ellipses around the rear element, so that they enclose all of it.
const REAR_MARGIN: f32 = 1.002;
/// Enlargement of fans beyond the light that was found.
const FAN_MARGIN: f64 = 1.002;
/// Largest enlargement of a fan for the light between it and the next. Light beyond, at the very
/// rim of the image circle, is left to the samples outside the fan.
const MAX_WIDENING: f64 = 1.5;

/// Subdivisions of a ring at which the light of a round lens is traced.
const SUBSTEPS: usize = 4;

/// Rings that are traced for the middle of the film: the next one, and the one by which that is
/// widened.
const AXIS_RINGS: usize = 2;

/// Subdivisions of a side of a cell at whose ends light is sought outside the fan.
const CELL_STEPS: usize = 2;

/// Builds the pupil table of a lens.
pub(crate) struct TableBuilder<'a> {
    pub lens: &'a Prescription,
    /// The same lens at other wavelengths; fans enclose their light too.
    pub others: &'a [Prescription],
    pub distance: f64,
    /// Tilt and decentre of the film.
    pub pose: Pose,
}

/// A film point in the frame of the lens [mm]: x, y, and z towards the scene, from the intersection
/// of the axis with the plane of the untilted film.
pub(crate) type FilmPosition = [f64; 3];

impl TableBuilder<'_> {
    fn finder(&self, symmetry: PupilSymmetry) -> OutlineFinder {
        let all = std::iter::once(self.lens).chain(self.others);
        OutlineFinder::new(all, self.distance, symmetry)
    }

    /// Builds fans along a radius of the film, up to where the light ends.
    pub fn build_rings(&self, radius: f64) -> FanTable {
        let mut finder = self.finder(PupilSymmetry::Mirrored);
        let mut tracker = PupilTracker::new(self, &mut finder);
        let end = tracker.light_radius(radius);
        Self::trace_rings(&mut tracker, end, RINGS)
    }

    /// Builds the fan of the middle of the film as [`Self::build_rings`] does, if the light reaches
    /// `radius`; that of the next ring, which the first one is mixed with, stands for all others.
    pub fn build_axis(&self, radius: f64) -> FanTable {
        let mut finder = self.finder(PupilSymmetry::Mirrored);
        Self::trace_rings(&mut PupilTracker::new(self, &mut finder), radius, AXIS_RINGS)
    }

    /// Builds the fans of the first rings, of those that end where the light does.
    fn trace_rings(tracker: &mut PupilTracker, end: f64, rings: usize) -> FanTable {
        let mut fans = Box::new([Fan::EMPTY; RINGS + 3]);
        let mut between = Vec::with_capacity(RINGS * (SUBSTEPS - 1));
        let mut last = None;
        for i in 0..=SUBSTEPS * rings {
            // The inverse of `ring_position`.
            let rest = 1.0 - i as f64 / (SUBSTEPS * RINGS) as f64;
            let r = end * (1.0 - rest * rest);
            let light = tracker.outline_at_radius(r, last);
            if let Some(light) = &light {
                last = Some((r, light.bounds));
            }
            let (ring, part) = (i / SUBSTEPS, i % SUBSTEPS);
            if part == 0 {
                fans[ring] = fan(light.as_ref());
            } else if let Some(light) = light {
                let share = part as f32 / SUBSTEPS as f32;
                between.push(Midpoint { around: [(ring, 1.0 - share), (ring + 1, share)], light });
            }
        }
        fans[rings] = at_the_end(&fans[rings], &fans[rings - 1]);
        widen_fans(&mut fans[..=rings], &between);
        let last = fans[rings];
        fans[rings..=RINGS].fill(last);
        let open = fans.iter().rev().fold(0, |bits, fan| bits << 1 | u128::from(fan.is_open()));
        let steps = TriangleSteps::of(&fans[..]);
        // The last film point, if lit, must not count as beyond the light.
        FanTable::Round { fans, steps, open, per_end: ((1.0 - 1e-6) / end) as f32 }
    }

    /// Builds fans over a film of this half width and height, mm.
    pub fn build_grid(&self, half: [f64; 2]) -> FanTable {
        let finder = self.finder(PupilSymmetry::None);
        let place = |at: [f64; 2]| self.cell(half, at);
        let corner = |i: usize, j: usize| place([i, j].map(|i| i as f64));
        let side = CELLS + 1;
        let mut lights: Vec<Option<PupilOutline>> = vec![None; side * side];
        // Corners of a diagonal do not need each other.
        for diagonal in 0..2 * side - 1 {
            let columns = diagonal.saturating_sub(CELLS)..diagonal.min(CELLS) + 1;
            let outline = |finder: &mut OutlineFinder, i: usize| {
                let j = diagonal - i;
                // The neighbours to the left and below, which are known.
                let beside = (i > 0).then(|| (j * side + i - 1, corner(i - 1, j)));
                let under = (j > 0).then(|| ((j - 1) * side + i, corner(i, j - 1)));
                let known = [beside, under]
                    .into_iter()
                    .flatten()
                    .find_map(|(k, at)| Some((at, lights[k].as_ref()?.bounds)));
                PupilTracker::new(self, finder).outline(corner(i, j), known)
            };
            let corners = columns.clone().into_par_iter().with_min_len(4);
            let found = corners.map_init(|| finder.clone(), outline);
            let found: Vec<_> = found.collect();
            for (i, light) in columns.zip(found) {
                lights[(diagonal - i) * side + i] = light;
            }
        }
        let mut fans: Vec<Fan> =
            lights.iter().map(|light| fan(light.as_ref()).scaled(FAN_MARGIN as f32)).collect();
        extrapolate_centres(&mut fans);
        let column = || steps(CELLS, CELL_STEPS);
        let between = column().flat_map(|row| column().map(move |column| (column, row)));
        let between = between.map(|((i, s), (j, t))| Between {
            film: place([i as f64 + s, j as f64 + t]),
            turn: [1.0, 0.0],
            around: bilinear(|a, b| (j + b) * side + i + a, s, t),
        });
        enclose_light(&mut fans, between.collect(), &finder);
        FanTable::Grid { fans }
    }

    /// Returns a corner of a grid over a film of this half width and height, or a point between
    /// corners.
    fn cell(&self, half: [f64; 2], at: [f64; 2]) -> FilmPosition {
        self.pose.film_point([0, 1].map(|i| half[i] * (2.0 * at[i] / CELLS as f64 - 1.0)))
    }

    /// Returns for each cell of a grid over the film an ellipse around the rear element as seen
    /// from it.
    pub fn rear_cells(&self, half: [f64; 2]) -> Vec<Ellipse> {
        // Projections from the corners of a cell enclose the projection from any point between
        // them.
        let cell = |k: usize| {
            let corner = |i: usize, j: usize| {
                self.rear_outline(self.cell(half, [k % CELLS + i, k / CELLS + j].map(|i| i as f64)))
            };
            let seen = [corner(0, 0), corner(1, 0), corner(0, 1), corner(1, 1)];
            Ellipse::proportional(&seen.concat()).scaled(REAR_MARGIN)
        };
        (0..CELLS * CELLS).into_par_iter().map(cell).collect()
    }

    /// Builds fans by spokes and rings about the point where the axis meets the film; `None` if
    /// that point is dark.
    pub fn build_spokes(&self, half: [f64; 2]) -> Option<FanTable> {
        let mut finder = self.finder(PupilSymmetry::None);
        let mut tracker = PupilTracker::new(self, &mut finder);
        let turn = self.pose.transform().matrix3;
        let level = DMat2::from_cols(turn.x_axis.truncate(), turn.y_axis.truncate());
        let pole = level.inverse() * -DVec2::from(self.pose.decentre);
        let corners = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
        let reach = corners.map(|[x, y]| pole.distance(DVec2::new(x * half[0], y * half[1])));
        let reach = reach.into_iter().fold(0.0, f64::max);
        let place = |spoke: f64, r: f64| {
            let [x, y] = direction(spoke);
            self.pose.film_point([pole.x + r * x, pole.y + r * y])
        };
        let middle = tracker.bounding_box(place(0.0, 0.0), None)?;
        let mut ends = [0.0; SPOKES];
        let mut fans = Vec::with_capacity(SPOKES * (POLAR_RINGS + 1));
        let mut frames = Vec::with_capacity(SPOKES * (POLAR_RINGS + 1));
        for (spoke, end) in ends.iter_mut().enumerate() {
            let along = |r: f64| place(spoke as f64, r);
            tracker.finder.turn = direction(spoke as f64);
            *end = tracker.light_end_along(along, reach, middle);
            let mut last = (along(0.0), middle);
            for ring in 0..=POLAR_RINGS {
                let at = along(*end * ring_fraction(ring as f64));
                let light = tracker.outline(at, Some(last));
                if let Some(light) = &light {
                    last = (at, light.bounds);
                }
                fans.push(fan(light.as_ref()));
                frames.push(last);
            }
        }
        for spoke in 0..SPOKES {
            let [before, end] =
                [POLAR_RINGS - 1, POLAR_RINGS].map(|ring| PolarGrid::index(spoke, ring));
            fans[end] = at_the_end(&fans[end], &fans[before]);
        }
        let mut between = Vec::with_capacity(SPOKES * POLAR_RINGS);
        for spoke in 0..SPOKES {
            tracker.finder.turn = direction(spoke as f64 + 0.5);
            let per_end = (1.0 / ends[spoke] + 1.0 / ends[(spoke + 1) % SPOKES]) / 2.0;
            for ring in 0..POLAR_RINGS {
                let at = place(spoke as f64 + 0.5, ring_fraction(ring as f64 + 0.5) / per_end);
                let known = frames[PolarGrid::index(spoke, ring)];
                let around = [(0, 0), (1, 0), (0, 1), (1, 1)];
                let corners = around.map(|(i, j)| PolarGrid::index(spoke + i, ring + j));
                between.push((corners, tracker.outline(at, Some(known))));
            }
        }
        widen_fans(&mut fans, &cell_midpoints(between));
        // The last film point, if lit, must not count as beyond the light.
        let ends = ends.map(|end| end * (1.0 + 1e-6));
        Some(FanTable::Polar(PolarGrid::new(pole.to_array(), &ends, fans)))
    }

    /// Returns points of the rear element, projected from a film point on the plane of the vertex
    /// of the untilted element.
    pub fn rear_outline(&self, [x, y, z]: FilmPosition) -> Vec<[f64; 2]> {
        let rear = self.lens.rear();
        let placed = self.rear_placement();
        let ahead = self.distance - z;
        let travel = self.lens.travel_before(self.lens.rows.len());
        let mut points = Vec::new();
        let project = |rim: [f64; 3]| {
            let rim = placed.transform_point3(DVec3::from_array(rim));
            // The way of the light leads towards the film, which lies behind all of it.
            let scale = ahead / (ahead - travel * rim.z).max(1e-3 * ahead);
            [x + (rim.x - x) * scale, y + (rim.y - y) * scale]
        };
        if let Some([centre, half]) = rear.opening_ellipse() {
            for i in 0..9 * 64 {
                let (sin, cos) = (std::f64::consts::PI * f64::from(i % 64) / 32.0).sin_cos();
                let share = f64::from(i / 64) / 8.0;
                let u = centre[0] + share * half[0] * cos;
                let v = centre[1] + share * half[1] * sin;
                points.push(project([u, v, rear.sag_at(u, v)]));
            }
            return points;
        }
        for ring in 0..=8 {
            let h = rear.diameter / 2.0 * f64::from(ring) / 8.0;
            // The sag of a cylinder or a biconic differs along x and y.
            let sags: &[f64] = match rear.is_anamorphic() {
                true => &[rear.sag_at(h, 0.0), rear.sag_at(0.0, h)],
                false => &[rear.sag(h)],
            };
            for sag in sags {
                for step in 0..64 {
                    let (sin, cos) = (std::f64::consts::PI * f64::from(step) / 32.0).sin_cos();
                    points.push(project([h * cos, h * sin, *sag]));
                }
            }
        }
        points
    }

    /// Returns the transform from the frame of the rear surface to that of the vertex of the lens
    /// without tilt and decentre.
    fn rear_placement(&self) -> DAffine3 {
        if !self.lens.is_misaligned() {
            return DAffine3::IDENTITY;
        }
        let placed = self.lens.surface_transforms()[self.lens.rows.len() - 1];
        self.lens.film_axis().inverse() * placed
    }

    /// Returns an ellipse around the rear element as seen from film radii between two.
    pub fn rear_ellipse(&self, radii: [f64; 2]) -> Ellipse {
        let [inner, outer] = radii.map(|r| self.rear_outline([r, 0.0, 0.0]));
        Ellipse::symmetric(&[inner, outer].concat()).scaled(REAR_MARGIN)
    }
}

/// Returns a fan around the light, empty if there is none.
fn fan(light: Option<&PupilOutline>) -> Fan {
    light.map_or(Fan::EMPTY, |light| Fan::around(light.centre, &light.outline))
}

/// Light that was traced between fans.
struct Midpoint<const N: usize> {
    /// The fans around it, and their interpolation weights.
    around: [(usize, f32); N],
    light: PupilOutline,
}

/// Returns the light in the middle of four fans, if there is any.
fn cell_midpoints(cells: Vec<([usize; 4], Option<PupilOutline>)>) -> Vec<Midpoint<4>> {
    let one = |(corners, light): ([usize; 4], Option<PupilOutline>)| {
        Some(Midpoint { around: corners.map(|k| (k, 0.25)), light: light? })
    };
    cells.into_iter().filter_map(one).collect()
}

/// Widens fans until their interpolations enclose the light between them.
fn widen_fans<const N: usize>(fans: &mut [Fan], between: &[Midpoint<N>]) {
    let mut by = vec![FAN_MARGIN; fans.len()];
    for Midpoint { around, light } in between {
        let mixed = Fan::mix(&around.map(|(k, share)| (&fans[k], share)));
        let reach = light.outline.iter().fold(0.0f64, |reach, point| {
            reach.max(mixed.scale_to_enclose([0, 1].map(|axis| light.centre[axis] + point[axis])))
        });
        for (k, _) in around {
            by[*k] = by[*k].max((reach * FAN_MARGIN).min(MAX_WIDENING));
        }
    }
    for (fan, by) in fans.iter_mut().zip(by) {
        *fan = fan.scaled(by as f32);
    }
}

/// Returns the fan of the last ring: if no light was found there, the one before. The light ends
/// somewhere near that ring, and fans between must not shrink towards nowhere.
fn at_the_end(end: &Fan, before: &Fan) -> Fan {
    if end.is_open() { *end } else { *before }
}

/// Returns positions along a line of cells, from its start to its end: a cell, and the position in
/// it, 0 to 1.
fn steps(cells: usize, per_cell: usize) -> impl Iterator<Item = (usize, f64)> {
    (0..=cells * per_cell).map(move |step| {
        let cell = (step / per_cell).min(cells - 1);
        (cell, (step - cell * per_cell) as f64 / per_cell as f64)
    })
}

/// Returns the four corners of a cell with their weights at a position in it.
fn bilinear(corner: impl Fn(usize, usize) -> usize, s: f64, t: f64) -> [(usize, f32); 4] {
    [(0, 0), (1, 0), (0, 1), (1, 1)].map(|(a, b)| {
        let [x, y] = [(a, s), (b, t)].map(|(far, s)| if far == 1 { s } else { 1.0 - s });
        (corner(a, b), (x * y) as f32)
    })
}

/// Gives the dark corners of a grid the fan of a lit neighbour, for the light in the cells between
/// them. The centre is where a line through the two nearest lit corners leads.
fn extrapolate_centres(fans: &mut [Fan]) {
    const SIDE: isize = CELLS as isize + 1;
    const NEIGHBOURS: [[isize; 2]; 8] =
        [[1, 0], [-1, 0], [0, 1], [0, -1], [1, 1], [-1, 1], [1, -1], [-1, -1]];
    let known = fans.to_vec();
    let lit = |i: isize, j: isize| {
        let inside = (0..SIDE).contains(&i) && (0..SIDE).contains(&j);
        inside.then(|| &known[(j * SIDE + i) as usize]).filter(|fan| fan.is_open())
    };
    for j in 0..SIDE {
        for i in 0..SIDE {
            let at = |[x, y]: [isize; 2], far: isize| lit(i + far * x, j + far * y);
            let fan = &mut fans[(j * SIDE + i) as usize];
            if fan.is_open() {
                continue;
            }
            let on_a_line = |by| Some((at(by, 1)?, at(by, 2)?));
            if let Some((near, far)) = NEIGHBOURS.into_iter().find_map(on_a_line) {
                let centre = [0, 1].map(|axis| 2.0 * near.centre[axis] - far.centre[axis]);
                *fan = Fan { centre, ..*near };
            } else if let Some(near) = NEIGHBOURS.into_iter().find_map(|by| at(by, 1)) {
                *fan = *near;
            }
        }
    }
}
