//! Point spread function by diffraction, and encircled energy.
//!
//! The field at a point r of the film is the sum of the plane waves of the pupil,
//! U(r) = sum over T of A(T) exp(i k (phase(T) + T . (r - r_0))): Debye's integral with the traced
//! wavefront in place of a perfect one. On regular grids it is a product of three matrices
//! (Soummer et al. 2007), for any pitch of the image.

use std::f64::consts::TAU;

use super::image_quality::FieldRays;
use super::pupil_grid::PupilGrid;

/// Samples along each side of the finer grid around the brightest sample.
const PEAK_SIDE: usize = 17;
/// Number of its samples per sample of the image.
const PEAK_PITCH: f64 = 8.0;

/// Image of a point.
#[derive(Clone, Debug, PartialEq)]
pub struct PointImage {
    /// Samples along each side.
    pub side: usize,
    /// Distance of neighbouring samples (mm).
    pub pitch: f64,
    /// Middle of the image relative to the reference point (mm).
    pub centre: [f64; 2],
    /// Irradiance, row by row along x: share of the light per sample.
    pub values: Vec<f64>,
    /// Largest irradiance relative to that of the same pupil with a perfect wavefront.
    pub strehl: f64,
}

impl FieldRays {
    /// Returns the largest width of an image that the grids resolve (mm): a wavelength over the
    /// step in T. Beyond it the image repeats.
    pub fn resolved_width(&self) -> f64 {
        self.open_grids().map(|grid| grid.nm * 1e-6 / grid.step).fold(f64::INFINITY, f64::min)
    }

    /// Returns the image of a point in the light of all wavelengths, `width` mm wide around the
    /// centroid of the spot; `None` without light.
    pub fn point_image(&self, side: usize, width: f64) -> Option<PointImage> {
        let centre = self.spot().size(0.0, None)?.centroid;
        let pitch = width / side as f64;
        let values = self.irradiance(side, pitch, centre);
        let (brightest, _) = values.iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1))?;
        // The peak lies between samples.
        let place = |i: usize, k: usize| centre[k] + pitch * (i as f64 - (side as f64 - 1.0) / 2.0);
        let peak = [place(brightest % side, 0), place(brightest / side, 1)];
        let fine = self.irradiance(PEAK_SIDE, pitch / PEAK_PITCH, peak);
        let peak = fine.into_iter().fold(0.0, f64::max) * PEAK_PITCH * PEAK_PITCH;
        let whole: f64 = self.open_grids().map(PupilGrid::light_of_all).sum();
        let perfect: f64 = self
            .open_grids()
            .map(|grid| {
                grid.light_of_all() / whole * grid.light_per_sample(pitch) * grid.perfect_peak()
            })
            .sum();
        Some(PointImage { side, pitch, centre, values, strehl: peak / perfect })
    }

    /// Returns the irradiance on a grid of the film around `centre` (mm from the reference point):
    /// share of the light per sample.
    fn irradiance(&self, side: usize, pitch: f64, centre: [f64; 2]) -> Vec<f64> {
        let whole: f64 = self.open_grids().map(PupilGrid::light_of_all).sum();
        let mut values = vec![0.0; side * side];
        for grid in self.open_grids() {
            let scale = grid.light_of_all() / whole * grid.light_per_sample(pitch);
            for (value, u) in values.iter_mut().zip(grid.field(side, pitch, centre)) {
                *value += scale * (u[0] * u[0] + u[1] * u[1]);
            }
        }
        values
    }
}

impl PupilGrid {
    /// Returns the amplitudes of the cells, with their phases, for a light of 1. A cell that passes
    /// in part sends the rest of its light beyond the period of the image.
    fn amplitudes(&self) -> impl Iterator<Item = (usize, f64, f64)> {
        let energy: f64 = self.open().map(|(_, cell)| Self::light(cell)).sum();
        self.open()
            .map(move |(i, cell)| (i, cell.share * (cell.density / energy).sqrt(), cell.phase))
    }

