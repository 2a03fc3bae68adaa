//! Fourier transforms of real data in one and two dimensions. No other file uses `rustfft` or
//! `realfft`.
//!
//! Light that is spread near is transformed in f64: a light source is a million times brighter than the night
//! around it, and in f32 its rounding error, 1e-8 of it, is spread over its row. Light that is spread far is a
//! thousandth, without a peak, and so is its error in f32.

use std::sync::Arc;

use rayon::prelude::*;
use realfft::{ComplexToReal, FftNum, RealFftPlanner, RealToComplex};
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
pub(super) struct PlaneFft<T> {
    pub size: [usize; 2],
    rows: Arc<dyn RealToComplex<T>>,
    inverse_rows: Arc<dyn ComplexToReal<T>>,
    columns: [Arc<dyn Fft<T>>; 2],
    symmetric_columns: Arc<dyn ComplexToReal<T>>,
}

/// The transform of a plane, column by column, each from the top.
pub(super) type PlaneSpectrum<T> = Vec<Complex<T>>;

impl<T: FftNum + Default> PlaneFft<T> {
    /// Plans the transform of a plane of at least this width and height.
    pub fn new(least: [usize; 2]) -> Self {
        let size = [2 * next_smooth(least[0].div_ceil(2)), next_smooth(least[1])];
        let (mut real, mut complex) = (RealFftPlanner::new(), FftPlanner::new());
        Self {
            size,
            rows: real.plan_fft_forward(size[0]),
            inverse_rows: real.plan_fft_inverse(size[0]),
            columns: [complex.plan_fft_forward(size[1]), complex.plan_fft_inverse(size[1])],
            symmetric_columns: real.plan_fft_inverse(size[1]),
        }
    }

    /// Returns the number of frequencies along a row.
    fn across(&self) -> usize {
        self.size[0] / 2 + 1
    }

    /// Returns the transforms of the first rows of a plane. `fill` writes each into a row of zeros, and
    /// returns whether it wrote anything.
    fn row_spectra(
        &self,
        rows: usize,
        fill: impl Fn(usize, &mut [T]) -> bool + Sync,
    ) -> Vec<Complex<T>> {
        let across = self.across();
        let mut lines = vec![Complex::default(); across * rows];
        let buffers = || (self.rows.make_input_vec(), self.rows.make_scratch_vec());
        lines.par_chunks_mut(across).enumerate().for_each_init(
            buffers,
            |(row, scratch), (y, line)| {
                row.fill(T::zero());
                if fill(y, row) {
                    let lengths_fit = self.rows.process_with_scratch(row, line, scratch);
                    debug_assert!(lengths_fit.is_ok());
                }
            },
        );
        lines
    }

