//! Damped least squares, for fits of camera models and for designs: Levenberg 1944, Marquardt 1963.

use std::fmt;

use petzval_base::least_squares::least_squares;

/// Damping at the start, relative to the squares of the columns.
const FIRST_DAMPING: f64 = 1e-3;
/// Damping beyond which no step helps.
const MOST_DAMPING: f64 = 1e10;
/// Factor by which the damping shrinks after a good step and grows after a bad one.
const FACTOR: f64 = 8.0;
/// Relative decrease of the sum of squares that no longer counts.
const LEAST_DECREASE: f64 = 1e-10;

/// Why an optimization stopped.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum StopReason {
    /// The sum of squares hardly decreases.
    Converged,
    /// No step along the gradient decreases it.
    NoBetterStep,
    /// The number of iterations is reached.
    IterationLimit,
    /// The caller asked for it.
    Interrupted,
}

impl fmt::Display for StopReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Converged => "the merit hardly changes any more",
            Self::NoBetterStep => "no step from here is better",
            Self::IterationLimit => {
                "the number of iterations is reached; more may help ('iterations')"
            }
            Self::Interrupted => "it was interrupted; the lens is the best so far",
        })
    }
}

/// A function whose squares are summed.
pub(crate) trait Residuals {
    /// Returns the residuals; `None` where the function has no value.
    fn at(&self, variables: &[f64]) -> Option<Vec<f64>>;
    /// Returns the derivatives of the residuals, a column for each variable; `None` where the
    /// function has none.
    fn derivatives(&self, variables: &[f64], residuals: &[f64]) -> Option<Vec<Vec<f64>>>;
    /// Returns the smallest and the largest value of a variable. Without a bound, it is infinite.
    fn bounds(&self, _variable: usize) -> [f64; 2] {
        [f64::NEG_INFINITY, f64::INFINITY]
    }
}

/// Minimizes a sum of squares from a start within the bounds. `goes_on` is called with the number
/// of each iteration and the sum of squares. `None` if the function has no value at the start, or no
/// derivatives on the way.
pub(crate) fn minimize(
    function: &impl Residuals,
    mut at: Vec<f64>,
    iterations: u32,
    mut goes_on: impl FnMut(u32, f64) -> bool,
) -> Option<(Vec<f64>, StopReason)> {
    let square = |residuals: &[f64]| residuals.iter().map(|r| r * r).sum::<f64>();
    let mut residuals = function.at(&at)?;
    let mut sum = square(&residuals);
    let mut damping = FIRST_DAMPING;
    let mut idle = 0;
    for iteration in 0..iterations {
        if !goes_on(iteration, sum) {
            return Some((at, StopReason::Interrupted));
        }
        let columns = function.derivatives(&at, &residuals)?;
        let better = loop {
            let step = damped_step(function, &columns, &residuals, &at, damping);
            let next: Vec<f64> = (0..at.len())
                .map(|i| {
                    let [low, high] = function.bounds(i);
                    (at[i] + step[i]).clamp(low, high)
                })
                .collect();
            let found = function.at(&next).map(|residuals| (square(&residuals), residuals));
            match found {
                Some((next_sum, next_residuals)) if next_sum < sum => {
                    break Some((next, next_residuals, next_sum));
                }
                _ if damping > MOST_DAMPING => break None,
                _ => damping *= FACTOR,
            }
        };
        let Some((next, next_residuals, next_sum)) = better else {
            return Some((
                at,
                if idle > 0 { StopReason::Converged } else { StopReason::NoBetterStep },
            ));
        };
        idle = if sum - next_sum > LEAST_DECREASE * sum { 0 } else { idle + 1 };
        (at, residuals, sum) = (next, next_residuals, next_sum);
        damping = (damping / FACTOR).max(1e-15);
        if idle == 2 || sum == 0.0 {
            return Some((at, StopReason::Converged));
        }
    }
    Some((at, StopReason::IterationLimit))
}

