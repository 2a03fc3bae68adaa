//! Modulation transfer: by diffraction and by rays.
//!
//! The optical transfer function of an incoherent object is the autocorrelation of the pupil
//! function in T, at shifts of frequency times wavelength (Hopkins 1957). Pairs of cells give the
//! shifts by whole cells; the gradient of the phase, which is the transverse aberration, gives the
//! rest, so that it is also right for blur that the cells alone would undersample.

use std::f64::consts::TAU;

use super::image_quality::FieldRays;
use super::pupil_grid::PupilGrid;

/// Direction of the spatial frequency.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FrequencyAxis {
    /// Along x: the sagittal curve of a field along y.
    X,
    /// Along y: the tangential curve.
    Y,
}

/// Method by which a transfer function is computed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransferMethod {
    /// Diffraction by the wavefront of the real pupil.
    Diffraction,
    /// Fourier transform of the spot.
    Geometric,
    /// Diffraction by the real pupil with a perfect wavefront.
    Limit,
}

impl FieldRays {
    /// Returns the modulation of a sine pattern of a frequency (cycles / mm) in the light of all
    /// wavelengths, on a film that is moved back by `defocus` (mm); `None` without light.
    pub fn modulation(
        &self,
        frequency: f64,
        axis: FrequencyAxis,
        method: TransferMethod,
        defocus: f64,
    ) -> Option<f64> {
        self.modulations(&[frequency], axis, method, defocus).pop()?
    }

    /// Does the same for several frequencies.
    pub fn modulations(
        &self,
        frequencies: &[f64],
        axis: FrequencyAxis,
        method: TransferMethod,
        defocus: f64,
    ) -> Vec<Option<f64>> {
        let (mut sums, mut light) = (vec![[0.0; 2]; frequencies.len()], 0.0);
        for grid in self.open_grids() {
            let own = grid.light_of_all();
            let waves = PupilWaves::new(grid, axis, method, defocus);
            for (sum, frequency) in sums.iter_mut().zip(frequencies) {
                let value = waves.transfer(*frequency);
                *sum = [0, 1].map(|i| sum[i] + own * value[i]);
            }
            light += own;
        }
        let share = |sum: [f64; 2]| (light > 0.0).then(|| sum[0].hypot(sum[1]) / light);
        sums.into_iter().map(share).collect()
    }
}

/// Amplitude and phase of the cells of a grid, for one axis.
struct PupilWaves<'a> {
    grid: &'a PupilGrid,
    axis: FrequencyAxis,
    method: TransferMethod,
    /// Amplitude, phase (rad) and its change by a cell along the axis; amplitude 0 where no light
    /// passes.
    waves: Vec<[f64; 3]>,
    /// Light of all cells.
    light: f64,
}

impl<'a> PupilWaves<'a> {
    fn new(grid: &'a PupilGrid, axis: FrequencyAxis, method: TransferMethod, defocus: f64) -> Self {
        let along = axis as usize;
        let wave_number = TAU / (grid.nm * 1e-6);
        let mut waves = vec![[0.0; 3]; grid.cells.len()];
        let mut light = 0.0;
        for (i, cell) in grid.open() {
            light += PupilGrid::light(cell);
            // Moving the film back adds T_z times the distance; d T_z / d T = -T / T_z.
            let slope = grid.direction(i)[along] / cell.t_z;
            let phase = cell.phase + defocus * cell.t_z;
            let gradient = grid.reference[along] - cell.point[along] - defocus * slope;
            waves[i] = [
                cell.share * cell.density.sqrt(),
                wave_number * phase,
                wave_number * gradient * grid.step,
            ];
        }
        Self { grid, axis, method, waves, light }
    }

    /// Returns the optical transfer function (real and imaginary part), relative to the reference
    /// point.
    fn transfer(&self, frequency: f64) -> [f64; 2] {
        let shift = frequency * self.grid.nm * 1e-6 / self.grid.step;
        if self.method == TransferMethod::Geometric {
            return self.correlation(0, shift);
        }
        let whole = shift.floor();
        let part = shift - whole;
        let near = self.correlation(whole as usize, part);
        if part == 0.0 {
            return near;
        }
        let far = self.correlation(whole as usize + 1, part - 1.0);
        [0, 1].map(|i| (1.0 - part) * near[i] + part * far[i])
    }

    /// Correlates the pupil with itself at a shift of `whole` cells plus a rest (cells), which
    /// changes phases by their gradients.
    fn correlation(&self, whole: usize, rest: f64) -> [f64; 2] {
        let Self { grid, axis, .. } = self;
        let side = grid.side;
        let perfect = self.method == TransferMethod::Limit;
        let mut sum = [0.0; 2];
        for (i, cell) in grid.open() {
            // The partner must lie in the same row.
            let j = match axis {
                FrequencyAxis::X if i % side + whole < side => i + whole,
                FrequencyAxis::Y if i + whole * side < grid.cells.len() => i + whole * side,
                _ => continue,
            };
            let ([a, p, dp], [b, q, dq]) = (self.waves[i], self.waves[j]);
            if b == 0.0 {
                continue;
            }
            // A cell at the edge meets itself with its whole share.
            let amplitude = if whole == 0 { PupilGrid::light(cell) } else { a * b };
            if perfect {
                sum[0] += amplitude;
                continue;
            }
            let (sin, cos) = (q - p + rest * (dp + dq) / 2.0).sin_cos();
            sum = [sum[0] + amplitude * cos, sum[1] + amplitude * sin];
        }
        sum.map(|x| x / self.light)
    }
}
