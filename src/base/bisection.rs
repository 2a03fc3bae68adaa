//! Bisection of an interval at whose ends a test differs.

/// Halves the interval from a number that passes a test to one that fails it, so many times, and
/// returns its last ends `[passes, fails]`. The numbers may be in either order; neither is tested.
/// About 52 halvings reach the precision of an f64.
///
/// ```
/// use petzval_base::bisection::bisect;
///
/// let [below, above] = bisect([1.0, 2.0], 52, |x| x * x < 2.0);
/// assert!(below < above && above - below < 1e-15);
/// assert!((below - 2f64.sqrt()).abs() < 1e-15);
/// ```
pub fn bisect(ends: [f64; 2], halvings: u32, mut test: impl FnMut(f64) -> bool) -> [f64; 2] {
    try_bisect(ends, halvings, |middle| Some(test(middle))).unwrap_or(ends)
}

/// Halves an interval as [`bisect`] does; `None` as soon as the test has no result.
pub fn try_bisect(
    [mut passes, mut fails]: [f64; 2],
    halvings: u32,
    mut test: impl FnMut(f64) -> Option<bool>,
) -> Option<[f64; 2]> {
    for _ in 0..halvings {
        let middle = (passes + fails) / 2.0;
        match test(middle)? {
            true => passes = middle,
            false => fails = middle,
        }
    }
    Some([passes, fails])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ends_may_be_in_either_order() {
        let [above, below] = bisect([8.0, 0.0], 60, |x| x > 3.0);
        assert!(above > 3.0 && below <= 3.0 && above - below < 1e-15, "{below} {above}");
    }

    #[test]
    fn a_test_without_a_result_ends_the_search() {
        assert_eq!(try_bisect([0.0, 1.0], 50, |x| (x < 0.6).then_some(true)), None);
        assert_eq!(try_bisect([0.0, 1.0], 0, |_| None), Some([0.0, 1.0]));
    }
}
