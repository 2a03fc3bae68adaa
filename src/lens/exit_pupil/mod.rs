//! The exit pupil as a point of the film sees it: the shape that light bends at.
//!
//! Places in the pupil are directions from the film point: T = (T_x, T_y), the first two
//! components of a ray's direction times the refractive index before the film. In them the light
//! of a pupil is even (its irradiance is the radiance times the area, whatever the angle), and
//! the diffracted amplitude is a plain Fourier transform (Hopkins 1953, "On the diffraction
//! theory of optical images").
//!
//! A pupil is a list of straight edges with the step of the amplitude across each, because the
//! Fourier transform of a polygon is a sum over its edges: exact as far out as anyone looks, where
//! that of a grid of points has faded into its own copies.

mod outline;
mod raster;
mod sight;

use std::f64::consts::{PI, TAU};

use super::camera::RealLens;
use super::iris::Iris;
use sight::Sight;

/// A straight edge of a pupil, in the plane of T.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Edge {
    /// Where it begins.
    pub from: [f64; 2],
    /// Where it ends.
    pub to: [f64; 2],
    /// Amplitude on its left less that on its right.
    pub step: f64,
}

impl Edge {
    /// Along a direction and across it (counter-clockwise): where its middle is, and how far it
    /// goes.
    fn along(&self, [cos, sin]: [f64; 2]) -> (f64, [f64; 2]) {
        let s = |[x, y]: [f64; 2]| x * cos + y * sin;
        let t = |[x, y]: [f64; 2]| y * cos - x * sin;
        let (from, to) = (s(self.from), s(self.to));
        ((from + to) / 2.0, [to - from, t(self.to) - t(self.from)])
    }
}

/// The amplitude that a film point sees through a lens, at the d line and without the losses of
/// surfaces, which are nearly the same all over a pupil.
#[derive(Clone, Debug)]
pub struct ExitPupil {
    /// All of its edges. They close: the amplitude is 0 far away.
    pub edges: Vec<Edge>,
    /// The integral of the square of the amplitude.
    pub area: f64,
}

impl ExitPupil {
    /// The pupil that a point of the film (mm, the film's frame) sees: traced over a grid, its
    /// outline halved in on along the grid's lines. Where the stop has an iris of partial
    /// transmission, amplitudes are the roots of what comes through, in cells of a grid. Some
    /// milliseconds. None where the film point is dark.
    pub fn seen(lens: &RealLens, film: [f64; 2]) -> Option<Self> {
        let mut sight = Sight::new(lens, film);
        let frame = sight.frame(lens)?;
        let masked = lens.prescription.rows.iter().any(|row| matches!(row.iris, Iris::Mask(_)));
        match masked {
            true => raster::pupil(&mut sight, frame),
            false => outline::pupil(&mut sight, frame),
        }
    }

    /// A pupil of these corners, counter-clockwise, all open inside.
    pub fn polygon(corners: &[[f64; 2]]) -> Self {
        let next = |i: usize| corners[(i + 1) % corners.len()];
        let edge = |(i, &from): (usize, &[f64; 2])| Edge { from, to: next(i), step: 1.0 };
        let edges: Vec<Edge> = corners.iter().enumerate().map(edge).collect();
        Self { area: moment(&edges), edges }
    }

    /// A middle of it: that of the box around its edges.
    pub fn middle(&self) -> [f64; 2] {
        let [low, high] = self.bounds();
        [0, 1].map(|i| (low[i] + high[i]) / 2.0)
    }

    /// The box around its edges.
    fn bounds(&self) -> [[f64; 2]; 2] {
        let start = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        self.edges.iter().flat_map(|edge| [edge.from, edge.to]).fold(start, |[low, high], at| {
            [[0, 1].map(|i| low[i].min(at[i])), [0, 1].map(|i| high[i].max(at[i]))]
        })
    }

    /// How wide it is along a direction of this angle from +x.
    pub fn width(&self, angle: f64) -> f64 {
        let (sin, cos) = angle.sin_cos();
        let start = [f64::INFINITY, f64::NEG_INFINITY];
        let points = self.edges.iter().flat_map(|edge| [edge.from, edge.to]);
        let [low, high] = points.fold(start, |[low, high], [x, y]| {
            let s = x * cos + y * sin;
            [low.min(s), high.max(s)]
        });
        (high - low).max(0.0)
    }

    /// The sine (times the index) of the half angle of a round pupil of this area: 1 / (2 N) of the
    /// working f-number N.
    pub fn sine(&self) -> f64 {
        (self.area / PI).sqrt()
    }

    /// The radius of the Airy disc to its first zero for a wavelength, in the wavelength's unit:
    /// 0.61 lambda / sine (Airy 1835), of a round pupil of this area.
    pub fn airy(&self, wavelength: f64) -> f64 {
        FIRST_ZERO / TAU * wavelength / self.sine()
    }

    /// The density of a point's light, per area, at an offset from it on the film, for light of a
    /// wavelength, all in the same unit of length: |F(offset / wavelength)|^2 / (wavelength^2
    /// area), F the Fourier transform of the amplitude (Born & Wolf, 8.3). Its integral is 1.
    ///
    /// It is that of a flat wavefront: what the lens's aberrations and defocus do, rays carry.
    pub fn density(&self, offset: [f64; 2], wavelength: f64) -> f64 {
        let [re, im] = self.transform(offset.map(|v| v / wavelength));
        (re * re + im * im) / (wavelength * wavelength * self.area)
    }

    /// The Fourier transform of the amplitude, real and imaginary, about its middle: the integral
    /// of amplitude times exp(-2 pi i k.T), by Green's theorem a sum over edges (Lee & Mittra
    /// 1983, "Fourier transform of a polygonal shape function").
    fn transform(&self, [kx, ky]: [f64; 2]) -> [f64; 2] {
        let k = kx.hypot(ky);
        let direction = if k > 0.0 { [kx / k, ky / k] } else { [1.0, 0.0] };
        let [x, y] = self.middle();
        let origin = x * direction[0] + y * direction[1];
        // So small that the phase is the same all over the pupil.
        if k * self.area.sqrt() < 1e-6 {
            return [moment(&self.edges), 0.0];
        }
        let mut sum = [0.0; 2];
        for edge in &self.edges {
            let (middle, [across, along]) = edge.along(direction);
            let weight = edge.step * along * sinc(k * across);
            let (sin, cos) = (TAU * k * (middle - origin)).sin_cos();
            sum = [sum[0] + weight * cos, sum[1] - weight * sin];
        }
        // Times i / (2 pi k).
        [-sum[1] / (TAU * k), sum[0] / (TAU * k)]
    }
}

/// The first zero of the Bessel function J_1.
const FIRST_ZERO: f64 = 3.831_705_970_207_512;

/// sin(pi x) / (pi x).
fn sinc(x: f64) -> f64 {
    let x = PI * x;
    if x.abs() < 1e-4 { 1.0 - x * x / 6.0 } else { x.sin() / x }
}

/// The integral of the amplitude.
fn moment(edges: &[Edge]) -> f64 {
    let one = |Edge { from, to, step }: &Edge| step * (from[0] * to[1] - from[1] * to[0]) / 2.0;
    edges.iter().map(one).sum()
}
