//! Integers of a glTF document in the form that its parser reads.
//!
//! An integer may be written with a fraction of 0 or with an exponent, as in `5126.0` and `9.2e1` (glTF
//! 2.0, section 3.1). The types of the crate gltf-json accept neither, and take indices modulo 2^32.

use std::borrow::Cow;

/// Nesting at which the parser stops (serde_json allows 128 levels).
const MAX_NESTING: usize = 256;
/// Magnitude up to which all integers are numbers of f64.
const EXACT: f64 = 9_007_199_254_740_992.0;

/// Keys whose values are indices, beside those of attributes.
const INDEX_KEYS: [&str; 20] = [
    "buffer",
    "bufferView",
    "camera",
    "children",
    "index",
    "indices",
    "input",
    "inverseBindMatrices",
    "joints",
    "light",
    "material",
    "mesh",
    "node",
    "nodes",
    "output",
    "sampler",
    "scene",
    "skeleton",
    "skin",
    "source",
];

/// An index of 2^32 or more.
#[derive(Debug, PartialEq)]
pub(super) struct LargeIndex<'a> {
    /// Its offset in the text (bytes).
    pub offset: usize,
    /// The index as it is written.
    pub found: &'a str,
}

/// An array or object that is not closed yet.
struct Open<'a> {
    is_array: bool,
    /// The key at which it stands.
    key: &'a str,
}

/// Returns the text with each integer written as digits alone, blanks behind them. Text that is not
/// JSON is left for the parser to refuse.
///
/// # Errors
/// Returns the first index that is too large.
pub(super) fn plain_integers(text: &str) -> Result<Cow<'_, str>, LargeIndex<'_>> {
    let bytes = text.as_bytes();
    let mut plain: Option<String> = None;
    // Up to where `plain` has the text.
    let mut copied = 0;
    let mut open: Vec<Open> = Vec::new();
    let mut key = "";
    // Number of open values around an `extras`, in which keys mean nothing.
    let mut extras: Option<usize> = None;
    let mut next = 0;
    while let Some(&byte) = bytes.get(next) {
        let start = next;
        next += 1;
        match byte {
            b'"' => {
                next = string_end(bytes, next);
                let behind = bytes[next..].iter().find(|b| !b.is_ascii_whitespace());
                let in_object = open.last().is_some_and(|open| !open.is_array);
                if in_object && behind == Some(&b':') {
                    key = text.get(start + 1..next - 1).unwrap_or("");
                }
            }
            b'{' | b'[' => {
                if open.len() == MAX_NESTING {
                    return Ok(Cow::Borrowed(text));
                }
                if key == "extras" && extras.is_none() {
                    extras = Some(open.len());
                }
                let is_array = byte == b'[';
                open.push(Open { is_array, key });
                key = if is_array { key } else { "" };
            }
            b'}' | b']' => {
                key = open.pop().map_or("", |open| open.key);
                extras = extras.filter(|&around| around < open.len());
            }
            b'-' | b'0'..=b'9' => {
                let rest = &bytes[next..];
                let is_part = |b: &u8| b.is_ascii_digit() || b"+-.eE".contains(b);
                next += rest.iter().position(|b| !is_part(b)).unwrap_or(rest.len());
                let number = &text[start..next];
                if extras.is_none() && is_index(key) && number.parse().is_ok_and(is_large) {
                    return Err(LargeIndex { offset: start, found: number });
                }
                // A part of what is no number, such as .5e1, is left to the parser.
                let is_whole = start == 0 || !is_part(&bytes[start - 1]);
                if let Some(integer) = as_integer(number).filter(|_| is_whole) {
                    let plain = plain.get_or_insert_with(|| String::with_capacity(text.len()));
                    plain.push_str(&text[copied..start]);
                    plain.push_str(&format!("{integer:<width$}", width = number.len()));
                    copied = next;
                }
            }
            _ => {}
        }
    }
    Ok(match plain {
        None => Cow::Borrowed(text),
        Some(mut plain) => {
            plain.push_str(&text[copied..]);
            Cow::Owned(plain)
        }
    })
}