    /// Returns the light of a sample of unit irradiance. By Parseval's theorem the light of a whole
    /// period of the image is that of the pupil.
    fn light_per_sample(&self, pitch: f64) -> f64 {
        (self.step * pitch / (self.nm * 1e-6)).powi(2)
    }

    /// Returns the irradiance at the middle of the image of a perfect wavefront.
    fn perfect_peak(&self) -> f64 {
        self.amplitudes().map(|(_, amplitude, _)| amplitude).sum::<f64>().powi(2)
    }

    /// Returns the complex amplitudes on a grid of the film around `centre` (mm from the reference
    /// point), row by row along x.
    fn field(&self, side: usize, pitch: f64, centre: [f64; 2]) -> Vec<[f64; 2]> {
        let wave_number = TAU / (self.nm * 1e-6);
        let n = self.side;
        let mut pupil = vec![[0.0; 2]; n * n];
        for (i, amplitude, phase) in self.amplitudes() {
            let (sin, cos) = (wave_number * phase).sin_cos();
            pupil[i] = [amplitude * cos, amplitude * sin];
        }
        // exp(i k T r) for every pair of a cell and a sample, along each axis.
        let kernel = |axis: usize| -> Vec<[f64; 2]> {
            (0..side * n)
                .map(|i| {
                    let r = centre[axis] + pitch * ((i / n) as f64 - (side as f64 - 1.0) / 2.0);
                    let t = self.first[axis] + self.step * (i % n) as f64;
                    let (sin, cos) = (wave_number * t * r).sin_cos();
                    [cos, sin]
                })
                .collect()
        };
        let (by_x, by_y) = (kernel(0), kernel(1));
        let product =
            |a: [f64; 2], b: [f64; 2]| [a[0] * b[0] - a[1] * b[1], a[0] * b[1] + a[1] * b[0]];
        let inner = |a: &[[f64; 2]], b: &[[f64; 2]]| {
            let mut sum = [0.0; 2];
            for (a, b) in a.iter().zip(b) {
                let term = product(*a, *b);
                sum = [sum[0] + term[0], sum[1] + term[1]];
            }
            sum
        };
        // Rows of cells against samples along x, then columns against samples along y.
        let mut half = vec![[0.0; 2]; side * n];
        for row in 0..n {
            let cells = &pupil[row * n..(row + 1) * n];
            for x in 0..side {
                half[x * n + row] = inner(cells, &by_x[x * n..(x + 1) * n]);
            }
        }
        let mut field = Vec::with_capacity(side * side);
        for y in 0..side {
            for x in 0..side {
                field.push(inner(&half[x * n..(x + 1) * n], &by_y[y * n..(y + 1) * n]));
            }
        }
        field
    }
}

impl PointImage {
    /// Returns the share of the light within circles around the centroid, with their radii (mm).
    pub fn encircled_energy(&self, count: usize) -> Vec<(f64, f64)> {
        let middle = (self.side as f64 - 1.0) / 2.0;
        let reach = self.pitch * self.side as f64 / 2.0;
        // Samples are spread over their square, so that small circles are smooth.
        let sub = 5;
        let part = |i: usize| (i as f64 + 0.5) / sub as f64 - 0.5;
        let mut rings = vec![0.0; count];
        for (i, value) in self.values.iter().enumerate() {
            let at = [(i % self.side) as f64 - middle, (i / self.side) as f64 - middle];
            for k in 0..sub * sub {
                let radius = (at[0] + part(k % sub)).hypot(at[1] + part(k / sub)) * self.pitch;
                let ring = (radius / reach * count as f64) as usize;
                if let Some(ring) = rings.get_mut(ring) {
                    *ring += value / (sub * sub) as f64;
                }
            }
        }
        let mut sum = 0.0;
        let radius = |i: usize| reach * (i as f64 + 1.0) / count as f64;
        rings
            .iter()
            .enumerate()
            .map(|(i, ring)| {
                sum += ring;
                (radius(i), sum)
            })
            .collect()
    }
}
