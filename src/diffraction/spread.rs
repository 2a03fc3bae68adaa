//! How white light of a point is spread: the density over the film around it, by channel.
//!
//! In polar coordinates about the point, because the spread of another wavelength is the same
//! but for its scale: over a band of wavelengths that makes an integral along the radius, which
//! is exact where sums over wavelengths would leave rings of their own far out. By the projection
//! theorem the transform of a pupil along a direction is that of its projection on it, one line.

use std::f64::consts::{PI, TAU};

use rayon::prelude::*;

use super::fourier::Line;
use crate::lens::ExitPupil;
use crate::spectrum::LightBand;

/// Fringes, wavelengths over pupil widths, to which spreads are followed: at least and at most.
/// Beyond, they fade as the cube of the distance and keep their form, as seen from the point.
const FRINGES: [usize; 2] = [64, 512];
/// Directions over half a turn, by fringe: two to the width of a ray at the last fringe.
const DIRECTIONS: usize = 6;
/// Numbers of a line, by fringe. Its spacing is a quarter of a fringe, which is half of what the
/// square of a transform needs, and its last frequency twice the last fringe.
const LINE: usize = 16;
/// How many times the steps between its frequencies are halved before they are summed: what is left
/// of the error of sums is below 1e-4 of the spread's middle.
const HALVINGS: u32 = 2;
/// From one radius of the table to the next.
const RATIO: f64 = 1.02;
/// The first radius, fringes of the shortest wavelength: inside, the spread is even.
const FIRST: f64 = 0.04;
/// The least extent of an edge along a line, spacings: what is shorter is drawn out to it.
const SHORTEST: f64 = 1e-3;

/// The density of a point's light on the film around it, um^-2, by channel: that of all bands of the
/// light by their response, all wavelengths of a band the same.
#[derive(Clone, Debug)]
pub struct Spread {
    /// Direction after direction over half a turn, from the film's +x towards +y; the other half
    /// is the same.
    table: Vec<[f32; 3]>,
    directions: usize,
    radii: usize,
    /// um.
    first: f64,
    /// um.
    last: f64,
}

impl Spread {
    /// Of a pupil and light in bands of the same width, one after another; to be known up to this
    /// distance and to this detail, um. Takes half a second of one core at most.
    pub fn new(pupil: &ExitPupil, light: &[LightBand], reach: f64, detail: f64) -> Self {
        let wavelengths = wavelengths(light);
        let middle = pupil.middle();
        let away = |[x, y]: [f64; 2]| (x - middle[0]).hypot(y - middle[1]);
        let points = pupil.edges.iter().flat_map(|edge| [edge.from, edge.to]);
        let width = 2.0 * points.map(away).fold(0.0, f64::max);
        let shortest = wavelengths[0];
        // A ray of a star is two fringes wide, and beyond the last one grows in proportion: to two
        // of what matters at most.
        let wanted = reach * (width / shortest).min(1.0 / detail);
        let wanted = wanted.min(FRINGES[1] as f64) as usize;
        let fringes = wanted.next_multiple_of(FRINGES[0]).max(FRINGES[0]);
        let fringe = shortest / width;
        let (first, last) = (FIRST * fringe, fringes as f64 * fringe);
        let radii = ((last / first).ln() / RATIO.ln()).floor() as usize + 1;
        let lines = Lines::new(pupil, width, fringes);
        let sums = Sums::new(light, &wavelengths, &lines, [first, radii as f64]);
        let directions = DIRECTIONS * fringes;
        let mut table = vec![[0.0; 3]; directions * radii];
        let buffers = || (lines.fft.scratch(), Vec::new());
        table.par_chunks_mut(radii).enumerate().for_each_init(
            buffers,
            |(scratch, power), (direction, row)| {
                let angle = PI * direction as f64 / directions as f64;
                lines.power(angle, scratch, power);
                for _ in 0..HALVINGS {
                    halve(power);
                }
                sums.fill(power, row);
            },
        );
        let last = first * RATIO.powi(radii as i32 - 1);
        Self { table, directions, radii, first, last }
    }

    /// At an offset from the point, um, the film's frame.
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