    /// Returns the transform of a plane. `fill` writes its first rows, the others are 0: each into a row
    /// of zeros. It returns whether it wrote anything.
    pub fn spectrum(
        &self,
        rows: usize,
        fill: impl Fn(usize, &mut [T]) -> bool + Sync,
    ) -> PlaneSpectrum<T> {
        let (across, height) = (self.across(), self.size[1]);
        let lines = self.row_spectra(rows, fill);
        let mut spectrum = vec![Complex::default(); across * height];
        let fft = &self.columns[0];
        let scratch = || vec![Complex::default(); fft.get_inplace_scratch_len()];
        spectrum.par_chunks_mut(GROUP * height).enumerate().for_each_init(
            scratch,
            |scratch, (group, columns)| {
                let (first, count) = (group * GROUP, columns.len() / height);
                for y in 0..rows {
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

    /// Returns the transform of a plane that is the same if it is rotated by 180 degrees about its first
    /// point, where negative offsets are wrapped around: real numbers in the order of
    /// [`PlaneSpectrum`]. `fill` writes the row of that point and those behind it.
    pub fn symmetric_spectrum(
        &self,
        rows: usize,
        fill: impl Fn(usize, &mut [T]) -> bool + Sync,
    ) -> Vec<T> {
        let (across, height) = (self.across(), self.size[1]);
        let lines = self.row_spectra(rows, fill);
        let mut spectrum = vec![T::zero(); across * height];
        let fft = &self.symmetric_columns;
        let half = height / 2 + 1;
        let buffers = || (vec![Complex::default(); GROUP * half], fft.make_scratch_vec());
        spectrum.par_chunks_mut(GROUP * height).enumerate().for_each_init(
            buffers,
            |(lines_of_columns, scratch), (group, columns)| {
                let (first, count) = (group * GROUP, columns.len() / height);
                lines_of_columns.fill(Complex::default());
                for y in 0..rows.min(half) {
                    let from = &lines[y * across + first..][..count];
                    for (column, value) in from.iter().enumerate() {
                        lines_of_columns[column * half + y] = value.conj();
                    }
                }
                let halves = lines_of_columns.chunks_exact_mut(half);
                for (line, column) in halves.zip(columns.chunks_exact_mut(height)) {
                    // Real by symmetry, but for rounding.
                    line[0].im = T::zero();
                    if height.is_multiple_of(2) {
                        line[half - 1].im = T::zero();
                    }
                    let lengths_fit = fft.process_with_scratch(line, column, scratch);
                    debug_assert!(lengths_fit.is_ok());
                }
            },
        );
        spectrum
    }

    /// Transforms a spectrum back and passes the first rows of the plane to `take`, which writes
    /// each of them into one chunk of `into`, `chunk` elements long.
    pub fn inverse_rows<V: Send>(
        &self,
        mut spectrum: PlaneSpectrum<T>,
        into: &mut [V],
        chunk: usize,
        take: impl Fn(&[T], &mut [V]) + Sync,
    ) {
        let [width, height] = self.size;
        let across = self.across();
        let fft = &self.columns[1];
        let scratch = || vec![Complex::default(); fft.get_inplace_scratch_len()];
        spectrum
            .par_chunks_mut(height)
            .for_each_init(scratch, |scratch, column| fft.process_with_scratch(column, scratch));
        let scale = T::from_f64(1.0 / (width * height) as f64).unwrap_or_else(T::zero);
        let buffers = || {
            let lines = vec![Complex::default(); GROUP * across];
            (lines, self.inverse_rows.make_output_vec(), self.inverse_rows.make_scratch_vec())
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
                    (line[0].im, line[across - 1].im) = (T::zero(), T::zero());
                    let lengths_fit = self.inverse_rows.process_with_scratch(line, row, scratch);
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
    use rustfft::num_traits::ToPrimitive;

    fn restored<T: FftNum + Default + ToPrimitive>(tolerance: f64) {
        let plane = PlaneFft::<T>::new([13, 7]);
        assert_eq!(plane.size, [16, 8]);
        let value = |x: usize, y: usize| ((x * 7 + y * 13) % 11) as f64 - 3.0;
        let spectrum = plane.spectrum(7, |y, row| {
            let row = row[..13].iter_mut().enumerate();
            row.for_each(|(x, v)| *v = T::from_f64(value(x, y)).expect("a number"));
            true
        });
        let mut found = vec![T::zero(); 7 * 16];
        plane.inverse_rows(spectrum, &mut found, 16, |row, into| into.copy_from_slice(row));
        for (i, found) in found.into_iter().enumerate() {
            let (x, y) = (i % 16, i / 16);
            let expected = if x < 13 { value(x, y) } else { 0.0 };
            let found = found.to_f64().expect("a number");
            assert!((found - expected).abs() < tolerance, "{x}, {y}: {found}");
        }
    }

    #[test]
    fn the_inverse_transform_restores_the_plane() {
        restored::<f64>(1e-12);
        restored::<f32>(1e-5);
    }

    #[test]
    fn a_symmetric_plane_has_the_real_part_of_its_transform() {
        for least in [[14, 7], [17, 9], [20, 12], [30, 15]] {
            let plane = PlaneFft::<f64>::new(least);
            let [width, height] = plane.size;
            // Offsets of up to 5 columns and 3 rows, the same on both sides.
            let value = |dx: isize, dy: isize| match (dx.abs() <= 5, dy.abs() <= 3) {
                (true, true) => (0.3 * (3 * dx + 5 * dy) as f64).cos() + 0.1 * (dx * dy) as f64,
                _ => 0.0,
            };
            let fill = |dy: isize, row: &mut [f64]| {
                for dx in -5..=5isize {
                    row[dx.rem_euclid(width as isize) as usize] = value(dx, dy);
                }
                true
            };
            let whole = plane.spectrum(height, |y, row| {
                let dy = y as isize;
                fill(if dy <= 3 { dy } else { dy - height as isize }, row)
            });
            let half = plane.symmetric_spectrum(4, |y, row| fill(y as isize, row));
            for (whole, half) in whole.iter().zip(half) {
                let off = (whole - half).norm();
                assert!(off < 1e-12, "{:?}: {whole}, {half}", plane.size);
            }
        }
    }

    #[test]
    fn lengths_are_products_of_small_primes() {
        assert_eq!([1, 7, 11, 97, 1201, 4097].map(next_smooth), [1, 8, 12, 100, 1215, 4320]);
    }
}
