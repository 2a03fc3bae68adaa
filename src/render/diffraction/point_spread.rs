//! Point spread function of white light: the density over the film around a point, by channel.
//!
//! The table is in polar coordinates, because the spreads of different wavelengths differ in scale
//! only: the integral over a band of wavelengths becomes an integral along the radius, which is
//! exact, whereas a sum over wavelengths leaves spurious rings far out. By the projection theorem
//! the transform of a pupil along a direction is the one-dimensional transform of its projection.
//!
//! Radii are measured in fringes: wavelength over pupil width.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use super::band_integral::BandIntegrals;
use super::pupil_transform::{PupilTransform, halve};
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
    /// By direction over 180 degrees, from the film's +x towards +y, then by radius. The other half
    /// is the same.
    table: Vec<[f32; 3]>,
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
        let mut table = vec![[0.0; 3]; directions * radii];
        let buffers = || (transform.fft.scratch(), Vec::new());
        table.par_chunks_mut(radii).enumerate().for_each_init(
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
        let next = (direction + 1) % self.directions;
        let beyond = (self.last / radius.max(self.last)).powi(3);
        let row = |direction: usize| &self.table[direction * self.radii + ring..][..2];
        let (a, b) = (row(direction), row(next));
        [0, 1, 2].map(|c| {
            let mix = |row: &[[f32; 3]]| {
                let [near, far] = [row[0][c], row[1][c]].map(f64::from);
                near + along * (far - near)
            };
            beyond * (mix(a) + across * (mix(b) - mix(a)))
        })
    }

    /// Returns the share of the light, by channel, outside a rectangle of these half sizes (um)
    /// about the point.
    pub fn outside(&self, half: [f64; 2]) -> [f64; 3] {
        let along = |direction: usize| {
            let angle = PI * (direction as f64 + 0.5) / self.directions as f64;
            let (sin, cos) = angle.sin_cos();
            let mut radius = (half[0] / cos.abs()).min(half[1] / sin.abs());
            let mut sum = [0.0; 3];
            while radius < self.last {
                let next = radius * RATIO;
                let middle = (radius + next) / 2.0;
                let there = self.at([middle * cos, middle * sin]);
                sum = [0, 1, 2].map(|c| sum[c] + there[c] * middle * (next - radius));
                radius = next;
            }
            // The rest decays as the cube of the distance.
            let there = self.at([radius * cos, radius * sin]);
            [0, 1, 2].map(|c| sum[c] + there[c] * radius * radius)
        };
        // The sum is sequential, so that it does not depend on the number of threads.
        let all: Vec<[f64; 3]> = (0..self.directions).into_par_iter().map(along).collect();
        let sum = all.iter().fold([0.0; 3], |sum, v| [0, 1, 2].map(|c| sum[c] + v[c]));
        sum.map(|sum| sum * TAU / self.directions as f64)
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
