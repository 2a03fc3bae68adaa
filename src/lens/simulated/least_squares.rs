//! Linear least squares.

/// What of a column is left when those before it are taken out, if it is nothing new.
const NOTHING: f64 = 1e-9;

/// For each right side the numbers whose products with the columns come nearest to it. Columns and
/// sides are of the same length; a column that is a sum of others gets 0. By Gram-Schmidt with the
/// sides as further columns, which is as exact as reflections (Björck 1967).
pub(super) fn least_squares(mut columns: Vec<Vec<f64>>, mut sides: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let count = columns.len();
    let mut upper = vec![vec![0.0; count]; count];
    let mut projected = vec![vec![0.0; count]; sides.len()];
    for k in 0..count {
        let whole: f64 = upper.iter().map(|row| row[k] * row[k]).sum();
        let column = std::mem::take(&mut columns[k]);
        let left = dot(&column, &column);
        if left <= NOTHING * NOTHING * (whole + left) {
            continue;
        }
        let length = left.sqrt();
        let unit: Vec<f64> = column.iter().map(|v| v / length).collect();
        upper[k][k] = length;
        for j in k + 1..count {
            upper[k][j] = take_out(&unit, &mut columns[j]);
        }
        for (side, projected) in sides.iter_mut().zip(&mut projected) {
            projected[k] = take_out(&unit, side);
        }
    }
    let solve = |projected: Vec<f64>| {
        let mut solution = vec![0.0; count];
        for k in (0..count).rev() {
            let known: f64 = (k + 1..count).map(|j| upper[k][j] * solution[j]).sum();
            if upper[k][k] > 0.0 {
                solution[k] = (projected[k] - known) / upper[k][k];
            }
        }
        solution
    };
    projected.into_iter().map(solve).collect()
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// Takes a direction out of a column, and answers how much of it there was.
fn take_out(unit: &[f64], column: &mut [f64]) -> f64 {
    let part = dot(unit, column);
    for (value, unit) in column.iter_mut().zip(unit) {
        *value -= part * unit;
    }
    part
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_is_found_again_beside_a_column_that_says_nothing_new() {
        let x: Vec<f64> = (0..50).map(|i| f64::from(i) / 25.0 - 1.0).collect();
        let column = |f: &dyn Fn(f64) -> f64| x.iter().map(|&x| f(x)).collect::<Vec<_>>();
        let columns =
            vec![column(&|_| 1.0), column(&|x| x), column(&|x| 2.0 - x), column(&|x| x * x)];
        let sides = vec![column(&|x| 3.0 - 2.0 * x + 5.0 * x * x), column(&|x| x.abs())];
        let [exact, nearest] = &least_squares(columns, sides)[..] else { panic!("two sides") };
        for (found, wanted) in exact.iter().zip([3.0, -2.0, 0.0, 5.0]) {
            assert!((found - wanted).abs() < 1e-12, "{exact:?}");
        }
        // Least squares of |x| over even steps is near 3/16 + 15/16 x^2.
        assert!((nearest[0] - 0.1875).abs() < 0.01 && (nearest[3] - 0.9375).abs() < 0.02);
    }
}