    /// The share of the light, by channel, that lands outside a rectangle of these half sizes, um,
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
            // As the cube of the distance from here on.
            let there = self.at([radius * cos, radius * sin]);
            [0, 1, 2].map(|c| sum[c] + there[c] * radius * radius)
        };
        // Added up in order, so that threads do not matter.
        let all: Vec<[f64; 3]> = (0..self.directions).into_par_iter().map(along).collect();
        let sum = all.iter().fold([0.0; 3], |sum, v| [0, 1, 2].map(|c| sum[c] + v[c]));
        sum.map(|sum| sum * TAU / self.directions as f64)
    }
}

/// Where in a list of points a place lies: before which, and how far on.
fn split(place: f64, points: usize) -> (usize, f64) {
    let before = (place as usize).min(points - 2);
    (before, place - before as f64)
}

/// The limits of all bands, um.
fn wavelengths(bands: &[LightBand]) -> Vec<f64> {
    let width = (bands[1].wavelength - bands[0].wavelength) * 1e-3;
    let first = bands[0].wavelength * 1e-3 - width / 2.0;
    (0..=bands.len()).map(|i| first + width * i as f64).collect()
}

/// The transform of a pupil along lines through its middle.
struct Lines<'a> {
    pupil: &'a ExitPupil,
    /// No point of the pupil is farther than half of it from the middle.
    width: f64,
    fringes: usize,
    fft: Line,
    /// What the square of a line's transform multiplies, by frequency from the second on: to the
    /// last fringe, and what interpolation asks for beyond it.
    scales: Vec<f64>,
}

impl<'a> Lines<'a> {
    fn new(pupil: &'a ExitPupil, width: f64, fringes: usize) -> Self {
        let fft = Line::new(LINE * fringes);
        let mut lines = Self { pupil, width, fringes, fft, scales: Vec::new() };
        let scale = |i: usize| {
            let k = TAU * lines.step() * i as f64;
            let half = PI * i as f64 / (LINE * fringes) as f64;
            let spline = (half.sin() / half).powi(4);
            (k * k * spline).powi(2).recip()
        };
        lines.scales = (1..fringes * LINE / 4 + 8).map(scale).collect();
        lines
    }

    /// From one frequency to the next, wavelengths over T.
    fn step(&self) -> f64 {
        1.0 / (self.spacing() * (LINE * self.fringes) as f64)
    }

    /// From one number of the line to the next, in T.
    fn spacing(&self) -> f64 {
        4.0 * self.width / (LINE * self.fringes) as f64
    }

    /// The square of the transform in one direction, by frequency.
    ///
    /// An edge contributes step * slope * (e(s_from) - e(s_to)) / (2 pi k)^2, e(s) = exp(-2 pi i k
    /// s): impulses at the ends of edges, spread over four numbers of the line by a cubic spline
    /// whose transform is divided out (Greengard & Lee 2004, "Accelerating the nonuniform fast
    /// Fourier transform").
    fn power(&self, angle: f64, scratch: &mut super::fourier::LineScratch, power: &mut Vec<f64>) {
        let (sin, cos) = angle.sin_cos();
        let spacing = self.spacing();
        let [x, y] = self.pupil.middle();
        let origin = x * cos + y * sin;
        let len = scratch.numbers.len();
        scratch.numbers.fill(0.0);
        let mut put = |at: f64, height: f64| {
            let place = at / spacing + len as f64 / 2.0;
            let (before, share) = (place.floor(), place - place.floor());
            let first = before as usize;
            let rest = 1.0 - share;
            let weights = [
                rest * rest * rest,
                4.0 - 6.0 * share * share + 3.0 * share * share * share,
                4.0 - 6.0 * rest * rest + 3.0 * rest * rest * rest,
                share * share * share,
            ];
            let points = &mut scratch.numbers[first - 1..first + 3];
            points.iter_mut().zip(weights).for_each(|(p, w)| *p += height * w / 6.0);
        };
        let mut moment = 0.0;
        for edge in &self.pupil.edges {
            let s = |[x, y]: [f64; 2]| x * cos + y * sin - origin;
            let t = |[x, y]: [f64; 2]| y * cos - x * sin;
            let (mut from, mut to) = (s(edge.from), s(edge.to));
            let along = t(edge.to) - t(edge.from);
            moment += edge.step * along * (from + to) / 2.0;
            if (to - from).abs() < SHORTEST * spacing {
                let middle = (from + to) / 2.0;
                let half = SHORTEST * spacing / 2.0;
                (from, to) = (middle - half, middle + half);
            }
            let slope = edge.step * along / (to - from);
            put(from, slope);
            put(to, -slope);
        }
        self.fft.transform(scratch);
        power.clear();
        power.push(moment * moment);
        let transformed = scratch.spectrum[1..].iter().zip(&self.scales);
        power.extend(transformed.map(|(value, scale)| value.norm_sqr() * scale));
    }
}

