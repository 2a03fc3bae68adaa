//! Placement of labels that must not overlap.

/// Returns positions for labels near the wanted ones: in the same order, at least `gap` apart, and
/// between two ends. If there is too little room, the gap shrinks.
pub(super) fn apart(wanted: &[f64], gap: f64, [low, high]: [f64; 2]) -> Vec<f64> {
    let mut order: Vec<usize> = (0..wanted.len()).collect();
    order.sort_by(|&i, &j| wanted[i].total_cmp(&wanted[j]));
    let gap = gap.min((high - low) / (wanted.len().max(2) - 1) as f64);
    let mut places = vec![0.0; wanted.len()];
    let mut next = low;
    for &i in &order {
        places[i] = wanted[i].clamp(next, f64::max(next, high));
        next = places[i] + gap;
    }
    let mut next = high;
    for &i in order.iter().rev() {
        places[i] = places[i].min(next);
        next = places[i] - gap;
    }
    places
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_do_not_overlap() {
        let ends = [0.0, 100.0];
        assert_eq!(apart(&[50.0, 10.0], 10.0, ends), [50.0, 10.0]);
        for wanted in [[50.0; 5], [99.0, 98.0, 97.0, 2.0, 1.0], [200.0, -5.0, 3.0, 4.0, 99.0]] {
            let mut places = apart(&wanted, 10.0, ends);
            places.sort_by(f64::total_cmp);
            assert!(places.windows(2).all(|pair| pair[1] - pair[0] > 9.999), "{places:?}");
            assert!(places[0] >= 0.0 && places[4] <= 100.0, "{places:?}");
        }
        let crowded = apart(&[50.0; 21], 10.0, ends);
        assert!(crowded.iter().all(|y| (-1e-9..100.0 + 1e-9).contains(y)), "{crowded:?}");
    }
}
