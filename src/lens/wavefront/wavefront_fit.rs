//! Polynomial through the samples of a wavefront, with its gradient.

use crate::wavefront::path_difference::Wavefront;
use petzval_base::least_squares::least_squares;

/// Highest degree of a term. Aspheres of phone lenses need terms of degree 12 and more.
const HIGHEST: usize = 14;

/// Path differences over a pupil as a sum of products of Chebyshev polynomials, which stay
/// independent up to high degrees.
#[derive(Clone, Debug)]
pub struct WavefrontFit {
    degree: usize,
    /// Centre and half widths of the box around the samples.
    centre: [f64; 2],
    half: [f64; 2],
    coefficients: Vec<f64>,
}

impl WavefrontFit {
    /// Fits the samples by least squares, with at least two of them per coefficient. `None` for
    /// fewer than twelve samples, or if they lie on a line.
    pub fn new(wavefront: &Wavefront) -> Option<Self> {
        let points = &wavefront.points;
        let terms = |degree: usize| (degree + 1) * (degree + 2) / 2;
        let degree = (2..=HIGHEST).rev().find(|&degree| 2 * terms(degree) <= points.len())?;
        let extent = [0, 1].map(|i| {
            let along = points.iter().map(|point| point.pupil[i]);
            [along.clone().fold(f64::INFINITY, f64::min), along.fold(f64::NEG_INFINITY, f64::max)]
        });
        let centre = extent.map(|[low, high]| (low + high) / 2.0);
        let half = extent.map(|[low, high]| (high - low) / 2.0);
        if half.iter().any(|&half| half.is_nan() || half <= 0.0) {
            return None;
        }
        let mut fit = Self { degree, centre, half, coefficients: Vec::new() };
        let mut columns = vec![Vec::with_capacity(points.len()); terms(degree)];
        for point in points {
            let [x, y] = fit.values(point.pupil);
            for (column, [i, j]) in columns.iter_mut().zip(exponents(degree)) {
                column.push(x[i].0 * y[j].0);
            }
        }
        let paths = points.iter().map(|point| point.path_difference).collect();
        fit.coefficients = least_squares(columns, vec![paths]).pop()?;
        Some(fit)
    }

    /// Returns the path difference (mm) at a point of the pupil, and its gradient (mm), which is
    /// the place on the film of the ray through that point.
    pub fn at(&self, pupil: [f64; 2]) -> (f64, [f64; 2]) {
        let [x, y] = self.values(pupil);
        let (mut path, mut gradient) = (0.0, [0.0; 2]);
        for (coefficient, [i, j]) in self.coefficients.iter().zip(exponents(self.degree)) {
            path += coefficient * x[i].0 * y[j].0;
            gradient[0] += coefficient * x[i].1 * y[j].0;
            gradient[1] += coefficient * x[i].0 * y[j].1;
        }
        (path, [0, 1].map(|i| gradient[i] / self.half[i]))
    }

    /// Returns the Chebyshev polynomials and their derivatives along both axes, in the box of the
    /// samples; outside it, those at its edge.
    fn values(&self, pupil: [f64; 2]) -> [[(f64, f64); HIGHEST + 1]; 2] {
        [0, 1].map(|axis| {
            let x = ((pupil[axis] - self.centre[axis]) / self.half[axis]).clamp(-1.0, 1.0);
            let mut values = [(1.0, 0.0); HIGHEST + 1];
            values[1] = (x, 1.0);
            for k in 2..=HIGHEST {
                let (a, b) = (values[k - 1], values[k - 2]);
                values[k] = (2.0 * x * a.0 - b.0, 2.0 * a.0 + 2.0 * x * a.1 - b.1);
            }
            values
        })
    }
}

/// Returns the degrees in x and y of all terms up to a total degree.
fn exponents(degree: usize) -> impl Iterator<Item = [usize; 2]> {
    (0..=degree).flat_map(|sum| (0..=sum).map(move |j| [sum - j, j]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::wavefront::path_difference::WavefrontPoint;

    #[test]
    fn a_polynomial_and_its_gradient_are_recovered_over_a_round_pupil() {
        let path = |x: f64, y: f64| 3e-3 * x.powi(4) * y.powi(2) - 2e-3 * y.powi(3) + 1e-3 * x;
        let steps = (0..48 * 48).map(|i| [i % 48, i / 48].map(|k| (k as f64 - 23.5) / 24.0));
        let points = steps.filter(|[x, y]| x.hypot(*y) < 1.0).map(|[x, y]| WavefrontPoint {
            pupil: [0.1 + 0.2 * x, 0.3 * y],
            path_difference: path(x, y),
        });
        let fit = WavefrontFit::new(&Wavefront { points: points.collect(), rms: 1.0 }).unwrap();
        let (x, y) = (0.4, -0.7);
        let (found, gradient) = fit.at([0.1 + 0.2 * x, 0.3 * y]);
        assert!((found - path(x, y)).abs() < 1e-12, "{found}");
        let expected = [
            (12e-3 * x.powi(3) * y.powi(2) + 1e-3) / 0.2,
            (6e-3 * x.powi(4) * y - 6e-3 * y * y) / 0.3,
        ];
        for (found, expected) in gradient.into_iter().zip(expected) {
            assert!((found - expected).abs() < 1e-10, "{found} {expected}");
        }
    }
}
