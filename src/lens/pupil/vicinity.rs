//! Vicinity of a fan: an ellipse about its centre that encloses it with a margin.
//!
//! The size of the ellipse is constant in each cell of the fan table, and encloses the fans at the
//! corners of the cell. The centre moves with that of the fan. Fans are interpolated corner by
//! corner, so the ellipse encloses every fan of the cell.
//!
//! Behind a stop with blades or a mask the vicinity is that of the same lens with a round stop,
//! which includes all light of the stop itself: pupils of blades change too abruptly across the film
//! for a coarse grid of fans, and pupils of circles do not.
//!
//! # Limit of the weight
//!
//! The weight of a sample is cos^4 / (Z^2 p) for untilted film (Kolb, Mitchell & Hanrahan 1995). Z
//! is the distance from the film to the rear vertex, and p the density of the mixture. In an
//! ellipse of area E the density is at least q / E, with q =
//! [`VICINITY_SHARE`](super::VICINITY_SHARE). No sample there weighs more than E / (q Z^2), whatever
//! fan and rim miss. [`PupilBounds::largest_area`] returns the largest E / q.
//!
//! The usual weight is that of a fan of area F in the middle of the film, F / Z^2. The ratio of both
//! is E / (q F): 512 times the ratio of two areas. E exceeds the area of a round fan by the square of
//! the margin, at most 2.25.

use super::bounds::{FanTable, PupilBounds, ring, ring_position};
use super::fan::Fan;
use super::polar_grid::{POLAR_RINGS, SPOKES};
use super::{CELLS, Ellipse};
use petzval_base::sampler::concentric_disk;

/// Least and largest enlargement of the fans. More than the least only reaches as far from the axis
/// as the rear element.
const MARGINS: [f32; 2] = [1.1, 1.5];

/// Ellipse around the light of a film point. It is axis-parallel in a frame whose u axis has the
/// direction `turn` in the frame of the points.
#[derive(Clone, Copy, Debug)]
pub struct Vicinity {
    centre: [f32; 2],
    /// Semi-axes, 0 if nothing is drawn.
    half: [f32; 2],
    turn: [f32; 2],
}

impl Vicinity {
    /// The vicinity of a dark film point.
    const DARK: Self = Self { centre: [0.0; 2], half: [0.0; 2], turn: [1.0, 0.0] };

    fn own(&self) -> Ellipse {
        Ellipse { centre: [0.0; 2], half: self.half }
    }

    /// Returns the density of points that are drawn uniformly from it, mm^-2; 0 outside.
    pub fn density(&self, point: [f32; 2]) -> f32 {
        if self.half[0] <= 0.0 {
            return 0.0;
        }
        let ([u, v], [cos, sin]) = ([0, 1].map(|i| point[i] - self.centre[i]), self.turn);
        self.own().density([cos * u + sin * v, cos * v - sin * u])
    }

    /// Returns the point of two random numbers; `None` if nothing is drawn.
    pub(super) fn point(&self, [u, v]: [f32; 2]) -> Option<[f32; 2]> {
        if self.half[0] <= 0.0 {
            return None;
        }
        let ([u, v], [cos, sin]) = (self.own().at(concentric_disk(u, v)), self.turn);
        Some([self.centre[0] + cos * u - sin * v, self.centre[1] + sin * u + cos * v])
    }

    /// Returns it in a frame turned back by an angle.
    fn turned(self, [cos, sin]: [f32; 2]) -> Self {
        let turned = |[u, v]: [f32; 2]| [cos * u - sin * v, sin * u + cos * v];
        Self { centre: turned(self.centre), turn: turned(self.turn), ..self }
    }
}

/// Sizes of the vicinities of a fan table.
#[derive(Clone, Debug, Default)]
pub(super) struct Vicinities {
    /// Semi-axes by cell of the table, mm.
    halves: Vec<[f32; 2]>,
    /// Bounds of the same lens with a round stop, whose vicinities are used instead, and the place
    /// of the film's centre among its film points (mm).
    round: Option<(Box<PupilBounds>, [f32; 2])>,
}

/// Returns the semi-axes of an ellipse about the common centre of fans that encloses them with a
/// margin. `rear` is the radius of the rear element, mm.
fn enclosing<'a>(fans: impl Iterator<Item = &'a Fan> + Clone, rear: f32) -> [f32; 2] {
    let away = fans.clone().map(|fan| fan.centre[0].hypot(fan.centre[1])).fold(0.0, f32::max);
    let corners = fans.flat_map(|fan| fan.corners);
    let half = corners
        .clone()
        .fold([0.0f32; 2], |half, corner| [0, 1].map(|i| half[i].max(corner[i].abs())));
    let level = |[u, v]: [f32; 2]| (u / half[0]).powi(2) + (v / half[1]).powi(2);
    if half[0].min(half[1]) <= 0.0 {
        return [0.0; 2];
    }
    let tight = half.map(|v| v * corners.clone().map(level).fold(0.0, f32::max).sqrt());
    let margin = (rear - away) / tight[0].max(tight[1]);
    tight.map(|v| v * margin.clamp(MARGINS[0], MARGINS[1]))
}

