//! Statistics of samples.

/// Returns the value that this share of the samples does not exceed (nearest rank); NaN without
/// samples. The samples are in ascending order.
pub fn percentile(sorted: &[f64], share: f64) -> f64 {
    let rank = (share * sorted.len() as f64).ceil().max(1.0) as usize;
    sorted.get(rank - 1).or(sorted.last()).copied().unwrap_or(f64::NAN)
}

/// Returns Pearson's coefficient of correlation of two series; 0 if one does not vary. Pairs that
/// are not finite are left out.
pub fn correlation(x: impl Iterator<Item = f64>, y: impl Iterator<Item = f64>) -> f64 {
    let pairs: Vec<[f64; 2]> =
        x.zip(y).filter(|(x, y)| x.is_finite() && y.is_finite()).map(|(x, y)| [x, y]).collect();
    let count = pairs.len() as f64;
    let mean = [0, 1].map(|i| pairs.iter().map(|pair| pair[i]).sum::<f64>() / count);
    let moment = |i: usize, j: usize| -> f64 {
        pairs.iter().map(|pair| (pair[i] - mean[i]) * (pair[j] - mean[j])).sum()
    };
    let both = (moment(0, 0) * moment(1, 1)).sqrt();
    if both > 0.0 { moment(0, 1) / both } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn percentiles_are_samples_by_rank() {
        let sorted: Vec<f64> = (1..=10).map(f64::from).collect();
        assert_eq!(
            [0.1, 0.5, 0.9, 0.98, 1.0].map(|p| percentile(&sorted, p)),
            [1.0, 5.0, 9.0, 10.0, 10.0]
        );
        assert!(percentile(&[], 0.5).is_nan());
    }

    #[test]
    fn correlation_is_1_for_a_line_and_0_for_an_even_function() {
        let x = || (-5..=5).map(f64::from);
        assert!((correlation(x(), x().map(|x| 3.0 - 2.0 * x)) + 1.0).abs() < 1e-12);
        assert!(correlation(x(), x().map(|x| x * x)).abs() < 1e-12);
    }
}
