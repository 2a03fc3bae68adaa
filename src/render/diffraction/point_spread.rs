//! Point spread function of white light: the density over the film around a point, by channel.
//!
//! The table is in polar coordinates, because the spreads of different wavelengths differ in scale
//! only: the integral over a band of wavelengths becomes an integral along the radius, which is
//! exact, whereas a sum over wavelengths leaves spurious rings far out. By the projection theorem
//! the transform of a pupil along a direction is the one-dimensional transform of its projection.
//!
//! Radii are measured in fringes: wavelength over pupil width.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::band_integral::BandIntegrals;
use super::pupil_transform::{PupilTransform, halve};
use petzval_base::lanes::math::{arctangent, ln};
use petzval_base::lanes::{Real, f32x8};
use petzval_lens::ExitPupil;
use petzval_spectrum::LightBand;

/// Fewest and most fringes to which spreads are tabulated. Beyond, they decay as the cube of the
/// distance and keep their angular shape.
const FRINGES: [usize; 2] = [64, 512];
/// Directions over 180 degrees per fringe: two to the width of a diffraction spike at the last
/// fringe.
const DIRECTIONS: usize = 6;
/// How many times the steps between frequencies are halved before integration. The remaining error
/// is below 1e-4 of the spread's centre.
pub(super) const HALVINGS: u32 = 2;
/// Ratio of successive radii of the table.
pub(super) const RATIO: f64 = 1.02;
/// The first radius, in fringes of the shortest wavelength. Inside, the spread is constant.
const FIRST: f64 = 0.04;

/// The density of a point's light on the film around it, by channel [um^-2]: the sum over all bands
/// by their response, with equal weights within a band.
#[derive(Clone, Debug)]
pub struct PointSpread {
    /// By radius, then by direction over 180 degrees, from the film's +x towards +y, with the first one
    /// again behind the last. The other half is the same. The fourth number is 0.
    table: Vec<[f32; 4]>,
    directions: usize,
    radii: usize,
    /// First radius (um).
    first: f64,
    /// Last radius (um).
    last: f64,
}

impl PointSpread {
    /// Tabulates the spread of a pupil for light in contiguous bands of equal width, up to the
    /// distance `reach` and with the resolution `detail` (um). Takes half a second on one core at
    /// most.
    pub fn new(pupil: &ExitPupil, light: &[LightBand], reach: f64, detail: f64) -> Self {
        let wavelengths = wavelengths(light);
        let middle = pupil.centre();
        let away = |[x, y]: [f64; 2]| (x - middle[0]).hypot(y - middle[1]);
        let points = pupil.edges.iter().flat_map(|edge| [edge.from, edge.to]);
        let width = 2.0 * points.map(away).fold(0.0, f64::max);
        let shortest = wavelengths[0];
        // A diffraction spike is two fringes wide up to the last fringe, and grows in proportion
        // beyond. It may grow to at most two of the resolution.
        let fringes = reach * (width / shortest).min(1.0 / detail);
        let fringes = fringes.min(FRINGES[1] as f64) as usize;
        let fringes = fringes.next_multiple_of(FRINGES[0]).max(FRINGES[0]);
        let fringe = shortest / width;
        let (first, last) = (FIRST * fringe, fringes as f64 * fringe);
        let radii = ((last / first).ln() / RATIO.ln()).floor() as usize + 1;
        let transform = PupilTransform::new(pupil, width, fringes);
        let integrals = BandIntegrals::new(light, &wavelengths, &transform, [first, radii as f64]);
        let directions = DIRECTIONS * fringes;
        let mut rows = vec![[0.0; 3]; directions * radii];
        let buffers = || (transform.fft.scratch(), Vec::new());
        rows.par_chunks_mut(radii).enumerate().for_each_init(
            buffers,
            |(scratch, power), (direction, row)| {
                let angle = PI * direction as f64 / directions as f64;
                transform.power(angle, scratch, power);
                for _ in 0..HALVINGS {
                    halve(power);
                }
                integrals.fill(power, row);
            },
        );
        let mut table = vec![[0.0; 4]; (directions + 1) * radii];
        table.par_chunks_mut(directions + 1).enumerate().for_each(|(ring, line)| {
            for (direction, value) in line.iter_mut().enumerate() {
                let [r, g, b] = rows[direction % directions * radii + ring];
                *value = [r, g, b, 0.0];
            }
        });
        let last = first * RATIO.powi(radii as i32 - 1);
        Self { table, directions, radii, first, last }
    }

