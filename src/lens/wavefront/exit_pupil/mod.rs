//! Exit pupil as seen from a film point: the shape that diffracts light.
//!
//! Pupil coordinates are directions from the film point: T = (T_x, T_y), the first two components
//! of a ray's direction times the refractive index before the film. In these coordinates the light
//! of a pupil is uniform (its irradiance is radiance times area, at any angle), and the diffracted
//! amplitude is a plain Fourier transform (Hopkins 1953, "On the diffraction theory of optical
//! images").
//!
//! A pupil is a list of straight edges with the step of the amplitude across each, because the
//! Fourier transform of a polygon is a sum over its edges: exact at any distance, whereas that of a
//! grid of points fades into its own periodic copies.

mod amplitude_grid;
mod binary_outline;
mod pupil_view;
pub(crate) mod raster;

use std::f64::consts::{PI, TAU};

use petzval_base::sinc::sinc;

use crate::camera::RealLens;
use crate::prescription::iris::ApertureMask;
use pupil_view::PupilView;

/// A straight edge of a pupil, in the plane of T.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PupilEdge {
    /// Start point.
    pub from: [f64; 2],
    /// End point.
    pub to: [f64; 2],
    /// Amplitude on its left minus that on its right.
    pub step: f64,
}

impl PupilEdge {
    /// Returns the midpoint along a direction, and the extent along it and across it
    /// (counter-clockwise).
    fn along(&self, [cos, sin]: [f64; 2]) -> (f64, [f64; 2]) {
        let s = |[x, y]: [f64; 2]| x * cos + y * sin;
        let t = |[x, y]: [f64; 2]| y * cos - x * sin;
        let (from, to) = (s(self.from), s(self.to));
        ((from + to) / 2.0, [to - from, t(self.to) - t(self.from)])
    }
}

/// The amplitude that a film point sees through a lens, at the d line and without the losses of
/// surfaces, which are nearly uniform over a pupil.
#[derive(Clone, Debug)]
pub struct ExitPupil {
    /// All of its edges. They form closed outlines: the amplitude is 0 far away.
    pub edges: Vec<PupilEdge>,
    /// Integral of the squared amplitude.
    pub area: f64,
}

impl ExitPupil {
    /// Traces the pupil that a film point (mm, the film's frame) sees, over a grid; its outline is
    /// refined by bisection along the grid's lines. If an opening is a mask that draws no shape, amplitudes
    /// are the square roots of the transmittance, in cells of a grid. Takes some milliseconds.
    /// `None` if the film point is dark.
    pub fn trace(lens: &RealLens, film: [f64; 2]) -> Option<Self> {
        let masks = lens.prescription.rows.iter().filter_map(|row| row.iris.mask());
        let partial = masks.clone().any(|mask| !mask.is_shape);
        if partial {
            let mut view = PupilView::new(lens, &lens.prescription, film);
            let pupil_box = view.pupil_box(lens)?;
            return amplitude_grid::trace(&mut view, pupil_box);
        }
        // The edge of a shape is where half of its light passes, between the centres of pixels.
        let open: Option<f32> = masks.map(ApertureMask::largest).reduce(|a, b| a * b);
        let level = open.map_or(0.0, |open| 0.5 * open);
        let mut smooth = lens.prescription.clone();
        for row in &mut smooth.rows {
            row.iris = row.iris.smooth();
        }
        let mut view = PupilView::new(lens, &smooth, film);
        let pupil_box = view.pupil_box(lens)?;
        binary_outline::trace(&mut view, pupil_box, level)
    }

    /// Returns a polygonal pupil of amplitude 1; the corners are counter-clockwise.
    pub fn polygon(corners: &[[f64; 2]]) -> Self {
        let next = |i: usize| corners[(i + 1) % corners.len()];
        let edge = |(i, &from): (usize, &[f64; 2])| PupilEdge { from, to: next(i), step: 1.0 };
        let edges: Vec<PupilEdge> = corners.iter().enumerate().map(edge).collect();
        Self { area: amplitude_integral(&edges), edges }
    }

    /// Returns the centre of the box around its edges.
    pub fn centre(&self) -> [f64; 2] {
        let [low, high] = self.bounds();
        [0, 1].map(|i| (low[i] + high[i]) / 2.0)
    }

    /// Returns the box around its edges.
    fn bounds(&self) -> [[f64; 2]; 2] {
        let start = [[f64::INFINITY; 2], [f64::NEG_INFINITY; 2]];
        self.edges.iter().flat_map(|edge| [edge.from, edge.to]).fold(start, |[low, high], at| {
            [[0, 1].map(|i| low[i].min(at[i])), [0, 1].map(|i| high[i].max(at[i]))]
        })
    }

    /// Returns its width along a direction of this angle from +x.
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

    /// Returns the sine (times the index) of the half angle of a round pupil of this area: 1 / (2
    /// N) for the working f-number N.
    pub fn numerical_aperture(&self) -> f64 {
        (self.area / PI).sqrt()
    }

    /// Returns the radius of the Airy disc to its first zero for a wavelength, in the wavelength's
    /// unit: 0.61 lambda / sine (Airy 1835), for a round pupil of this area.
    pub fn airy_radius(&self, wavelength: f64) -> f64 {
        FIRST_ZERO / TAU * wavelength / self.numerical_aperture()
    }

    /// Returns the density of a point's light per area, at an offset from it on the film, for light
    /// of a wavelength; all in the same unit of length: |F(offset / wavelength)|^2 / (wavelength^2
    /// area), F the Fourier transform of the amplitude (Born & Wolf, 8.3). Its integral is 1.
    ///
    /// The wavefront is flat: rays carry the effects of aberrations and defocus.
    pub fn density(&self, offset: [f64; 2], wavelength: f64) -> f64 {
        let [re, im] = self.transform(offset.map(|v| v / wavelength));
        (re * re + im * im) / (wavelength * wavelength * self.area)
    }

    /// Returns the Fourier transform of the amplitude about its centre, real and imaginary part:
    /// the integral of amplitude times exp(-2 pi i k.T), by Green's theorem a sum over edges (Lee &
    /// Mittra 1983, "Fourier transform of a polygonal shape function").
    fn transform(&self, [kx, ky]: [f64; 2]) -> [f64; 2] {
        let k = kx.hypot(ky);
        let direction = if k > 0.0 { [kx / k, ky / k] } else { [1.0, 0.0] };
        let [x, y] = self.centre();
        let origin = x * direction[0] + y * direction[1];
        // The phase is then constant over the pupil.
        if k * self.area.sqrt() < 1e-6 {
            return [amplitude_integral(&self.edges), 0.0];
        }
        let mut sum = [0.0; 2];
        for edge in &self.edges {
            let (middle, [across, along]) = edge.along(direction);
            let weight = edge.step * along * sinc(k * across);
            let (sin, cos) = (TAU * k * (middle - origin)).sin_cos();
            sum = [sum[0] + weight * cos, sum[1] - weight * sin];
        }
        // Multiplied by i / (2 pi k).
        [-sum[1] / (TAU * k), sum[0] / (TAU * k)]
    }
}

/// The first zero of the Bessel function J_1.
const FIRST_ZERO: f64 = 3.831_705_970_207_512;

/// Returns the integral of the amplitude.
fn amplitude_integral(edges: &[PupilEdge]) -> f64 {
    let one =
        |PupilEdge { from, to, step }: &PupilEdge| step * (from[0] * to[1] - from[1] * to[0]) / 2.0;
    edges.iter().map(one).sum()
}
