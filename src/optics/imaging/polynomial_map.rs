//! Polynomial map of the plane, fitted to pairs of points.

use petzval_base::least_squares::least_squares;

/// Highest degree.
pub(super) const HIGHEST: usize = 7;

/// A polynomial of two variables for each of two coordinates.
#[derive(Clone, Debug)]
pub(super) struct PolynomialMap {
    degree: usize,
    centre: [f64; 2],
    scale: f64,
    coefficients: [Vec<f64>; 2],
}

impl PolynomialMap {
    /// Fits polynomials of the highest degree that the number of pairs of arguments and values
    /// allows. `None` for fewer than six pairs.
    pub(super) fn fit(pairs: &[([f64; 2], [f64; 2])]) -> Option<Self> {
        let terms = |degree: usize| (degree + 1) * (degree + 2) / 2;
        let degree = (1..=HIGHEST).rev().find(|&degree| 2 * terms(degree) <= pairs.len())?;
        let count = pairs.len() as f64;
        let centre = [0, 1].map(|i| pairs.iter().map(|(at, _)| at[i]).sum::<f64>() / count);
        let scale = pairs
            .iter()
            .map(|(at, _)| (at[0] - centre[0]).abs().max((at[1] - centre[1]).abs()))
            .fold(0.0, f64::max);
        let scaled: Vec<[f64; 2]> =
            pairs.iter().map(|(at, _)| [0, 1].map(|i| (at[i] - centre[i]) / scale)).collect();
        let columns = exponents(degree)
            .map(|[i, j]| scaled.iter().map(|[x, y]| x.powi(i) * y.powi(j)).collect())
            .collect();
        let sides = [0, 1].map(|i| pairs.iter().map(|(_, value)| value[i]).collect()).to_vec();
        let mut solutions = least_squares(columns, sides).into_iter();
        Some(Self { degree, centre, scale, coefficients: [solutions.next()?, solutions.next()?] })
    }

    /// Returns the value at a point.
    pub(super) fn value(&self, at: [f64; 2]) -> [f64; 2] {
        let [x, y] = self.powers(at);
        let mut value = [0.0; 2];
        for (k, [i, j]) in exponents(self.degree).enumerate() {
            let term = x[i as usize] * y[j as usize];
            value[0] += self.coefficients[0][k] * term;
            value[1] += self.coefficients[1][k] * term;
        }
        value
    }

    /// Returns the value at a point, and the determinant of the Jacobian.
    pub(super) fn evaluate(&self, at: [f64; 2]) -> ([f64; 2], f64) {
        let [x, y] = self.powers(at);
        let mut slopes = [[0.0; 2]; 2];
        for (k, [i, j]) in exponents(self.degree).enumerate() {
            let (i, j) = (i as usize, j as usize);
            let by_x = if i == 0 { 0.0 } else { i as f64 * x[i - 1] * y[j] };
            let by_y = if j == 0 { 0.0 } else { j as f64 * x[i] * y[j - 1] };
            for (slope, coefficients) in slopes.iter_mut().zip(&self.coefficients) {
                slope[0] += coefficients[k] * by_x;
                slope[1] += coefficients[k] * by_y;
            }
        }
        let determinant = slopes[0][0] * slopes[1][1] - slopes[0][1] * slopes[1][0];
        (self.value(at), determinant / (self.scale * self.scale))
    }

    /// Returns the powers of the scaled coordinates.
    fn powers(&self, at: [f64; 2]) -> [[f64; HIGHEST + 1]; 2] {
        [0, 1].map(|i| {
            let x = (at[i] - self.centre[i]) / self.scale;
            let mut powers = [1.0; HIGHEST + 1];
            for k in 1..=HIGHEST {
                powers[k] = powers[k - 1] * x;
            }
            powers
        })
    }
}

/// Returns the exponents of x and y of all terms up to a degree.
fn exponents(degree: usize) -> impl Iterator<Item = [i32; 2]> {
    (0..=degree as i32).flat_map(|sum| (0..=sum).map(move |j| [sum - j, j]))
}
