//! Interpolation in tables of indices.

use super::inverse_square;

/// Returns the index of a table at a wavelength (nm), linear in 1 / lambda^2 between two entries and
/// that of the end beyond it. `None` for an empty table.
pub(super) fn linear(entries: &[[f64; 2]], nm: f64) -> Option<f64> {
    let after = entries.partition_point(|entry| entry[0] <= nm);
    let Some(before) = after.checked_sub(1) else { return entries.first().map(|entry| entry[1]) };
    let [low, n] = entries[before];
    let Some(&[high, n_high]) = entries.get(after) else { return Some(n) };
    let share =
        (inverse_square(low) - inverse_square(nm)) / (inverse_square(low) - inverse_square(high));
    Some(n + share * (n_high - n))
}

/// Returns the index at a wavelength (nm) by Lagrange's polynomial in the logarithm of the wavelength
/// through the four nearest entries, or all of a shorter table. The logarithm follows glass on both
/// sides of its transparent range. It is not a number for an empty table.
pub(super) fn cubic(entries: &[[f64; 2]], nm: f64) -> f64 {
    let after = entries.partition_point(|entry| entry[0] <= nm);
    let count = entries.len().min(4);
    let first = after.saturating_sub(2).min(entries.len() - count);
    let near = &entries[first..first + count];
    let x = nm.ln();
    let basis = |i: usize| -> f64 {
        let others = near.iter().enumerate().filter(|&(j, _)| j != i);
        let at = near[i][0].ln();
        others.map(|(_, [l, _])| (x - l.ln()) / (at - l.ln())).product()
    };
    match near {
        [] => f64::NAN,
        _ => near.iter().enumerate().map(|(i, [_, n])| n * basis(i)).sum(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cubic_is_exact_at_entries_and_near_cauchys_formula_between() {
        let n = |nm: f64| 1.5 + 5e3 * inverse_square(nm) + 1e8 * inverse_square(nm).powi(2);
        let entries: Vec<[f64; 2]> =
            [400.0, 450.0, 500.0, 600.0, 700.0, 900.0].iter().map(|&nm| [nm, n(nm)]).collect();
        for [nm, exact] in &entries {
            assert!((cubic(&entries, *nm) - exact).abs() < 1e-12, "{nm}");
        }
        for nm in [410.0, 480.0, 555.0, 660.0, 850.0] {
            assert!((cubic(&entries, nm) - n(nm)).abs() < 3e-5, "{nm}");
        }
        for few in 1..4 {
            assert!((cubic(&entries[..few], 400.0) - n(400.0)).abs() < 1e-12, "{few}");
        }
        assert!(cubic(&[], 500.0).is_nan());
    }
}
