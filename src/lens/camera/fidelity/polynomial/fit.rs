//! Least-squares fit of polynomials to traced rays.

use super::Part;
use crate::trace::kernel::LensRay;
use crate::trace::polynomial::{Polynomial, general_terms, invariants, round_terms};
use petzval_base::least_squares::least_squares;

impl Part {
    /// Fits the polynomials that map rays `from` to rays `to`.
    pub fn fit(&self, from: &[LensRay<f64>], to: &[LensRay<f64>]) -> Polynomial<f64> {
        let crossed = |&LensRay { p: [x, y, z], t: [tx, ty, tz], .. }: &LensRay<f64>| {
            let s = (self.advance - z) / tz;
            [x + s * tx, y + s * ty, tx, ty]
        };
        let crossings: Vec<[f64; 4]> = from.iter().map(crossed).collect();
        let largest = |i: usize| {
            crossings
                .iter()
                .flat_map(|v| [v[i], v[i + 1]])
                .fold(f64::MIN_POSITIVE, |most, v| most.max(v.abs()))
        };
        let scale = [1.0 / largest(0), 1.0 / largest(2)];
        let scaled = crossings
            .into_iter()
            .map(|[x, y, tx, ty]| [x * scale[0], y * scale[0], tx * scale[1], ty * scale[1]]);
        let scaled: Vec<[f64; 4]> = scaled.collect();
        let of = |f: fn(&LensRay<f64>) -> f64| to.iter().map(f).collect::<Vec<f64>>();
        let sides = vec![
            of(|ray| ray.p[0]),
            of(|ray| ray.p[1]),
            of(|ray| ray.p[2]),
            of(|ray| ray.t[0]),
            of(|ray| ray.t[1]),
            of(|ray| ray.t[2]),
        ];
        let rows = match self.round {
            true => round_rows(&scaled, sides),
            false => least_squares(columns(&scaled, |v| general_terms::<f64>(v).to_vec()), sides),
        };
        Polynomial { round: self.round, scale, rows: rows.concat(), index: self.index }
    }
}

/// Returns the terms of all rays, one column for each term.
fn columns(rays: &[[f64; 4]], terms: impl Fn([f64; 4]) -> Vec<f64>) -> Vec<Vec<f64>> {
    let rows: Vec<Vec<f64>> = rays.iter().map(|&v| terms(v)).collect();
    let count = rows.first().map_or(0, Vec::len);
    (0..count).map(|k| rows.iter().map(|row| row[k]).collect()).collect()
}

/// Fits the rows of a round part; the x and y of vectors share their coefficients.
fn round_rows(rays: &[[f64; 4]], sides: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let terms = |v: [f64; 4]| round_terms::<f64>(invariants(v));
    let across = |axis: usize| {
        columns(rays, |v| {
            let times = |by: f64| terms(v).map(|term| term * by);
            [times(v[axis]), times(v[axis + 2])].concat()
        })
    };
    let both = |x: Vec<f64>, y: &[f64]| [&x, y].concat();
    let vectors: Vec<Vec<f64>> =
        across(0).into_iter().zip(across(1)).map(|(x, y)| both(x, &y)).collect();
    let [x, y, z, tx, ty, tz] = <[Vec<f64>; 6]>::try_from(sides).unwrap_or_default();
    let vectors = least_squares(vectors, vec![both(x, &y), both(tx, &ty)]);
    let along = least_squares(columns(rays, |v| terms(v).to_vec()), vec![z, tz]);
    // The solution of a vector holds the coefficients of a, then those of b.
    [vectors, along].concat()
}
