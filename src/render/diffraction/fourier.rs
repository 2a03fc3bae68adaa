//! Fourier transforms of real data in one and two dimensions. No other file uses `rustfft` or
//! `realfft`.
//!
//! In f64: a light source is a million times brighter than the night around it, and f32 would
//! spread its rounding error evenly over the picture.

use std::sync::Arc;

use rayon::prelude::*;
use realfft::{ComplexToReal, RealFftPlanner, RealToComplex};
use rustfft::{Fft, FftPlanner};

pub(super) use realfft::num_complex::Complex;

/// The Fourier transform of a line of real numbers.
pub(super) struct LineFft(Arc<dyn RealToComplex<f64>>);

/// Buffers of a [`LineFft`].
pub(super) struct LineFftScratch {
    /// The input. The transform overwrites it.
    pub numbers: Vec<f64>,
    /// The transform, from frequency 0 to half the number of inputs.
    pub spectrum: Vec<Complex<f64>>,
    scratch: Vec<Complex<f64>>,
}

impl LineFft {
    /// Plans the transform of `len` numbers; `len` is even.
    pub fn new(len: usize) -> Self {
        Self(RealFftPlanner::new().plan_fft_forward(len))
    }

    pub fn scratch(&self) -> LineFftScratch {
        LineFftScratch {
            numbers: self.0.make_input_vec(),
            spectrum: self.0.make_output_vec(),
            scratch: self.0.make_scratch_vec(),
        }
    }

    /// Transforms `numbers` into `spectrum`.
    pub fn transform(&self, LineFftScratch { numbers, spectrum, scratch }: &mut LineFftScratch) {
        let lengths_fit = self.0.process_with_scratch(numbers, spectrum, scratch);
        debug_assert!(lengths_fit.is_ok());
    }
}

/// Columns or rows that are transposed together: a cache line of numbers.
const GROUP: usize = 8;

/// The Fourier transform of a plane of real numbers. The plane is larger than its content: light
/// that is spread beyond one side must not reappear at the opposite one.
pub(super) struct PlaneFft {
    pub size: [usize; 2],
    rows: Arc<dyn RealToComplex<f64>>,
    inverse_rows_plan: Arc<dyn ComplexToReal<f64>>,
    columns: [Arc<dyn Fft<f64>>; 2],
}

/// The transform of a plane, column by column, each from the top.
pub(super) type PlaneSpectrum = Vec<Complex<f64>>;

impl PlaneFft {
    /// Plans the transform of a plane of at least this width and height.
    pub fn new(least: [usize; 2]) -> Self {
        let size = [2 * next_smooth(least[0].div_ceil(2)), next_smooth(least[1])];
        let (mut real, mut complex) = (RealFftPlanner::new(), FftPlanner::new());
        Self {
            size,
            rows: real.plan_fft_forward(size[0]),
            inverse_rows_plan: real.plan_fft_inverse(size[0]),
            columns: [complex.plan_fft_forward(size[1]), complex.plan_fft_inverse(size[1])],
        }
    }

    /// Returns the transform of a plane. `fill` writes it row by row into rows of zeros, and
    /// returns whether it wrote anything.
    pub fn spectrum(&self, fill: impl Fn(usize, &mut [f64]) -> bool + Sync) -> PlaneSpectrum {
        let [width, height] = self.size;
        let across = width / 2 + 1;
        let mut lines = vec![Complex::default(); across * height];
        let buffers = || (self.rows.make_input_vec(), self.rows.make_scratch_vec());
        lines.par_chunks_mut(across).enumerate().for_each_init(
            buffers,
            |(row, scratch), (y, line)| {
                row.fill(0.0);
                if fill(y, row) {
                    let lengths_fit = self.rows.process_with_scratch(row, line, scratch);
                    debug_assert!(lengths_fit.is_ok());
                }
            },
        );
        let mut spectrum = vec![Complex::default(); across * height];
        let fft = &self.columns[0];
        let scratch = || vec![Complex::default(); fft.get_inplace_scratch_len()];
        spectrum.par_chunks_mut(GROUP * height).enumerate().for_each_init(
            scratch,
            |scratch, (group, columns)| {
                let (first, count) = (group * GROUP, columns.len() / height);
                for y in 0..height {
                    let from = &lines[y * across + first..][..count];
                    for (column, &value) in from.iter().enumerate() {
                        columns[column * height + y] = value;
                    }
                }
                for column in columns.chunks_exact_mut(height) {
                    fft.process_with_scratch(column, scratch);
                }
            },
        );
        spectrum
    }