    /// Returns the density at an offset from the point, um, in the film's frame.
    pub fn at(&self, [x, y]: [f64; 2]) -> [f64; 3] {
        let radius = (x * x + y * y).sqrt();
        let place = (radius / self.first).max(1.0).ln() / RATIO.ln();
        let place = place.min((self.radii - 1) as f64);
        let (ring, along) = split(place, self.radii);
        let half_turns = y.atan2(x) / PI;
        let place = (half_turns - half_turns.floor()) * self.directions as f64;
        let (direction, across) = split(place, self.directions + 1);
        let beyond = (self.last / radius.max(self.last)).powi(3);
        let row = |ring: usize| &self.table[ring * (self.directions + 1) + direction..][..2];
        let (near, far) = (row(ring), row(ring + 1));
        [0, 1, 2].map(|c| {
            let mix = |row: &[[f32; 4]]| {
                let [a, b] = [row[0][c], row[1][c]].map(f64::from);
                a + across * (b - a)
            };
            beyond * (mix(near) + along * (mix(far) - mix(near)))
        })
    }

    /// Returns the densities at eight offsets as [`Self::at`] does, in f32, and a number without
    /// meaning.
    #[inline(always)]
    pub(super) fn at_lanes(&self, [x, y]: [f32x8; 2]) -> [[f32; 4]; 8] {
        let constant = |v: f64| f32x8::splat(v as f32);
        let zero = f32x8::splat(0.0);
        let r2 = x * x + y * y;
        // Inside the first radius the spread is constant.
        let scaled = (r2 * constant(1.0 / (self.first * self.first))).max(f32x8::splat(1.0));
        let place = ln(scaled) * constant(0.5 / RATIO.ln());
        let place = place.min(constant((self.radii - 1) as f64));
        // The angle over 180 degrees, from that to the nearer axis.
        let (wide, high) = (x.abs(), y.abs());
        let ratio = wide.min(high) / wide.max(high).max(f32x8::splat(f32::MIN_POSITIVE));
        let turn = arctangent(ratio) * constant(1.0 / PI);
        let turn = f32x8::select(wide.lt(high), constant(0.5) - turn, turn);
        let mirrored = (x * y).lt(zero);
        let turn = f32x8::select(mirrored, constant(1.0) - turn, turn);
        let angle = turn * constant(self.directions as f64);
        let last = constant(self.last);
        let beyond = last / r2.sqrt().max(last);
        let beyond = beyond * beyond * beyond;
        let (mut places, mut angles, mut factors) = ([0.0; 8], [0.0; 8], [0.0; 8]);
        place.store(&mut places);
        angle.store(&mut angles);
        beyond.store(&mut factors);
        std::array::from_fn(|lane| {
            let ring = (places[lane] as usize).min(self.radii - 2);
            let direction = (angles[lane] as usize).min(self.directions - 1);
            let (along, across) = (places[lane] - ring as f32, angles[lane] - direction as f32);
            let row = |ring: usize| &self.table[ring * (self.directions + 1) + direction..][..2];
            let (near, far) = (row(ring), row(ring + 1));
            let weights = [1.0 - along, along].map(|v| factors[lane] * v);
            std::array::from_fn(|c| {
                let mix = |row: &[[f32; 4]]| row[0][c] + across * (row[1][c] - row[0][c]);
                weights[0] * mix(near) + weights[1] * mix(far)
            })
        })
    }

    /// Returns the last radius of the table (um).
    pub(super) fn last(&self) -> f64 {
        self.last
    }
}

/// Splits a position in a list into the index of the point before it and the fraction after that
/// point.
fn split(place: f64, points: usize) -> (usize, f64) {
    let before = (place as usize).min(points - 2);
    (before, place - before as f64)
}

/// Returns the limits of all bands (um).
fn wavelengths(bands: &[LightBand]) -> Vec<f64> {
    let width = (bands[1].wavelength - bands[0].wavelength) * 1e-3;
    let first = bands[0].wavelength * 1e-3 - width / 2.0;
    (0..=bands.len()).map(|i| first + width * i as f64).collect()
}
