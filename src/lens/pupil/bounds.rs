//! Bounds of the exit pupil for every film point.

use super::density::{Regions, Shares};
use super::fan::{Fan, TRIANGLES};
use super::film_grid::FilmGrid;
use super::polar_grid::PolarGrid;
use super::table::TableBuilder;
use super::target::TriangleSteps;
use super::vicinity::Vicinities;
use super::{CELLS, Ellipse, PupilSampling, RINGS};
use crate::prescription::iris::Iris;
use crate::prescription::pose::FilmPlane;
use crate::prescription::{Prescription, Row};

/// The bounds of a lens's exit pupil for every film point.
#[derive(Clone, Debug)]
pub struct PupilBounds {
    pub(super) table: FanTable,
    /// Bounds of the rear element, seen from each of RINGS rings of equal width or from each cell
    /// of a grid.
    pub(super) rear: Vec<Ellipse>,
    /// For each of them the density of the samples drawn from the rear element, mm^-2.
    pub(super) rear_density: Vec<f32>,
    pub(super) vicinities: Vicinities,
    pub(super) cells: FilmGrid,
    pub(super) rings_per_mm: f32,
    pub(super) shares: Shares,
    /// Whether samples outside the fans have no weight. Set for lens models that know no rims.
    pub(crate) fans_only: bool,
}

/// Table of fans over the film.
#[derive(Clone, Debug)]
pub(crate) enum FanTable {
    /// No fans: all samples are drawn from the rear element.
    RearOnly,
    /// By film radius, in the frame of the film point. The edges of all rings are followed by two
    /// empty fans for the dark film beyond. `open` has a bit set for every fan with an area.
    /// `per_end` is 1 over the radius at which the light ends, 1/mm.
    Round { fans: Box<[Fan; RINGS + 3]>, steps: TriangleSteps, open: u128, per_end: f32 },
    /// By spokes and rings about the axis.
    Polar(PolarGrid),
    /// By corner of the grid over the film, row by row.
    Grid { fans: Vec<Fan> },
}

/// Returns the position of a film point among the rings, from its radius relative to the radius at
/// which the light ends. Rings are narrower there, because the pupil closes ever faster.
#[inline(always)]
pub(super) fn ring_position(radius: f32) -> f32 {
    RINGS as f32 * (1.0 - (1.0 - radius).max(0.0).sqrt())
}

/// Returns the ring of a position; beyond the light, the dark ring.
#[inline(always)]
pub(super) fn ring(position: f32) -> u32 {
    let ring = integer_part(position);
    if ring < RINGS as u32 { ring } else { RINGS as u32 + 1 }
}

/// Returns the integer part of a number from 0 to 2^22; for an integer perhaps the one before. It
/// uses the bits of a sum, because the conversion has no vector form.
#[inline(always)]
pub(super) fn integer_part(number: f32) -> u32 {
    const UNIT: f32 = 8_388_608.0;
    ((number - 0.5).max(0.0) + UNIT).to_bits() & 0x7f_ffff
}

impl PupilBounds {
    /// Computes the bounds for a film `distance` mm behind the rear vertex that extends to `radius`
    /// mm from the axis. Takes some milliseconds.
    pub fn new(lens: &Prescription, distance: f64, radius: f64, sampling: PupilSampling) -> Self {
        Self::for_film(lens, &FilmPlane::aligned(distance, radius), sampling)
    }

    /// Computes the bounds for a film that may be tilted or decentred. Takes a tenth of a second if
    /// it is tilted or the lens is not round.
    pub fn for_film(lens: &Prescription, film: &FilmPlane, sampling: PupilSampling) -> Self {
        Self::for_wavelengths(lens, &[], film, sampling)
    }

    /// Computes the bounds that enclose the light of a lens and of the same lens at other
    /// wavelengths.
    pub(crate) fn for_wavelengths(
        lens: &Prescription,
        others: &[Prescription],
        film: &FilmPlane,
        sampling: PupilSampling,
    ) -> Self {
        if lens.rows.iter().any(Row::has_arms) {
            // An outline would be notched at each arm, and miss the light beside it. Rays that meet an
            // arm are lost.
            let without_arms = |lens: &Prescription| {
                let mut lens = lens.clone();
                lens.rows.iter_mut().for_each(Row::remove_arms);
                lens
            };
            let others: Vec<Prescription> = others.iter().map(without_arms).collect();
            return Self::for_wavelengths(&without_arms(lens), &others, film, sampling);
        }
        let with_round_iris = || {
            let round = |lens: &Prescription| {
                let mut round = lens.clone();
                round.rows.iter_mut().for_each(|row| row.iris = Iris::Round);
                round
            };
            let others: Vec<Prescription> = others.iter().map(round).collect();
            Self::for_wavelengths(&round(lens), &others, film, PupilSampling::Pupil)
        };
        if sampling == PupilSampling::RoundIris {
            return with_round_iris();
        }
        let &FilmPlane { distance, pose, radius, half } = film;
        let builder = TableBuilder { lens, others, distance, pose };
        // Rings are centred on the axis.
        let [x, y] = pose.decentre;
        let radius = radius + x.hypot(y);
        let level = lens.is_round() && pose.is_untilted();
        let (rear, table, shares) = match sampling {
            PupilSampling::RearDisk => {
                let half = lens.rear().diameter as f32 / 2.0;
                let disk = Ellipse { centre: [0.0; 2], half: [half; 2] };
                (vec![disk; RINGS], FanTable::RearOnly, Shares::REAR_ONLY)
            }
            PupilSampling::Pupil | PupilSampling::Axis if level => {
                let edge = |i: usize| radius * i as f64 / RINGS as f64;
                let ring = |i: usize| builder.rear_ellipse([edge(i), edge(i + 1)]);
                let axis = sampling == PupilSampling::Axis;
                let table =
                    if axis { builder.build_axis(radius) } else { builder.build_rings(radius) };
                ((0..RINGS).map(ring).collect(), table, Shares::AROUND_FAN)
            }
            PupilSampling::Pupil | PupilSampling::Axis | PupilSampling::RoundIris => {
                let nearly_round = lens.rows.iter().all(Row::is_round);
                let polar = if nearly_round { builder.build_spokes(half) } else { None };
                let table = polar.unwrap_or_else(|| builder.build_grid(half));
                (builder.rear_cells(half), table, Shares::AROUND_FAN)
            }
        };
        let rings_per_mm = (RINGS as f64 / radius) as f32;
        let mut bounds = Self {
            table,
            rear_density: rear.iter().map(|ellipse| shares.rear / ellipse.area()).collect(),
            rear,
            vicinities: Vicinities::default(),
            cells: FilmGrid::new(half),
            rings_per_mm,
            shares,
            fans_only: false,
        };
        let is_shaped =
            bounds.uses_lens_frame() && lens.rows.iter().any(|row| row.iris != Iris::Round);
        bounds.vicinities = match is_shaped {
            true => {
                let round = with_round_iris();
                // Rings are centred on the axis; other tables cover the film itself.
                let middle = match round.uses_lens_frame() {
                    true => [0.0; 2],
                    false => pose.decentre.map(|v| v as f32),
                };
                Vicinities::round(round, middle)
            }
            false => Vicinities::of(&bounds.table, lens.rear().diameter as f32 / 2.0),
        };
        if let FanTable::Round { fans, .. } = &bounds.table {
            let densities: Vec<f32> = (0..fans.len()).map(|k| bounds.cell_density(k)).collect();
            if let FanTable::Round { steps, .. } = &mut bounds.table {
                steps.set_density(|ring| densities[ring]);
            }
        }
        bounds
    }