/// Puts a value between each and the next, by the polynomial through the eight around it. Before the
/// first, values are as behind it.
fn halve(values: &mut Vec<f64>) {
    const WEIGHTS: [f64; 4] = [1225.0, -245.0, 49.0, -5.0];
    let (mirrored, last) = ([values[3], values[2], values[1]], [values[values.len() - 1]; 4]);
    let around = [&mirrored[..], values, &last].concat();
    values.clear();
    for around in around.array_windows::<8>() {
        let pair = |k: usize| WEIGHTS[k] * (around[3 - k] + around[4 + k]);
        values.extend([around[3], (pair(0) + pair(1) + pair(2) + pair(3)) / 2048.0]);
    }
}

/// A radius of the table and a wavelength: which frequencies they meet, and what their integrals
/// and their values count there.
struct Place {
    before: usize,
    weights: [f64; 4],
}

/// Integrals over wavelengths. At a radius r, those from a to b give the integral over frequencies
/// k = r / wavelength from r / b to r / a, over r (b - a).
struct Sums {
    /// Radius after radius, a place for each limit of a band.
    places: Vec<Place>,
    /// What the integral from 0 to each limit counts, by channel.
    factors: Vec<[f64; 3]>,
    /// What a radius multiplies it by.
    scales: Vec<f64>,
    step: f64,
}

impl Sums {
    fn new(
        bands: &[LightBand],
        wavelengths: &[f64],
        lines: &Lines,
        [first, radii]: [f64; 2],
    ) -> Self {
        let step = lines.step() / f64::from(1 << HALVINGS);
        let count = bands.len() as f64;
        let response = |band: Option<&LightBand>| band.map_or([0.0; 3], |band| band.response);
        let factor = |i: usize| {
            let (above, below) = (response(bands.get(i)), response(bands.get(i.wrapping_sub(1))));
            [0, 1, 2].map(|c| (above[c] - below[c]) / count)
        };
        let width = wavelengths[1] - wavelengths[0];
        let (mut places, mut scales) = (Vec::new(), Vec::new());
        for radius in (0..radii as i32).map(|ring| first * RATIO.powi(ring)) {
            scales.push(1.0 / (radius * width * lines.pupil.area));
            for wavelength in wavelengths {
                let place = radius / wavelength / step;
                let (before, t) = (place as usize, place.fract());
                // Hermite's cubic, of values and of slopes.
                let (t2, t3) = (t * t, t * t * t);
                let far = 3.0 * t2 - 2.0 * t3;
                let slopes = [t - 2.0 * t2 + t3, t3 - t2].map(|slope| slope * step);
                places.push(Place { before, weights: [1.0 - far, far, slopes[0], slopes[1]] });
            }
        }
        Self { places, factors: (0..wavelengths.len()).map(factor).collect(), scales, step }
    }

    /// The densities along a direction, from the square of the transform there.
    fn fill(&self, power: &[f64], row: &mut [[f32; 3]]) {
        // By the trapezoid rule and its first correction (Euler and Maclaurin).
        let mut sum = 0.0;
        let mut integral = Vec::with_capacity(power.len());
        for i in 0..power.len() - 1 {
            let slope = if i > 0 { power[i + 1] - power[i - 1] } else { 0.0 };
            integral.push([self.step * (sum - slope / 24.0), power[i]]);
            sum += (power[i] + power[i + 1]) / 2.0;
        }
        let places = self.places.chunks_exact(self.factors.len());
        for ((density, places), scale) in row.iter_mut().zip(places).zip(&self.scales) {
            let mut sum = [0.0; 3];
            for (Place { before, weights }, factor) in places.iter().zip(&self.factors) {
                let [[near, near_slope], [far, far_slope]] =
                    [integral[*before], integral[before + 1]];
                let [a, b, c, d] = weights;
                let value = a * near + b * far + c * near_slope + d * far_slope;
                sum = [0, 1, 2].map(|c| sum[c] + factor[c] * value);
            }
            // Of a square; rounding aside.
            *density = sum.map(|sum| (sum * scale).max(0.0) as f32);
        }
    }
}
