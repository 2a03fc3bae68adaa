//! Pareto frontier of time and error.

/// Largest share of the best error so far that a slower point may have: another seed changes errors
/// by as much as the rest.
const MAX_ERROR_SHARE: f64 = 0.99;

/// Quotient of times of the same work from run to run.
const SAME_TIME: f64 = 1.05;

/// Returns which of these pairs of time and error no other beats: none takes less time at the same
/// error, or has less error in the same time. Errors within 1 % of each other count as the same,
/// and times within 5 %. Pairs with a value that is not finite are never on the frontier.
pub fn frontier(points: &[[f64; 2]]) -> Vec<bool> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&i| points[i].iter().all(|v| v.is_finite())).collect();
    order.sort_by(|&i, &j| {
        let [a, b] = [points[i], points[j]];
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
    });
    let mut kept: Vec<usize> = Vec::new();
    for i in order {
        if kept.last().is_some_and(|&best| points[i][1] >= MAX_ERROR_SHARE * points[best][1]) {
            continue;
        }
        while kept.pop_if(|best| points[i][0] <= SAME_TIME * points[*best][0]).is_some() {}
        kept.push(i);
    }
    let mut on = vec![false; points.len()];
    kept.into_iter().for_each(|i| on[i] = true);
    on
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slower_and_less_exact_point_is_beaten() {
        let points = [[1.0, 8.0], [2.0, 4.0], [3.0, 6.0], [4.0, 1.0], [9.0, 1.0]];
        assert_eq!(frontier(&points), [true, true, false, true, false]);
    }

    #[test]
    fn the_more_exact_of_two_equal_times_counts() {
        assert_eq!(frontier(&[[1.0, 3.0], [1.0, 2.0], [1.0, 4.0]]), [false, true, false]);
    }

    #[test]
    fn the_more_exact_of_two_similar_times_counts() {
        let points = [[1.0, 9.0], [2.0, 4.0], [2.02, 3.0], [2.04, 1.0]];
        assert_eq!(frontier(&points), [true, false, false, true]);
    }

    #[test]
    fn a_gain_within_one_percent_is_none() {
        assert_eq!(frontier(&[[1.0, 2.0], [2.0, 1.999], [3.0, 1.9]]), [true, false, true]);
    }

    #[test]
    fn points_that_are_not_finite_are_left_out() {
        assert_eq!(frontier(&[[1.0, f64::NAN], [2.0, 1.0]]), [false, true]);
        assert!(frontier(&[]).is_empty());
    }
}
