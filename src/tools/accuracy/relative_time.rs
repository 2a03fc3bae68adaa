//! Time of one model relative to another, with the tolerance of the measurement.

use super::point::Point;

/// Least relative difference between times of the same work from run to run, as in the frontier.
const MIN_TOLERANCE: f64 = 0.05;

/// The same for a first pass, whose few samples pay for every start-up cost, one model after
/// another.
const FIRST_PASS_TOLERANCE: f64 = 0.3;

/// Largest tolerance of a reliable time, as a share of the longer of the two. The parts of a run on a
/// quiet machine agree to a few percent.
const RELIABLE: f64 = 0.3;

/// Student's t for three degrees of freedom and 95 % of both tails, over the root of four quarters.
const T_OVER_ROOT: f64 = 3.182 / 2.0;

/// Time for the same number of samples, as a multiple of another model's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RelativeTime {
    /// Own time over the other's.
    pub times: f64,
    /// Largest distance from 1 that chance explains.
    pub tolerance: f64,
}

impl RelativeTime {
    /// Compares two points with the same number of samples by the median quotient of their four
    /// quarters. Equal quarters were rendered one after the other, so other load on the machine
    /// slowed both. Returns `None` if the times are too short to compare.
    pub fn of(own: &Point, other: &Point) -> Option<Self> {
        let timed = [own, other].iter().all(|point| point.turns.iter().all(|&time| time > 0.0));
        if !timed {
            let times = own.seconds / other.seconds;
            return (times.is_finite() && times > 0.0)
                .then_some(Self { times, tolerance: FIRST_PASS_TOLERANCE });
        }
        let quotients: [f64; 4] = std::array::from_fn(|i| own.turns[i] / other.turns[i]);
        let times = median(quotients);
        let mean = quotients.iter().sum::<f64>() / 4.0;
        let variance = quotients.iter().map(|q| (q - mean).powi(2)).sum::<f64>() / 3.0;
        Some(Self { times, tolerance: MIN_TOLERANCE.max(T_OVER_ROOT * variance.sqrt()) })
    }

    /// Returns whether the parts of the run agree well enough to tell a time at all. On a busy
    /// machine they do not.
    pub fn reliable(&self) -> bool {
        self.tolerance <= RELIABLE * self.times.max(1.0)
    }

    /// Returns whether the model takes less time, and not by chance.
    pub fn faster(&self) -> bool {
        self.reliable() && self.times < 1.0 - self.tolerance
    }

    /// Describes the comparison, such as "0.80x the time".
    pub fn words(&self) -> String {
        match (self.times - 1.0).abs() <= self.tolerance {
            _ if !self.reliable() => "time not reliable, run again".to_owned(),
            true => format!("the same time within {:.0} %", (100.0 * self.tolerance).ceil()),
            false => format!("{:.2}x the time", self.times),
        }
    }
}

/// Returns the mean of the two middle values, which one outlier does not move.
pub(super) fn median(mut four: [f64; 4]) -> f64 {
    four.sort_by(f64::total_cmp);
    f64::midpoint(four[1], four[2])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(turns: [f64; 4]) -> Point {
        Point { turns, seconds: turns.iter().sum(), ..Point::default() }
    }

    #[test]
    fn a_slower_machine_slows_both() {
        let time = RelativeTime::of(&point([0.8, 1.6, 0.8, 2.4]), &point([1.0, 2.0, 1.0, 3.0]));
        let time = time.expect("times");
        assert!((time.times - 0.8).abs() < 1e-12 && time.faster(), "{time:?}");
        assert_eq!(time.words(), "0.80x the time");
    }

    #[test]
    fn a_difference_within_the_scatter_is_no_gain() {
        let time =
            RelativeTime::of(&point([0.8, 1.1, 0.95, 0.9]), &point([1.0; 4])).expect("times");
        assert!((time.times - 0.925).abs() < 1e-12, "{time:?}");
        assert!(!time.faster(), "{time:?}");
        assert_eq!(time.words(), "the same time within 20 %");
        // A difference smaller than that of any two runs is no gain either.
        assert!(!RelativeTime::of(&point([0.96; 4]), &point([1.0; 4])).expect("times").faster());
        assert!(RelativeTime::of(&point([0.94; 4]), &point([1.0; 4])).expect("times").faster());
    }

    #[test]
    fn one_delayed_quarter_does_not_move_the_time() {
        let time = RelativeTime::of(&point([1.0, 1.0, 9.0, 1.0]), &point([1.0; 4])).expect("times");
        assert!((time.times - 1.0).abs() < 1e-12, "{time:?}");
    }

    #[test]
    fn a_busy_machine_gives_no_time() {
        for turns in [[0.1, 4.0, 0.9, 1.0], [0.3, 0.4, 0.9, 1.2], [9.0, 1.0, 1.0, 1.0]] {
            let time = RelativeTime::of(&point(turns), &point([1.0; 4])).expect("times");
            assert!(!time.reliable() && !time.faster(), "{time:?}");
            assert_eq!(time.words(), "time not reliable, run again");
        }
        // A large factor may have a large tolerance.
        let time = RelativeTime::of(&point([7.5, 8.0, 8.5, 8.0]), &point([1.0; 4])).expect("times");
        assert!(time.reliable() && time.tolerance > 0.3, "{time:?}");
        assert_eq!(time.words(), "8.00x the time");
    }

    #[test]
    fn a_first_pass_shows_large_differences_only() {
        let first = |seconds| Point { seconds, ..Point::default() };
        assert!(!RelativeTime::of(&first(0.8), &first(1.0)).expect("times").faster());
        assert!(RelativeTime::of(&first(0.5), &first(1.0)).expect("times").faster());
        assert_eq!(RelativeTime::of(&first(0.5), &first(0.0)), None);
    }
}
