//! Numbers as reports write them.

/// Size below which a number is shown as 0.
const NEGLIGIBLE: f64 = 2e-6;

/// Rounds a number to 15 significant digits, which an f64 holds: 21.63, not 21.630000000000006.
pub fn tidy(value: f64) -> f64 {
    match value.is_finite() {
        // No negative zero.
        true => format!("{value:.14e}").parse().unwrap_or(value) + 0.0,
        false => value,
    }
}

/// Returns a number with four digits at most, without trailing zeros; 0 for lengths and angles that
/// are only not 0 for the sake of the arithmetic.
pub fn rounded(value: f64) -> String {
    if value.abs() < NEGLIGIBLE {
        return "0".to_owned();
    }
    let digits = (3 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    let text = format!("{value:.digits$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}
