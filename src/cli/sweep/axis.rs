//! Parser of the values of a --sweep option.

/// Most pictures of one sweep, and so most values of one option.
pub(super) const MAX_PICTURES: usize = 100_000;

/// An option that changes from picture to picture.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::cli) struct SweepAxis {
    /// The argument as given.
    pub text: String,
    /// The option without dashes.
    pub name: String,
    pub values: Vec<String>,
}

/// Parses NAME=VALUES: values and ranges FIRST..LAST:COUNT, separated by commas, or by semicolons
/// if there is one.
pub(in crate::cli) fn sweep_axis(text: &str) -> Result<SweepAxis, String> {
    let expected = "expected NAME=VALUES, such as fstop=2,4,8 or focus=0.5..5:8";
    let (name, list) = text.split_once('=').ok_or(expected)?;
    let name = name.trim().trim_start_matches("--");
    let separator = if list.contains(';') { ';' } else { ',' };
    let mut values: Vec<String> = Vec::new();
    for item in list.strip_suffix(';').unwrap_or(list).split(separator).map(str::trim) {
        if name.is_empty() || item.is_empty() {
            return Err(expected.to_owned());
        }
        match range(item)? {
            Some(range) => values.extend(range),
            None => values.push(item.to_owned()),
        }
        if values.len() > MAX_PICTURES {
            return Err(format!("more than {MAX_PICTURES} values"));
        }
    }
    let mut sorted: Vec<&String> = values.iter().collect();
    sorted.sort();
    if let Some(pair) = sorted.windows(2).find(|pair| pair[0] == pair[1]) {
        return Err(format!("{} is given twice", pair[0]));
    }
    Ok(SweepAxis { text: text.to_owned(), name: name.to_owned(), values })
}

/// Returns the values of FIRST..LAST:COUNT, evenly spaced, or of FIRST..LAST:COUNT:log, with equal
/// factors between them; `None` if the text is not a range of numbers.
fn range(item: &str) -> Result<Option<Vec<String>>, String> {
    let Some((first, rest)) = item.split_once("..") else { return Ok(None) };
    let mut rest = rest.split(':');
    let last = rest.next().unwrap_or_default();
    let number = |text: &str| text.parse().ok().filter(|number: &f64| number.is_finite());
    let (Some(from), Some(to), Some(count)) = (number(first), number(last), rest.next()) else {
        return Ok(None);
    };
    let count = count.parse().ok().filter(|count| (2..=MAX_PICTURES).contains(count));
    let count =
        count.ok_or_else(|| format!("{item}: expected a count from 2 to {MAX_PICTURES}"))?;
    let log = match [rest.next(), rest.next()] {
        [None, _] => false,
        [Some("log"), None] => true,
        _ => return Err(format!("{item}: expected FIRST..LAST:COUNT or FIRST..LAST:COUNT:log")),
    };
    if log && !(from > 0.0 && to > 0.0) {
        return Err(format!("{item}: expected numbers above 0 with :log"));
    }
    let value = |i: usize| {
        let share = i as f64 / (count - 1) as f64;
        if log { from * (to / from).powf(share) } else { from + (to - from) * share }
    };
    // As few digits as keep the values distinct.
    let words = |digits: usize| -> Vec<String> {
        let inner = (1..count - 1).map(|i| short(value(i), digits));
        std::iter::once(first.to_owned()).chain(inner).chain([last.to_owned()]).collect()
    };
    let rises = |words: &Vec<String>| {
        let numbers: Vec<f64> = words.iter().filter_map(|word| word.parse().ok()).collect();
        numbers.windows(2).all(|pair| if from < to { pair[0] < pair[1] } else { pair[0] > pair[1] })
    };
    match (4..=17).map(words).find(rises) {
        Some(words) => Ok(Some(words)),
        None => Err(format!("{item}: its values are not {count} different numbers")),
    }
}

/// Formats a number with this many digits, or all digits of a whole number.
fn short(value: f64, digits: usize) -> String {
    let whole = value.round();
    let near = (value - whole).abs() <= 1e-9 * whole.abs().max(1.0);
    let rounded: f64 = format!("{value:.*e}", digits - 1).parse().unwrap_or(value);
    // Adding 0 removes the sign of -0.
    format!("{}", if near { whole } else { rounded } + 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(text: &str) -> String {
        sweep_axis(text).map(|axis| axis.values.join(" ")).unwrap_or_else(|error| error)
    }

    #[test]
    fn lists_and_ranges_are_read() {
        assert_eq!(values("fstop=2,4,8"), "2 4 8");
        assert_eq!(values("focus=0.5..5:8"), "0.5 1.143 1.786 2.429 3.071 3.714 4.357 5");
        assert_eq!(values("focus=5..0.5:4"), "5 3.5 2 0.5");
        assert_eq!(values("fstop=2..16:4:log"), "2 4 8 16");
        assert_eq!(values("fstop=1..10:3:log"), "1 3.162 10");
        assert_eq!(values("focus=1,2..3:2,inf,auto@3"), "1 2 3 inf auto@3");
        assert_eq!(values("seed=0..123456:3"), "0 61728 123456", "whole numbers stay whole");
        assert_eq!(
            values("x=1..1.0001:3"),
            "1 1.00005 1.0001",
            "more digits where they are needed"
        );
        assert_eq!(values("x=-1..1:3"), "-1 0 1");
        assert_eq!(values("film-shift=0,0;0,4"), "0,0 0,4");
        assert_eq!(values("film-shift=0,4;"), "0,4");
        assert_eq!(values("passband=400..500,500..600"), "400..500 500..600");
        assert_eq!(values("--lens=a b.dat"), "a b.dat");
    }

    #[test]
    fn invalid_lists_are_refused() {
        for (text, expected) in [
            ("fstop", "expected NAME=VALUES"),
            ("=2", "expected NAME=VALUES"),
            ("fstop=", "expected NAME=VALUES"),
            ("fstop=2,,4", "expected NAME=VALUES"),
            ("fstop=2,4,2", "2 is given twice"),
            ("focus=1..2:1", "1..2:1: expected a count from 2 to 100000"),
            ("focus=1..2:", "expected a count"),
            ("focus=1..2:999999999999", "expected a count"),
            ("focus=1..2:3:lin", "expected FIRST..LAST:COUNT"),
            ("focus=0..2:3:log", "expected numbers above 0"),
            ("focus=1..1:3", "not 3 different numbers"),
            ("x=1..1.0000000000000002:9", "not 9 different numbers"),
        ] {
            assert!(values(text).contains(expected), "{text}: {}", values(text));
        }
        assert!(values("x=0..1:60000,2..3:60000").contains("more than 100000 values"));
    }
}
