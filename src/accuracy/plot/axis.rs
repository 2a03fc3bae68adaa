//! A logarithmic axis.

/// A logarithmic axis: from values to places on the sheet.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    /// Decimal logarithms of its ends.
    ends: [f64; 2],
    /// Where they are, px.
    places: [f64; 2],
}

/// A mark on an axis.
#[derive(Clone, Debug)]
pub(super) struct Tick {
    pub value: f64,
    /// Whether it is a power of ten.
    pub decade: bool,
    pub label: Option<String>,
}

impl Axis {
    /// An axis for values above 0, from one place to the other; none where there are no values.
    pub fn new(values: impl Iterator<Item = f64>, places: [f64; 2]) -> Option<Self> {
        let logs = values.map(f64::log10).filter(|log| log.is_finite());
        let [least, most] = logs.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], log| {
            [least.min(log), most.max(log)]
        });
        if least > most {
            return None;
        }
        // Room at both ends; and a decade in all, for single values too.
        let room = (0.06 * (most - least)).max((1.0 - (most - least)) / 2.0).max(0.06);
        Some(Self { ends: [least - room, most + room], places })
    }

    /// Where a value is, px.
    pub fn place(&self, value: f64) -> f64 {
        let [low, high] = self.ends;
        let share = (value.log10() - low) / (high - low);
        self.places[0] + share * (self.places[1] - self.places[0])
    }

    /// Its marks: 1 to 9 of every decade. Powers of ten are labelled, and 2 and 5 too where there are
    /// few of those.
    pub fn ticks(&self) -> Vec<Tick> {
        let [low, high] = self.ends;
        let few = high - low < 2.2;
        let mut ticks = Vec::new();
        for power in low.floor() as i32..=high.floor() as i32 {
            for digit in 1..=9 {
                let value = f64::from(digit) * 10f64.powi(power);
                if !(low..=high).contains(&value.log10()) {
                    continue;
                }
                let labelled = digit == 1 || few && (digit == 2 || digit == 5);
                let label = labelled.then(|| label(value, power));
                ticks.push(Tick { value, decade: digit == 1, label });
            }
        }
        ticks
    }
}

/// A number of one digit.
fn label(value: f64, power: i32) -> String {
    if (-6..7).contains(&power) {
        format!("{value:.*}", (-power).max(0) as usize)
    } else {
        format!("{value:.0e}")
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn decades_are_equally_far_apart() {
        let axis = Axis::new([0.01, 100.0].into_iter(), [0.0, 500.0]).expect("an axis");
        let places = [0.1, 1.0, 10.0].map(|v| axis.place(v));
        assert!((places[1] - places[0] - (places[2] - places[1])).abs() < 1e-9);
        assert!(axis.place(0.01) > 0.0 && axis.place(100.0) < 500.0);
        let labels: Vec<String> = axis.ticks().into_iter().filter_map(|t| t.label).collect();
        assert_eq!(labels, ["0.01", "0.1", "1", "10", "100"]);
    }

    #[test]
    fn a_short_axis_has_labels_too() {
        let axis = Axis::new([3.0].into_iter(), [0.0, 1.0]).expect("an axis");
        let labels: Vec<String> = axis.ticks().into_iter().filter_map(|t| t.label).collect();
        assert_eq!(labels, ["1", "2", "5"]);
        assert!(Axis::new([].into_iter(), [0.0, 1.0]).is_none());
        assert!(Axis::new([0.0, f64::NAN].into_iter(), [0.0, 1.0]).is_none());
    }
}