    /// Returns whether pupil points are in the frame of the lens, and film points are looked up by
    /// their position on the film itself.
    pub(crate) fn uses_lens_frame(&self) -> bool {
        matches!(self.table, FanTable::Grid { .. } | FanTable::Polar(_))
    }

    /// Returns an ellipse that encloses the rear element as seen from a film point, mm.
    pub fn rear(&self, film: [f32; 2]) -> Ellipse {
        if self.uses_lens_frame() {
            return self.rear[self.cell(film)];
        }
        self.rear[self.rear_ring(film[0].hypot(film[1])) as usize]
    }

    /// Returns the index of the cell of a film point.
    #[inline(always)]
    pub(super) fn cell(&self, film: [f32; 2]) -> usize {
        let [(column, _), (row, _)] = self.cells.cell(film);
        row * CELLS + column
    }

    /// Returns the regions that the samples of a film point (mm) are drawn from.
    pub(super) fn regions(&self, film: [f32; 2]) -> Regions {
        let fan = self.fan(film);
        Regions { vicinity: self.vicinity(film, &fan), fan, rear: self.rear(film) }
    }

    #[inline(always)]
    pub(super) fn rear_ring(&self, radius: f32) -> u32 {
        integer_part(radius * self.rings_per_mm).min(RINGS as u32 - 1)
    }

    /// Returns the sample density of a triangle times twice its area.
    pub(crate) fn triangle_density(&self) -> f32 {
        2.0 * (1.0 - self.shares.outside()) / TRIANGLES as f32
    }

    /// Returns the fan of a film point (mm); it is empty if all samples are drawn from the rear
    /// element.
    pub fn fan(&self, film: [f32; 2]) -> Fan {
        match &self.table {
            FanTable::RearOnly => Fan::EMPTY,
            FanTable::Round { fans, per_end, .. } => {
                let position = ring_position(film[0].hypot(film[1]) * per_end);
                let ring = ring(position);
                let t = position - ring as i32 as f32;
                let near = ring as usize;
                Fan::mix(&[(&fans[near], 1.0 - t), (&fans[near + 1], t)])
            }
            FanTable::Polar(polar) => polar.fan(film),
            FanTable::Grid { fans } => {
                let around = self.cells.corners(film);
                Fan::mix(&around.map(|(corner, weight)| (&fans[corner], weight)))
            }
        }
    }

    /// Returns whether light reaches any film point of a rectangle (mm).
    pub fn any_light(&self, low: [f64; 2], high: [f64; 2]) -> bool {
        match &self.table {
            FanTable::RearOnly => true,
            FanTable::Round { open, per_end, .. } => {
                let near = |i: usize| low[i].max(-high[i]).max(0.0) as f32;
                let far = |i: usize| high[i].max(-low[i]) as f32;
                let at = |a: f32, b: f32| ring(ring_position((a * a + b * b).sqrt() * per_end));
                let inner = at(near(0), near(1));
                // In most cases light reaches its nearest point.
                let lit = open >> inner;
                lit & 1 != 0 || {
                    let outer = at(far(0), far(1)) + 1;
                    lit & ((2 << (outer - inner)) - 1) != 0
                }
            }
            FanTable::Polar(polar) => polar.any_light(low, high),
            FanTable::Grid { fans } => {
                let FilmGrid { per_mm, half } = self.cells;
                let cell = |v: f64, i: usize, up: f64| {
                    let place = (v + f64::from(half[i])) * f64::from(per_mm[i]) + up;
                    place.clamp(0.0, CELLS as f64) as usize
                };
                let range = |i: usize| cell(low[i], i, 0.0)..=cell(high[i], i, 1.0);
                range(1).any(|j| range(0).any(|i| fans[j * (CELLS + 1) + i].is_open()))
            }
        }
    }
}