    /// Transforms a spectrum back and passes the first rows of the plane to `take`, which writes
    /// each of them into one chunk of `into`, `chunk` elements long.
    pub fn inverse_rows<T: Send>(
        &self,
        mut spectrum: PlaneSpectrum,
        into: &mut [T],
        chunk: usize,
        take: impl Fn(&[f64], &mut [T]) + Sync,
    ) {
        let [width, height] = self.size;
        let across = width / 2 + 1;
        let fft = &self.columns[1];
        let scratch = || vec![Complex::default(); fft.get_inplace_scratch_len()];
        spectrum
            .par_chunks_mut(height)
            .for_each_init(scratch, |scratch, column| fft.process_with_scratch(column, scratch));
        let scale = 1.0 / (width * height) as f64;
        let buffers = || {
            let lines = vec![Complex::default(); GROUP * across];
            (
                lines,
                self.inverse_rows_plan.make_output_vec(),
                self.inverse_rows_plan.make_scratch_vec(),
            )
        };
        into.par_chunks_mut(GROUP * chunk).enumerate().for_each_init(
            buffers,
            |(lines, row, scratch), (group, into)| {
                let (first, count) = (group * GROUP, into.len() / chunk);
                for column in 0..across {
                    let from = &spectrum[column * height + first..][..count];
                    for (y, value) in from.iter().enumerate() {
                        lines[y * across + column] = value * scale;
                    }
                }
                let lines = lines.chunks_exact_mut(across);
                for (line, into) in lines.zip(into.chunks_exact_mut(chunk)) {
                    // The plane is real: these are 0 but for rounding.
                    (line[0].im, line[across - 1].im) = (0.0, 0.0);
                    let lengths_fit =
                        self.inverse_rows_plan.process_with_scratch(line, row, scratch);
                    debug_assert!(lengths_fit.is_ok());
                    take(row, into);
                }
            },
        );
    }
}

/// Returns the next number without prime factors above 5: transforms of such lengths are fast.
fn next_smooth(least: usize) -> usize {
    let is_smooth = |&n: &usize| {
        let mut rest = n;
        for prime in [2, 3, 5] {
            while rest.is_multiple_of(prime) {
                rest /= prime;
            }
        }
        rest == 1
    };
    (least.max(1)..).find(is_smooth).unwrap_or(least)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_inverse_transform_restores_the_plane() {
        let plane = PlaneFft::new([13, 7]);
        assert_eq!(plane.size, [16, 8]);
        let value = |x: usize, y: usize| ((x * 7 + y * 13) % 11) as f64 - 3.0;
        let spectrum = plane.spectrum(|y, row| {
            row[..13].iter_mut().enumerate().for_each(|(x, v)| *v = value(x, y));
            y < 7
        });
        let mut found = vec![0.0; 7 * 16];
        plane.inverse_rows(spectrum, &mut found, 16, |row, into| into.copy_from_slice(row));
        for (i, found) in found.into_iter().enumerate() {
            let (x, y) = (i % 16, i / 16);
            let expected = if x < 13 { value(x, y) } else { 0.0 };
            assert!((found - expected).abs() < 1e-12, "{x}, {y}: {found}");
        }
    }

    #[test]
    fn lengths_are_products_of_small_primes() {
        assert_eq!([1, 7, 11, 97, 1201, 4097].map(next_smooth), [1, 8, 12, 100, 1215, 4320]);
    }
}
