//! Removal of what varies slowly over a field, such as the falloff of its light.

/// Half of the width of the filter (pixels): values nearer to the border have no filtered one.
pub(super) const REACH: usize = 9;

/// A field without what varies slowly.
pub(super) struct Filtered {
    /// Width and height (pixels).
    pub size: [usize; 2],
    /// Values, row after row.
    pub values: Vec<f64>,
}

/// Returns the smoothing filter in one direction: boxes of 7 and 11 pixels, and a binomial of 3.
fn smoothing() -> [f64; 2 * REACH + 1] {
    let mut filter = [0.0; 2 * REACH + 1];
    for (i, value) in filter.iter_mut().enumerate() {
        for (shift, weight) in [(0, 0.25), (1, 0.5), (2, 0.25)] {
            // Ways to add an offset from 0 to 6 and one from 0 to 10 to what is left.
            let Some(rest) = i.checked_sub(shift) else { continue };
            let ways = (rest + 1).min(7).min(17_usize.saturating_sub(rest));
            *value += weight * ways as f64 / 77.0;
        }
    }
    filter
}

/// Returns the share of the variance of independent values that is left by the filter: in a field, and in a line.
pub(super) fn remaining_variance() -> [f64; 2] {
    let filter = smoothing();
    let squares: f64 = filter.iter().map(|value| value * value).sum();
    let middle = filter[REACH];
    [1.0 - 2.0 * middle * middle + squares * squares, 1.0 - 2.0 * middle + squares]
}

/// Subtracts the smoothed field (EMVA 1288, release 4.0, section 8.1).
pub(super) fn high_pass(values: &[f64], [width, height]: [usize; 2]) -> Filtered {
    let filter = smoothing();
    let inner = [width - 2 * REACH, height - 2 * REACH];
    let convolve = |at: &dyn Fn(usize) -> f64| -> f64 {
        filter.iter().enumerate().map(|(k, weight)| weight * at(k)).sum()
    };
    let mut smoothed_rows = Vec::with_capacity(inner[0] * height);
    for row in values.chunks_exact(width) {
        smoothed_rows.extend((0..inner[0]).map(|x| convolve(&|k| row[x + k])));
    }
    let mut filtered = Vec::with_capacity(inner[0] * inner[1]);
    for y in 0..inner[1] {
        for x in 0..inner[0] {
            let smoothed = convolve(&|k| smoothed_rows[(y + k) * inner[0] + x]);
            filtered.push(values[(y + REACH) * width + x + REACH] - smoothed);
        }
    }
    Filtered { size: inner, values: filtered }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_filter_is_that_of_the_standard() {
        let filter = smoothing();
        assert!((filter.iter().sum::<f64>() - 1.0).abs() < 1e-15);
        for (value, mirrored) in filter.iter().zip(filter.iter().rev()) {
            assert!((value - mirrored).abs() < 1e-15 && *value > 0.0);
        }
        // The deviation of independent values falls to 99.42 %.
        assert!((remaining_variance()[0].sqrt() - 0.9942).abs() < 1e-4);
    }

    #[test]
    fn slopes_vanish_and_single_pixels_stay() {
        let size = [40, 30];
        let slope = |i: usize| 3.0 + 0.5 * (i % 40) as f64 - 0.25 * (i / 40) as f64;
        let mut values: Vec<f64> = (0..1200).map(slope).collect();
        values[15 * 40 + 20] += 1.0;
        let found = high_pass(&values, size);
        assert_eq!(found.size, [22, 12]);
        for (i, value) in found.values.iter().enumerate() {
            let is_bright = (i % 22, i / 22) == (20 - REACH, 15 - REACH);
            assert!((value - f64::from(u8::from(is_bright))).abs() < 0.01, "{i}: {value}");
        }
    }
}
