//! Damped Newton's method in the plane.

/// Halvings of a step that leads nowhere.
const HALVINGS: i32 = 12;

/// Search for a zero of a function of the plane.
#[derive(Clone, Copy, Debug)]
pub struct PlaneNewton {
    /// Step of the finite differences.
    pub difference: f64,
    /// Length of the value at which the search ends.
    pub precision: f64,
    /// Length of the value that counts as a zero where rounding ends the search.
    pub acceptable: f64,
}

impl PlaneNewton {
    /// Most steps.
    const STEPS: u32 = 40;

    /// Returns the point at which the function is zero, from a start at which it exists; `None` if
    /// none is found. Steps are halved until the function exists and comes closer to zero.
    pub fn solve(
        &self,
        start: [f64; 2],
        function: impl Fn([f64; 2]) -> Option<[f64; 2]>,
    ) -> Option<[f64; 2]> {
        let value = |at: [f64; 2]| function(at).filter(|v| v.iter().all(|x| x.is_finite()));
        let length = |v: [f64; 2]| v[0].hypot(v[1]);
        let (mut at, mut left) = (start, value(start)?);
        for _ in 0..Self::STEPS {
            if length(left) <= self.precision {
                break;
            }
            let Some(step) = self.step(at, left, value) else { break };
            let closer = (0..HALVINGS).find_map(|halving| {
                let part = 0.5_f64.powi(halving);
                let next = [0, 1].map(|i| at[i] - part * step[i]);
                let found = value(next)?;
                (length(found) < length(left)).then_some((next, found))
            });
            let Some(closer) = closer else { break };
            (at, left) = closer;
        }
        (length(left) <= self.acceptable).then_some(at)
    }

    /// Returns the whole step of Newton's method from a point with its value.
    fn step(
        &self,
        at: [f64; 2],
        here: [f64; 2],
        value: impl Fn([f64; 2]) -> Option<[f64; 2]>,
    ) -> Option<[f64; 2]> {
        let column = |i: usize| -> Option<[f64; 2]> {
            let mut near = at;
            near[i] += self.difference;
            let there = value(near)?;
            Some([0, 1].map(|k| (there[k] - here[k]) / self.difference))
        };
        solve2([column(0)?, column(1)?], here)
    }
}

/// Solves the 2 x 2 system with these columns.
pub fn solve2([p, q]: [[f64; 2]; 2], r: [f64; 2]) -> Option<[f64; 2]> {
    let determinant = p[0] * q[1] - p[1] * q[0];
    let solution =
        [(r[0] * q[1] - r[1] * q[0]) / determinant, (p[0] * r[1] - p[1] * r[0]) / determinant];
    solution.iter().all(|x| x.is_finite()).then_some(solution)
}

#[cfg(test)]
mod tests {
    use super::*;

    const NEWTON: PlaneNewton =
        PlaneNewton { difference: 1e-6, precision: 1e-13, acceptable: 1e-10 };

    #[test]
    fn a_zero_is_found_where_whole_steps_leave_the_function() {
        // The logarithm exists for positive numbers only; a whole step from 5 leads to -3.
        let function = |[x, y]: [f64; 2]| (x > 0.0).then(|| [x.ln(), y + x - 1.0]);
        let [x, y] = NEWTON.solve([5.0, 7.0], function).expect("a zero");
        assert!((x - 1.0).abs() < 1e-9 && y.abs() < 1e-9, "{x} {y}");
    }

    #[test]
    fn a_function_without_a_zero_has_none() {
        assert_eq!(NEWTON.solve([0.3, 0.2], |[x, y]| Some([1.0 + x * x, y])), None);
        assert_eq!(NEWTON.solve([0.0, 0.0], |_| None), None);
    }
}
