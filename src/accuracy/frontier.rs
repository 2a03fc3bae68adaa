//! Which pictures are worth their time.

/// A picture is worth more time only if its error is less than this share of the best before it:
/// what is less than that, the next seed changes.
const WORTH: f64 = 0.99;

/// What times of the same work differ by from one run to the next.
const SAME_TIME: f64 = 1.05;

/// Which of these pairs of time and error, both the smaller the better, no other beats: none takes
/// less time and is as exact, or takes as long and is more exact. Errors within 1 % of each other
/// count as the same, and times within 5 %. What is not finite is never among them.
pub fn frontier(points: &[[f64; 2]]) -> Vec<bool> {
    let mut order: Vec<usize> =
        (0..points.len()).filter(|&i| points[i].iter().all(|v| v.is_finite())).collect();
    order.sort_by(|&i, &j| {
        let [a, b] = [points[i], points[j]];
        a[0].total_cmp(&b[0]).then(a[1].total_cmp(&b[1]))
    });
    let mut kept: Vec<usize> = Vec::new();
    for i in order {
        if kept.last().is_some_and(|&best| points[i][1] >= WORTH * points[best][1]) {
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
    fn what_is_slower_and_less_exact_is_beaten() {
        let points = [[1.0, 8.0], [2.0, 4.0], [3.0, 6.0], [4.0, 1.0], [9.0, 1.0]];
        assert_eq!(frontier(&points), [true, true, false, true, false]);
    }

    #[test]
    fn of_two_that_take_as_long_the_more_exact_one_counts() {
        assert_eq!(frontier(&[[1.0, 3.0], [1.0, 2.0], [1.0, 4.0]]), [false, true, false]);
    }

    #[test]
    fn of_two_that_take_about_as_long_the_more_exact_one_counts() {
        let points = [[1.0, 9.0], [2.0, 4.0], [2.02, 3.0], [2.04, 1.0]];
        assert_eq!(frontier(&points), [true, false, false, true]);
    }

    #[test]
    fn a_gain_by_luck_is_none() {
        assert_eq!(frontier(&[[1.0, 2.0], [2.0, 1.999], [3.0, 1.9]]), [true, false, true]);
    }

    #[test]
    fn what_is_no_number_is_not_there() {
        assert_eq!(frontier(&[[1.0, f64::NAN], [2.0, 1.0]]), [false, true]);
        assert!(frontier(&[]).is_empty());
    }
}
