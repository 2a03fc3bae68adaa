//! Linear least squares.

/// Relative remainder below which a column counts as a combination of those before it.
const DEPENDENT: f64 = 1e-9;

/// Returns for each right-hand side the coefficients of the columns that approximate it best.
/// Columns and sides have the same length; a column that depends on others gets 0. The method is
/// modified Gram-Schmidt with the sides as further columns, which is as exact as Householder
/// reflections (Björck 1967).
pub fn least_squares(mut columns: Vec<Vec<f64>>, mut sides: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    let count = columns.len();
    let mut upper = vec![vec![0.0; count]; count];
    let mut projected = vec![vec![0.0; count]; sides.len()];
    for k in 0..count {
        let whole: f64 = upper.iter().map(|row| row[k] * row[k]).sum();
        let column = std::mem::take(&mut columns[k]);
        let left = dot(&column, &column);
        if left <= DEPENDENT * DEPENDENT * (whole + left) {
            continue;
        }
        let length = left.sqrt();
        let unit: Vec<f64> = column.iter().map(|v| v / length).collect();
        upper[k][k] = length;
        for j in k + 1..count {
            upper[k][j] = remove_component(&unit, &mut columns[j]);
        }
        for (side, projected) in sides.iter_mut().zip(&mut projected) {
            projected[k] = remove_component(&unit, side);
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

/// Returns the sum of the products, by eight sums side by side: one sum waits for each addition.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let (a, last_a) = a.as_chunks::<8>();
    let (b, last_b) = b.as_chunks::<8>();
    let mut sums = [0.0; 8];
    for (a, b) in a.iter().zip(b) {
        for i in 0..8 {
            sums[i] += a[i] * b[i];
        }
    }
    let last: f64 = last_a.iter().zip(last_b).map(|(a, b)| a * b).sum();
    sums.iter().sum::<f64>() + last
}

/// Removes a direction from a column and returns its component.
fn remove_component(unit: &[f64], column: &mut [f64]) -> f64 {
    let component = dot(unit, column);
    for (value, unit) in column.iter_mut().zip(unit) {
        *value -= component * unit;
    }
    component
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polynomial_is_recovered_beside_a_dependent_column() {
        let x: Vec<f64> = (0..50).map(|i| f64::from(i) / 25.0 - 1.0).collect();
        let column = |f: &dyn Fn(f64) -> f64| x.iter().map(|&x| f(x)).collect::<Vec<_>>();
        let columns =
            vec![column(&|_| 1.0), column(&|x| x), column(&|x| 2.0 - x), column(&|x| x * x)];
        let sides = vec![column(&|x| 3.0 - 2.0 * x + 5.0 * x * x), column(&|x| x.abs())];
        let [exact, nearest] = &least_squares(columns, sides)[..] else { panic!("two sides") };
        for (found, expected) in exact.iter().zip([3.0, -2.0, 0.0, 5.0]) {
            assert!((found - expected).abs() < 1e-12, "{exact:?}");
        }
        // Least squares of |x| over even steps is near 3/16 + 15/16 x^2.
        assert!((nearest[0] - 0.1875).abs() < 0.01 && (nearest[3] - 0.9375).abs() < 0.02);
    }
}
