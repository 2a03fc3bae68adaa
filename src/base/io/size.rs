//! Sizes of memory, parsed and formatted with their units.

use std::fmt;
use std::str::FromStr;

/// A number of bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub struct ByteSize(pub u64);

/// The units of a size in lower case. A single letter is a power of 1024, as in Slurm and systemd.
const UNITS: [(&str, u64); 14] = [
    ("kib", 1 << 10),
    ("mib", 1 << 20),
    ("gib", 1 << 30),
    ("tib", 1 << 40),
    ("kb", 1_000),
    ("mb", 1_000_000),
    ("gb", 1_000_000_000),
    ("tb", 1_000_000_000_000),
    ("k", 1 << 10),
    ("m", 1 << 20),
    ("g", 1 << 30),
    ("t", 1 << 40),
    ("b", 1),
    ("", 1),
];

impl FromStr for ByteSize {
    type Err = String;

    /// Parses 8GiB, 500MB, 2G or a number of bytes; at least one byte.
    fn from_str(text: &str) -> Result<Self, String> {
        let lower = text.trim().to_lowercase();
        let unit = UNITS.iter().find(|(name, _)| lower.ends_with(name));
        let bytes = unit.and_then(|(name, factor)| {
            let number = lower.strip_suffix(name)?.trim_end();
            let plain = number.chars().all(|c| c.is_ascii_digit() || c == '.');
            let number: f64 = number.parse().ok().filter(|_| plain)?;
            Some(number * *factor as f64)
        });
        match bytes {
            // No address space is larger.
            Some(bytes) if (1.0..=u64::MAX as f64 / 2.0).contains(&bytes) => Ok(Self(bytes as u64)),
            _ => Err("expected a size of memory such as 8GiB, 500MB or 2G".to_owned()),
        }
    }
}

impl fmt::Display for ByteSize {
    /// Writes the size in GB, or in MB, kB or B if it is less than one; rounded up.
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        match self.0 {
            0..1_000 => write!(f, "{} B", self.0),
            1_000..1_000_000 => write!(f, "{} kB", self.0.div_ceil(1_000)),
            1_000_000..1_000_000_000 => write!(f, "{} MB", self.0.div_ceil(1_000_000)),
            _ => write!(f, "{:.2} GB", self.0.div_ceil(10_000_000) as f64 / 100.0),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn sizes_are_read_with_their_units() {
        let read = |text: &str| text.parse::<ByteSize>().map(|size| size.0);
        for (text, bytes) in [
            ("8GiB", 8 << 30),
            ("8 gib", 8 << 30),
            ("500MB", 500_000_000),
            ("2G", 2 << 30),
            ("1.5k", 1536),
            ("123456", 123_456),
            ("7B", 7),
        ] {
            assert_eq!(read(text), Ok(bytes), "{text}");
        }
        for text in
            ["", "0", "GiB", "-1G", "1e9", "inf", "nan", "8 apples", "99999999999T", "1..2G"]
        {
            assert!(read(text).is_err(), "{text}");
        }
    }

    #[test]
    fn sizes_are_written_in_few_digits() {
        assert_eq!(ByteSize(1).to_string(), "1 B");
        assert_eq!(ByteSize(1_001).to_string(), "2 kB");
        assert_eq!(ByteSize(512_300_000).to_string(), "513 MB");
        assert_eq!(ByteSize(1_536_000_001).to_string(), "1.54 GB");
    }
}
