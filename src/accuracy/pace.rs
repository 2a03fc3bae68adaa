//! How fast a model is beside another, as far as that can be told.

use super::point::Point;

/// Times of the same work differ by so much from run to run, whatever their spread: as the frontier
/// has it.
const SAME: f64 = 0.05;

/// The same of a first pass: a few samples, which pay for all beginnings, one model after another.
const SAME_AT_FIRST: f64 = 0.3;

/// Student's t for three degrees of freedom, 95 % of both sides, over the root of four quarters.
const SPREAD: f64 = 3.182 / 2.0;

/// Time for as many samples, by that of another model.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// In units of the other's.
    pub times: f64,
    /// How far from 1 that may be by chance.
    pub tolerance: f64,
}

impl Pace {
    /// Of two points of as many samples: the median of the quotients of their four quarters. Quarter
    /// i of the one was rendered in turn with quarter i of the other, so that what else the machine
    /// did fell on both.
    pub(super) fn of(own: &Point, other: &Point) -> Option<Self> {
        let timed = [own, other].iter().all(|point| point.turns.iter().all(|&time| time > 0.0));
        if !timed {
            let times = own.seconds / other.seconds;
            return (times.is_finite() && times > 0.0)
                .then_some(Self { times, tolerance: SAME_AT_FIRST });
        }
        let quotients: [f64; 4] = std::array::from_fn(|i| own.turns[i] / other.turns[i]);
        let times = median(quotients);
        let mean = quotients.iter().sum::<f64>() / 4.0;
        let variance = quotients.iter().map(|q| (q - mean).powi(2)).sum::<f64>() / 3.0;
        Some(Self { times, tolerance: SAME.max(SPREAD * variance.sqrt()) })
    }

    /// Whether it takes less time, and not by chance.
    pub fn faster(&self) -> bool {
        self.times < 1.0 - self.tolerance
    }

    /// In words.
    pub(super) fn words(&self) -> String {
        match (self.times - 1.0).abs() <= self.tolerance {
            true => format!("the same time within {:.0} %", (100.0 * self.tolerance).ceil()),
            false => format!("{:.2}x the time", self.times),
        }
    }
}

/// The middle of four, which one that is far off does not move.
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
        let pace = Pace::of(&point([0.8, 1.6, 0.8, 2.4]), &point([1.0, 2.0, 1.0, 3.0]));
        let pace = pace.expect("times");
        assert!((pace.times - 0.8).abs() < 1e-12 && pace.faster(), "{pace:?}");
        assert_eq!(pace.words(), "0.80x the time");
    }

    #[test]
    fn what_times_scatter_by_is_no_gain() {
        let pace = Pace::of(&point([0.6, 1.2, 0.9, 0.8]), &point([1.0; 4])).expect("times");
        assert!((pace.times - 0.85).abs() < 1e-12, "{pace:?}");
        assert!(!pace.faster(), "{pace:?}");
        assert_eq!(pace.words(), "the same time within 40 %");
        // Nor is what differs by less than any two runs do.
        assert!(!Pace::of(&point([0.96; 4]), &point([1.0; 4])).expect("times").faster());
        assert!(Pace::of(&point([0.94; 4]), &point([1.0; 4])).expect("times").faster());
    }

    #[test]
    fn one_quarter_that_was_held_up_does_not_count() {
        let pace = Pace::of(&point([1.0, 1.0, 9.0, 1.0]), &point([1.0; 4])).expect("times");
        assert!((pace.times - 1.0).abs() < 1e-12, "{pace:?}");
    }

    #[test]
    fn a_first_pass_tells_great_differences_only() {
        let first = |seconds| Point { seconds, ..Point::default() };
        assert!(!Pace::of(&first(0.8), &first(1.0)).expect("times").faster());
        assert!(Pace::of(&first(0.5), &first(1.0)).expect("times").faster());
        assert_eq!(Pace::of(&first(0.5), &first(0.0)), None);
    }
}