/// Solves for a step. Variables at a bound that the gradient pushes against stay.
fn damped_step(
    function: &impl Residuals,
    columns: &[Vec<f64>],
    residuals: &[f64],
    at: &[f64],
    damping: f64,
) -> Vec<f64> {
    let count = columns.len();
    let product = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let held = |i: usize| {
        let [low, high] = function.bounds(i);
        let slope = product(&columns[i], residuals);
        at[i] <= low && slope > 0.0 || at[i] >= high && slope < 0.0
    };
    // The damping is a further row for each variable.
    let damped = |i: usize| -> Vec<f64> {
        let mut column = columns[i].clone();
        if held(i) {
            column.iter_mut().for_each(|x| *x = 0.0);
        }
        let size = product(&column, &column).sqrt();
        let mut rows = vec![0.0; count];
        rows[i] = damping.sqrt() * size;
        column.extend(rows);
        column
    };
    let mut side: Vec<f64> = residuals.iter().map(|r| -r).collect();
    side.extend(vec![0.0; count]);
    least_squares((0..count).map(damped).collect(), vec![side]).pop().unwrap_or_default()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Rosenbrock's valley, with its minimum at (1, 1).
    struct Valley([f64; 2]);

    impl Residuals for Valley {
        fn at(&self, v: &[f64]) -> Option<Vec<f64>> {
            Some(vec![1.0 - v[0], 10.0 * (v[1] - v[0] * v[0])])
        }
        fn derivatives(&self, v: &[f64], _: &[f64]) -> Option<Vec<Vec<f64>>> {
            Some(vec![vec![-1.0, -20.0 * v[0]], vec![0.0, 10.0]])
        }
        fn bounds(&self, _: usize) -> [f64; 2] {
            self.0
        }
    }

    /// The line v0 + v1 x through points that do not lie on one, with a lower bound of v0.
    struct Line(f64);

    impl Line {
        const POINTS: [[f64; 2]; 4] = [[0.0, 0.0], [1.0, 1.0], [2.0, 1.0], [3.0, 3.0]];
        const BEST: [f64; 2] = [-0.1, 0.9];
    }

    impl Residuals for Line {
        fn at(&self, v: &[f64]) -> Option<Vec<f64>> {
            Some(Self::POINTS.map(|[x, y]| v[0] + v[1] * x - y).to_vec())
        }
        fn derivatives(&self, _: &[f64], _: &[f64]) -> Option<Vec<Vec<f64>>> {
            Some(vec![vec![1.0; 4], Self::POINTS.map(|[x, _]| x).to_vec()])
        }
        fn bounds(&self, variable: usize) -> [f64; 2] {
            [if variable == 0 { self.0 } else { f64::NEG_INFINITY }, f64::INFINITY]
        }
    }

    /// A step whose sum of squares no longer counts is this near.
    const NEAR: f64 = 1e-9;

    fn assert_near(found: &[f64], expected: [f64; 2]) {
        let error = [0, 1].map(|i| (found[i] - expected[i]).abs());
        assert!(error.iter().all(|error| *error < NEAR), "{found:?} instead of {expected:?}");
    }

    /// ln v, which has no value for v <= 0.
    struct Logarithm;

    impl Residuals for Logarithm {
        fn at(&self, v: &[f64]) -> Option<Vec<f64>> {
            (v[0] > 0.0).then(|| vec![v[0].ln()])
        }
        fn derivatives(&self, v: &[f64], _: &[f64]) -> Option<Vec<Vec<f64>>> {
            Some(vec![vec![1.0 / v[0]]])
        }
    }

    #[test]
    fn steps_of_a_linear_problem_converge_faster_and_faster() {
        // The damping of four good steps, 1e-3 to 2e-6, leaves 1e-14 of the error. Steps that are 1 %
        // too long leave 1e-8 of it.
        let free = Line(f64::NEG_INFINITY);
        let (end, _) = minimize(&free, vec![5.0, -3.0], 4, |_, _| true).expect("a start");
        assert_near(&end, Line::BEST);
    }

    #[test]
    fn a_bound_holds_a_variable_only_while_the_gradient_pushes_it_there() {
        // With v0 = 1, the best v1 is the sum of x (y - 1) over that of x². The step of both variables
        // together, cut at the bound, does not lead there.
        let (end, _) = minimize(&Line(1.0), vec![5.0, -3.0], 6, |_, _| true).expect("a start");
        assert_near(&end, [1.0, 6.0 / 14.0]);
        let (end, _) = minimize(&Line(-2.0), vec![-2.0, 0.0], 6, |_, _| true).expect("a start");
        assert_near(&end, Line::BEST);
    }

    #[test]
    fn no_step_increases_the_sum_of_squares() {
        let free = Valley([f64::NEG_INFINITY, f64::INFINITY]);
        let mut sums = Vec::new();
        let record = |_, sum| {
            sums.push(sum);
            true
        };
        // The first undamped step leads across the valley, to a hundred times the sum.
        minimize(&free, vec![-1.2, 1.0], 100, record).expect("a start");
        assert!(sums.len() > 5 && sums.windows(2).all(|pair| pair[1] < pair[0]), "{sums:?}");
    }

    #[test]
    fn a_step_to_where_there_is_no_value_is_shortened() {
        let (end, reason) = minimize(&Logarithm, vec![4.0], 100, |_, _| true).expect("a start");
        assert!((end[0] - 1.0).abs() < NEAR, "{end:?}");
        assert_eq!(reason, StopReason::Converged);
        assert_eq!(minimize(&Logarithm, vec![-1.0], 100, |_, _| true), None);
    }

    #[test]
    fn a_start_at_the_bottom_has_no_better_step() {
        // The bound holds the first variable, and the derivative by the second is exactly 0.
        let bound = Valley([-2.0, 0.5]);
        let start = vec![0.5, 0.25];
        let (end, reason) = minimize(&bound, start.clone(), 100, |_, _| true).expect("a start");
        assert_eq!((end, reason), (start, StopReason::NoBetterStep));
    }

    #[test]
    fn a_curved_valley_is_followed_to_its_end() {
        let free = Valley([f64::NEG_INFINITY, f64::INFINITY]);
        let (end, reason) = minimize(&free, vec![-1.2, 1.0], 100, |_, _| true).expect("a start");
        assert!((end[0] - 1.0).abs() < 1e-6 && (end[1] - 1.0).abs() < 1e-6, "{end:?}");
        assert_eq!(reason, StopReason::Converged);
    }

    #[test]
    fn a_bound_holds_and_the_others_are_best_beside_it() {
        let bound = Valley([-2.0, 0.5]);
        let (end, _) = minimize(&bound, vec![-1.2, 0.4], 100, |_, _| true).expect("a start");
        assert!((end[0] - 0.5).abs() < 1e-6 && (end[1] - 0.25).abs() < 1e-4, "{end:?}");
    }

    #[test]
    fn an_interruption_keeps_the_best_so_far() {
        let free = Valley([f64::NEG_INFINITY, f64::INFINITY]);
        let (end, reason) = minimize(&free, vec![-1.2, 1.0], 100, |i, _| i < 3).expect("a start");
        assert_eq!(reason, StopReason::Interrupted);
        let sum = |v: &[f64]| free.at(v).map(|r| r[0] * r[0] + r[1] * r[1]);
        assert!(sum(&end) < sum(&[-1.2, 1.0]));
    }
}
