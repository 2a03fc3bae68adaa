//! Squared Fourier transform of a pupil along lines through its centre.

use std::f64::consts::{PI, TAU};

use super::fourier::{LineFft, LineFftScratch};
use petzval_lens::{ExitPupil, PupilEdge};

/// Points of a line per fringe. The spacing is a quarter of a fringe, half of what the square of a
/// transform needs, and the last frequency is twice the last fringe.
const LINE: usize = 16;
/// The least extent of an edge along a line (spacings). Shorter edges are stretched to it.
const SHORTEST: f64 = 1e-3;

/// The Fourier transform of a pupil along lines through its centre.
pub(super) struct PupilTransform<'a> {
    pub pupil: &'a ExitPupil,
    centre: [f64; 2],
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
        let centre = pupil.centre();
        let mut lines = Self { pupil, centre, width, fringes, fft, scales: Vec::new() };
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
        let [x, y] = self.centre;
        let origin = x * cos + y * sin;
        let len = scratch.numbers.len();
        scratch.numbers.fill(0.0);
        let mut put = |place: f64, height: f64| {
            let before = place as usize;
            let share = place - before as f64;
            let rest = 1.0 - share;
            let (share2, rest2) = (share * share, rest * rest);
            let weights = [
                rest * rest2,
                4.0 - 6.0 * share2 + 3.0 * share * share2,
                4.0 - 6.0 * rest2 + 3.0 * rest * rest2,
                share * share2,
            ];
            let points = &mut scratch.numbers[before - 1..before + 3];
            points.iter_mut().zip(weights).for_each(|(p, w)| *p += height * w);
        };
        let per_spacing = spacing.recip();
        let middle = len as f64 / 2.0 - origin * per_spacing;
        let mut moment = 0.0;
        for &PupilEdge { from, to, step } in &self.pupil.edges {
            let s = |[x, y]: [f64; 2]| (x * cos + y * sin) * per_spacing + middle;
            let t = |[x, y]: [f64; 2]| y * cos - x * sin;
            let (mut from_s, mut to_s) = (s(from), s(to));
            let along = step * (t(to) - t(from));
            moment += along * ((from_s + to_s) / 2.0 - len as f64 / 2.0);
            if (to_s - from_s).abs() < SHORTEST {
                let at = (from_s + to_s) / 2.0;
                (from_s, to_s) = (at - SHORTEST / 2.0, at + SHORTEST / 2.0);
            }
            // The spline's weights are sixths.
            let slope = along / (to_s - from_s) * (per_spacing / 6.0);
            put(from_s, slope);
            put(to_s, -slope);
        }
        self.fft.transform(scratch);
        power.clear();
        power.push((moment * spacing).powi(2));
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
