//! Parser of times such as `1/125` and `20ms`.

/// Parses a time in seconds: `0.02`, `20ms`, `500us`, `2s`, `1/125`. Negative values are times
/// before 0.
///
/// # Errors
/// Returns an error if the text is not a finite time.
pub fn parse_seconds(text: &str) -> Result<f64, String> {
    let text = text.trim();
    let units = [("us", 1e-6), ("ms", 1e-3), ("s", 1.0), ("", 1.0)];
    let time = units.iter().find_map(|(unit, seconds)| {
        let number = text.strip_suffix(unit)?.trim();
        let value = match number.split_once('/') {
            Some((over, under)) => over.parse::<f64>().ok()? / under.parse::<f64>().ok()?,
            None => number.parse().ok()?,
        };
        Some(value * seconds)
    });
    time.filter(|time| time.is_finite())
        .ok_or_else(|| format!("expected a time such as 20ms, 1/125 or 0.5s, found {text:?}"))
}

#[cfg(test)]
mod tests {
    use super::parse_seconds;

    #[test]
    fn times_are_read_as_photographers_write_them() {
        for (text, expected) in
            [("1/125", 0.008), ("20ms", 0.02), ("500us", 5e-4), ("2 s", 2.0), ("-0.5", -0.5)]
        {
            assert!((parse_seconds(text).unwrap() - expected).abs() < 1e-15, "{text}");
        }
        for text in ["", "ms", "1/0", "nan", "inf", "1h", "1/2/3"] {
            assert!(parse_seconds(text).unwrap_err().contains("expected a time"), "{text}");
        }
    }
}
