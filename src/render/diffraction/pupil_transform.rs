//! Squared Fourier transform of a pupil along lines through its centre.

use std::f64::consts::{PI, TAU};

use super::fourier::{LineFft, LineFftScratch};
use petzval_lens::ExitPupil;

/// Points of a line per fringe. The spacing is a quarter of a fringe, half of what the square of a
/// transform needs, and the last frequency is twice the last fringe.
const LINE: usize = 16;
/// The least extent of an edge along a line, in spacings. Shorter edges are stretched to it.
const SHORTEST: f64 = 1e-3;

/// The Fourier transform of a pupil along lines through its centre.
pub(super) struct PupilTransform<'a> {
    pub pupil: &'a ExitPupil,
    /// Twice the largest distance of a pupil point from the centre.
    width: f64,
    fringes: usize,
    pub fft: LineFft,
    /// Factors of the squared transform by frequency, from the second on: to the last fringe, and
    /// beyond as far as interpolation needs.
    scales: Vec<f64>,
}

impl<'a> PupilTransform<'a> {
    pub fn new(pupil: &'a ExitPupil, width: f64, fringes: usize) -> Self {
        let fft = LineFft::new(LINE * fringes);
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

    /// Returns the step of the frequency [wavelengths per unit of T].
    pub fn step(&self) -> f64 {
        1.0 / (self.spacing() * (LINE * self.fringes) as f64)
    }

    /// Returns the spacing of the line, in T.
    fn spacing(&self) -> f64 {
        4.0 * self.width / (LINE * self.fringes) as f64
    }

    /// Computes the square of the transform in one direction, by frequency.
    ///
    /// An edge contributes step * slope * (e(s_from) - e(s_to)) / (2 pi k)^2, e(s) = exp(-2 pi i k
    /// s): impulses at the ends of edges. Each is spread over four points of the line by a cubic
    /// spline whose transform is divided out (Greengard & Lee 2004, "Accelerating the nonuniform
    /// fast Fourier transform").
    pub fn power(&self, angle: f64, scratch: &mut LineFftScratch, power: &mut Vec<f64>) {
        let (sin, cos) = angle.sin_cos();
        let spacing = self.spacing();
        let [x, y] = self.pupil.centre();
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

/// Doubles the resolution by interpolation with the polynomial through the eight nearest values.
/// The values are continued evenly before the first.
pub(super) fn halve(values: &mut Vec<f64>) {
    const WEIGHTS: [f64; 4] = [1225.0, -245.0, 49.0, -5.0];
    let (mirrored, last) = ([values[3], values[2], values[1]], [values[values.len() - 1]; 4]);
    let around = [&mirrored[..], values, &last].concat();
    values.clear();
    for around in around.array_windows::<8>() {
        let pair = |k: usize| WEIGHTS[k] * (around[3 - k] + around[4 + k]);
        values.extend([around[3], (pair(0) + pair(1) + pair(2) + pair(3)) / 2048.0]);
    }
}