impl Vicinities {
    /// Returns the vicinities of a fan table. `rear` is the radius of the rear element, mm.
    pub(super) fn of(table: &FanTable, rear: f32) -> Self {
        let halves = match table {
            FanTable::RearOnly => Vec::new(),
            FanTable::Round { fans, .. } => {
                fans.windows(2).map(|fans| enclosing(fans.iter(), rear)).collect()
            }
            FanTable::Polar(polar) => {
                let cells = (0..SPOKES).flat_map(|spoke| (0..POLAR_RINGS).map(move |k| (spoke, k)));
                cells.map(|(spoke, ring)| enclosing(polar.around(spoke, ring), rear)).collect()
            }
            FanTable::Grid { fans } => {
                let cell = |k: usize| {
                    let corners = [(0, 0), (1, 0), (0, 1), (1, 1)];
                    let at = |(i, j)| &fans[(k / CELLS + j) * (CELLS + 1) + k % CELLS + i];
                    enclosing(corners.into_iter().map(at), rear)
                };
                (0..CELLS * CELLS).map(cell).collect()
            }
        };
        Self { halves, round: None }
    }

    /// Returns the vicinities of a lens with a round stop. `middle` is the place of the film's centre
    /// among the film points of its bounds.
    pub(super) fn round(bounds: PupilBounds, middle: [f32; 2]) -> Self {
        Self { halves: Vec::new(), round: Some((Box::new(bounds), middle)) }
    }

    fn half(&self, cell: usize) -> [f32; 2] {
        self.halves.get(cell).copied().unwrap_or([0.0; 2])
    }

    /// Returns the area of the largest vicinity, mm^2.
    fn largest_area(&self) -> f32 {
        match &self.round {
            Some((round, _)) => round.vicinities.largest_area(),
            None => self.halves.iter().fold(0.0, |most, &half| most.max(area(half))),
        }
    }
}

fn area([a, b]: [f32; 2]) -> f32 {
    std::f32::consts::PI * a * b
}

impl PupilBounds {
    /// Returns the vicinity of a film point (mm) with this fan, in the frame of the fan.
    pub fn vicinity(&self, film: [f32; 2], fan: &Fan) -> Vicinity {
        if let Some((round, middle)) = &self.vicinities.round {
            let at = [0, 1].map(|i| film[i] + middle[i]);
            let vicinity = round.vicinity(at, &round.fan(at));
            let r = at[0].hypot(at[1]);
            return match round.uses_lens_frame() || r <= 0.0 {
                true => vicinity,
                false => vicinity.turned(at.map(|v| v / r)),
            };
        }
        let Some((cell, turn)) = self.vicinity_cell(film) else { return Vicinity::DARK };
        Vicinity { centre: fan.centre, half: self.vicinities.half(cell), turn }
    }

    /// Returns the cell of a film point in the fan table, and the direction of the u axis of the fans
    /// there.
    #[inline(always)]
    fn vicinity_cell(&self, film: [f32; 2]) -> Option<(usize, [f32; 2])> {
        match &self.table {
            FanTable::RearOnly => None,
            FanTable::Round { per_end, .. } => {
                let radius = (film[0] * film[0] + film[1] * film[1]).sqrt();
                let position = ring_position(radius * per_end);
                Some((ring(position) as usize, [1.0, 0.0]))
            }
            FanTable::Polar(polar) => polar.cell(film),
            FanTable::Grid { .. } => Some((self.cell(film), [1.0, 0.0])),
        }
    }

    /// Returns the density of the samples of the vicinity of a film point, mm^-2.
    pub(super) fn vicinity_density(&self, film: [f32; 2]) -> f32 {
        if let Some((round, middle)) = &self.vicinities.round {
            return round.vicinity_density([0, 1].map(|i| film[i] + middle[i]));
        }
        self.vicinity_cell(film).map_or(0.0, |(cell, _)| self.cell_density(cell))
    }

    /// Returns that density in a cell of the fan table.
    pub(super) fn cell_density(&self, cell: usize) -> f32 {
        let area = area(self.vicinities.half(cell));
        if area > 0.0 { self.shares.vicinity / area } else { 0.0 }
    }

    /// Returns the largest reciprocal of the density of samples in the vicinity of any film point,
    /// mm^2. No weight there exceeds it over the square of the distance from the film to the rear
    /// vertex.
    pub fn largest_area(&self) -> f32 {
        self.vicinities.largest_area() / self.shares.vicinity
    }
}
