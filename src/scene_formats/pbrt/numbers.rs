//! Numbers of a scene file.

use petzval_base::io::excerpt;

/// Parses a number, or returns the fault.
pub(super) fn parse_number(word: &[u8]) -> Result<f64, String> {
    if let Some(number) = short_decimal(word) {
        return Ok(number);
    }
    let text = String::from_utf8_lossy(word);
    match text.parse::<f64>() {
        Ok(number) if number.is_finite() => Ok(number),
        Ok(_) => {
            Err(format!("the number {} is out of range; expected at most 1.8e308", excerpt(&text)))
        }
        Err(_) => Err(format!("\"{}\" is neither a number nor a directive", excerpt(&text))),
    }
}

/// Parses a decimal of few digits: both its digits and its power of ten are exact, so that one
/// division rounds correctly (Clinger 1990, "How to read floating point numbers accurately").
/// Returns `None` for every other word, valid or not.
fn short_decimal(word: &[u8]) -> Option<f64> {
    let (negative, digits) = match word {
        [b'-', rest @ ..] => (true, rest),
        [b'+', rest @ ..] => (false, rest),
        _ => (false, word),
    };
    if digits.len() > 17 {
        return None;
    }
    let (mut whole, mut point, mut decimals) = (0u64, false, 0usize);
    for &byte in digits {
        match byte {
            b'0'..=b'9' => {
                whole = 10 * whole + u64::from(byte - b'0');
                decimals += usize::from(point);
            }
            b'.' if !point => point = true,
            _ => return None,
        }
    }
    if digits.len() == usize::from(point) || whole >= 1 << 53 {
        return None;
    }
    let value = whole as f64 / TENS[decimals];
    Some(if negative { -value } else { value })
}

/// The powers of ten that a short decimal can need; all are exact in f64.
const TENS: [f64; 18] = [
    1e0, 1e1, 1e2, 1e3, 1e4, 1e5, 1e6, 1e7, 1e8, 1e9, 1e10, 1e11, 1e12, 1e13, 1e14, 1e15, 1e16,
    1e17,
];

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn short_decimals_round_as_the_standard_library_does() {
        for word in [
            "0",
            "-0",
            "1",
            "+2",
            "-3.5",
            ".5",
            "5.",
            "0.1",
            "-.25",
            "123456.789",
            "0.30000000000",
            "9007199254740991",
            "9007199254740993",
            "0.1234567890123456",
            "3.4028235e38",
            "1e-7",
            "16777217.0000001",
            "00000000000000001",
            "72057594037927945",
        ] {
            let expected: f64 = word.parse().unwrap();
            assert_eq!(
                parse_number(word.as_bytes()).unwrap().to_bits(),
                expected.to_bits(),
                "{word}"
            );
        }
        for word in ["", "-", ".", "+.", "1.2.3", "--1", "1-", "0x10", "1e", "é"] {
            assert!(parse_number(word.as_bytes()).is_err(), "{word}");
        }
    }
}
