//! Zernike polynomials of a wavefront, in Noll's order and normalization (Noll 1976).

use super::pupil_grid::PupilGrid;
use petzval_base::least_squares::least_squares;

/// Wavefront of a pupil as a sum of Zernike polynomials over the unit circle of the stop.
#[derive(Clone, Debug, PartialEq)]
pub struct ZernikeFit {
    /// Coefficients in wavelengths, from Noll's number 1 (piston) on. Each is the root mean square
    /// of its term over the full circle.
    pub coefficients: Vec<f64>,
    /// Root mean square of the wavefront without piston (wavelengths).
    pub rms: f64,
    /// Root mean square without piston and tilt (wavelengths).
    pub rms_without_tilt: f64,
    /// Largest minus smallest optical path difference (wavelengths).
    pub peak_to_valley: f64,
    /// Root mean square of what the terms leave (wavelengths).
    pub residual: f64,
}

/// Returns radial order n and azimuthal frequency m of a Noll number from 1; m is negative for the
/// terms with a sine.
pub fn noll(number: usize) -> [i32; 2] {
    let mut n = 0;
    let mut first = 1;
    while number > first + n {
        first += n + 1;
        n += 1;
    }
    let within = number - first;
    // Frequencies ascend, each but 0 twice; even numbers have the cosine.
    let m = if n % 2 == 0 { within.div_ceil(2) * 2 } else { within / 2 * 2 + 1 };
    let sign = if number.is_multiple_of(2) { 1 } else { -1 };
    [n as i32, m as i32 * if m == 0 { 1 } else { sign }]
}

/// Returns the value of a term at a point of the unit circle.
pub fn zernike(number: usize, [x, y]: [f64; 2]) -> f64 {
    let [n, m] = noll(number);
    let (r, angle) = (x.hypot(y), y.atan2(x));
    let k = m.abs();
    let factorial = |i: i32| (1..=i).map(f64::from).product::<f64>();
    let radial: f64 = (0..=(n - k) / 2)
        .map(|s| {
            let sign = if s % 2 == 0 { 1.0 } else { -1.0 };
            let below = factorial(s) * factorial((n + k) / 2 - s) * factorial((n - k) / 2 - s);
            sign * factorial(n - s) / below * r.powi(n - 2 * s)
        })
        .sum();
    let norm = f64::from(n + 1).sqrt() * if m == 0 { 1.0 } else { std::f64::consts::SQRT_2 };
    let turn = match m {
        0 => 1.0,
        m if m > 0 => (f64::from(m) * angle).cos(),
        m => (f64::from(-m) * angle).sin(),
    };
    norm * radial * turn
}

impl PupilGrid {
    /// Fits Zernike polynomials up to Noll's number `count` to the optical path difference.
    pub fn zernike(&self, count: usize) -> ZernikeFit {
        let wavelength = self.nm * 1e-6;
        let cells: Vec<([f64; 2], f64, f64)> = self
            .open()
            .map(|(_, cell)| (cell.stop, -cell.path_difference / wavelength, cell.share))
            .collect();
        let columns = |numbers: std::ops::RangeInclusive<usize>| {
            numbers
                .map(|number| {
                    cells.iter().map(|(at, _, share)| share.sqrt() * zernike(number, *at)).collect()
                })
                .collect::<Vec<Vec<f64>>>()
        };
        let side: Vec<f64> = cells.iter().map(|(_, waves, share)| share.sqrt() * waves).collect();
        let light: f64 = cells.iter().map(|(_, _, share)| share).sum();
        // Root mean square of what some terms leave.
        let left = |columns: Vec<Vec<f64>>| -> (Vec<f64>, f64) {
            let fit = least_squares(columns.clone(), vec![side.clone()]).pop().unwrap_or_default();
            let square: f64 = (0..side.len())
                .map(|i| {
                    let sum: f64 = columns.iter().zip(&fit).map(|(c, a)| a * c[i]).sum();
                    (side[i] - sum).powi(2)
                })
                .sum();
            (fit, (square / light).sqrt())
        };
        let (coefficients, residual) = left(columns(1..=count));
        let (_, rms) = left(columns(1..=1));
        let (_, rms_without_tilt) = left(columns(1..=3));
        let waves = || cells.iter().map(|(_, waves, _)| *waves);
        let peak_to_valley =
            waves().fold(f64::NEG_INFINITY, f64::max) - waves().fold(f64::INFINITY, f64::min);
        ZernikeFit { coefficients, rms, rms_without_tilt, peak_to_valley, residual }
    }
}
