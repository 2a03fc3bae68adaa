//! A logarithmic axis.

/// A logarithmic axis: maps values to positions on the sheet.
#[derive(Clone, Debug)]
pub(super) struct Axis {
    /// Decimal logarithms of the values at its ends.
    ends: [f64; 2],
    /// Positions of its ends [px].
    positions: [f64; 2],
}

/// A tick mark.
#[derive(Clone, Debug)]
pub(super) struct Tick {
    pub value: f64,
    /// Whether the value is a power of ten.
    pub decade: bool,
    pub label: Option<String>,
}

impl Axis {
    /// Creates an axis that spans the values above 0, between two positions [px]; `None` without
    /// values.
    pub fn new(values: impl Iterator<Item = f64>, positions: [f64; 2]) -> Option<Self> {
        let logs = values.map(f64::log10).filter(|log| log.is_finite());
        let [least, most] = logs.fold([f64::INFINITY, f64::NEG_INFINITY], |[least, most], log| {
            [least.min(log), most.max(log)]
        });
        if least > most {
            return None;
        }
        // A margin at both ends, and at least a decade in all, even for a single value.
        let room = (0.06 * (most - least)).max((1.0 - (most - least)) / 2.0).max(0.06);
        Some(Self { ends: [least - room, most + room], positions })
    }

    /// Returns the position of a value [px].
    pub fn position(&self, value: f64) -> f64 {
        let [low, high] = self.ends;
        let share = (value.log10() - low) / (high - low);
        self.positions[0] + share * (self.positions[1] - self.positions[0])
    }

    /// Returns the ticks, at 1 to 9 of every decade. Powers of ten have labels; on a short axis 2
    /// and 5 have labels, too.
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

/// Formats a number of one digit.
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
        let positions = [0.1, 1.0, 10.0].map(|v| axis.position(v));
        assert!((positions[1] - positions[0] - (positions[2] - positions[1])).abs() < 1e-9);
        assert!(axis.position(0.01) > 0.0 && axis.position(100.0) < 500.0);
        let labels: Vec<String> = axis.ticks().into_iter().filter_map(|t| t.label).collect();
        assert_eq!(labels, ["0.01", "0.1", "1", "10", "100"]);
    }

    #[test]
    fn a_single_value_has_labels() {
        let axis = Axis::new([3.0].into_iter(), [0.0, 1.0]).expect("an axis");
        let labels: Vec<String> = axis.ticks().into_iter().filter_map(|t| t.label).collect();
        assert_eq!(labels, ["1", "2", "5"]);
        assert!(Axis::new([].into_iter(), [0.0, 1.0]).is_none());
        assert!(Axis::new([0.0, f64::NAN].into_iter(), [0.0, 1.0]).is_none());
    }
}