/// Returns the offset behind the closing quote of a string whose content begins at `next`.
fn string_end(bytes: &[u8], mut next: usize) -> usize {
    while let Some(&byte) = bytes.get(next) {
        next += if byte == b'\\' { 2 } else { 1 };
        if byte == b'"' {
            break;
        }
    }
    next.min(bytes.len())
}

fn is_index(key: &str) -> bool {
    // Semantics of attributes have capital letters or begin with an underscore.
    let is_attribute = key.starts_with(|c: char| c.is_ascii_uppercase() || c == '_');
    is_attribute || INDEX_KEYS.contains(&key)
}

fn is_large(number: f64) -> bool {
    number >= 4_294_967_296.0
}

/// Returns the value of an integer that is written with a fraction or an exponent.
fn as_integer(number: &str) -> Option<i64> {
    if !number.contains(['.', 'e', 'E']) || !is_json(number) {
        return None;
    }
    let value: f64 = number.parse().ok()?;
    let is_integer = value.fract() == 0.0 && value.abs() <= EXACT;
    let is_negative_zero = value == 0.0 && value.is_sign_negative();
    (is_integer && !is_negative_zero).then_some(value as i64)
}

/// Returns whether a number that Rust parses is one of JSON: digits stand on both sides of a point, and
/// no zero leads.
fn is_json(number: &str) -> bool {
    let digits = number.strip_prefix('-').unwrap_or(number);
    let (whole, fraction) = digits.split_once('.').unwrap_or((digits, "0"));
    let whole = whole.split(['e', 'E']).next().unwrap_or("");
    let is_plain = !whole.is_empty() && (whole == "0" || !whole.starts_with('0'));
    is_plain && fraction.starts_with(|c: char| c.is_ascii_digit())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plain(text: &str) -> String {
        plain_integers(text).unwrap().into_owned()
    }

    #[test]
    fn integers_with_a_fraction_or_an_exponent_become_digits() {
        assert_eq!(plain(r#"{"count": 4.0}"#), r#"{"count": 4  }"#);
        assert_eq!(
            plain("[5126.0, 9.2e1, 1E2, -3.0, 1.5, 5126, 2.5e+1]"),
            "[5126  , 92   , 100, -3  , 1.5, 5126, 25    ]"
        );
        assert_eq!(plain("[-0.0, 1e300, 0.1]"), "[-0.0, 1e300, 0.1]");
        assert_eq!(plain(r#"["4.0", "\"4.0", 4.00]"#), r#"["4.0", "\"4.0", 4   ]"#);
    }

    #[test]
    fn what_is_not_json_is_left_alone() {
        for text in ["[4., 04.0, .5e1, 1.e2, --4.0, 4.0.0]", "\"4.0", "]]}}4", "{\"a\\", "\""] {
            assert_eq!(plain(text), text);
        }
        let deep = "[".repeat(1000) + "4.0";
        assert_eq!(plain(&deep), deep);
    }

    #[test]
    fn indices_of_two_to_the_32_and_more_are_found_and_sizes_are_not() {
        for text in [
            r#"{"scene": 4294967296}"#,
            r#"{"nodes": [0, 4294967296]}"#,
            r#"{"primitives": [{"attributes": {"POSITION": 4294967296}}]}"#,
            r#"{"attributes": {"_FEATURE_ID_0": 4294967296.0}}"#,
            r#"{"extras": {"scene": 7}, "scene": 4.294967296e9}"#,
            r#"{"scene": 99999999999999999999999}"#,
        ] {
            let found = plain_integers(text).unwrap_err();
            assert!(text[found.offset..].starts_with(found.found), "{text}");
        }
        for text in [
            r#"{"scene": 4294967295, "byteLength": 4294967296, "zfar": 1e10}"#,
            r#"{"extras": {"scene": 4294967296, "nodes": [[4294967296]]}}"#,
            r#"{"extras": [{"node": 4294967296}], "byteOffset": 5000000000}"#,
        ] {
            assert!(plain_integers(text).is_ok(), "{text}");
        }
    }
}
