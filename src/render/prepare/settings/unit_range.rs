//! Numbers with a unit and a range.

use super::value::{SettingError, SettingValue, type_error};

/// Names of units, and their sizes. A name stands before those that end like it.
pub type Units = [(&'static str, f64)];

/// Units of length (mm).
pub const LENGTHS: &Units = &[
    ("nm", 1e-6),
    ("um", 1e-3),
    ("mm", 1.0),
    ("cm", 10.0),
    ("in", 25.4),
    ("ft", 304.8),
    ("m", 1e3),
];

/// Units of angle (degrees).
pub const DEGREES: &Units = &[("degrees", 1.0), ("deg", 1.0), ("°", 1.0)];

/// Parses a finite number of any sign with a unit or without. The result is in units of size
/// `default`, which is also the unit of a number without one.
pub fn number_with_unit(text: &str, units: &Units, default: f64) -> Option<f64> {
    let text = text.trim();
    let with_unit = units.iter().find_map(|(unit, size)| Some((text.strip_suffix(unit)?, *size)));
    let (number, scale) = match with_unit {
        Some((number, size)) if size != default => (number, size / default),
        Some((number, _)) => (number, 1.0),
        None => (text, 1.0),
    };
    number.trim().parse().ok().map(|v: f64| v * scale).filter(|v| v.is_finite())
}

/// A number with a unit and a range.
#[derive(Clone, Copy, Debug)]
pub struct UnitRange {
    /// The units of words.
    pub units: &'static Units,
    /// The size of the unit of a number alone, which is that of the range.
    pub unit: f64,
    /// The name of that unit; empty for a plain number.
    pub name: &'static str,
    /// The smallest and the largest value. [`f64::MIN_POSITIVE`] stands for "above 0", and
    /// [`f64::MAX`] for "finite".
    pub range: [f64; 2],
    /// The description of words, such as "a length above 0 such as 36mm"; empty for the range.
    pub words: &'static str,
}

impl UnitRange {
    /// Reads a number.
    ///
    /// # Errors
    /// Returns an error for another type, or a number out of range.
    pub fn read(&self, value: &SettingValue) -> Result<f64, SettingError> {
        let found = match value {
            SettingValue::Words(_) | SettingValue::Number(_) | SettingValue::Whole(_) => {
                self.within(value)
            }
            _ => return Err(type_error(&format!("a number{}", self.limits()))),
        };
        found.ok_or_else(|| {
            SettingError::Value(match value {
                SettingValue::Words(_) if !self.words.is_empty() => {
                    format!("expected {}", self.words)
                }
                _ => format!("expected a number{}", self.limits()),
            })
        })
    }

    /// Parses the words of a command line.
    ///
    /// # Errors
    /// Returns what is expected.
    pub fn parse(&self, text: &str) -> Result<f64, String> {
        self.read(&SettingValue::Words(text.to_owned())).map_err(|error| error.to_string())
    }

    /// Reads two numbers.
    pub(super) fn read_pair(
        &self,
        value: &SettingValue,
        separator: &str,
        expected: &str,
    ) -> Result<[f64; 2], SettingError> {
        let pair: [f64; 2] = value.items(separator, |item| self.number(item), expected)?;
        match pair.iter().all(|&number| self.contains(number)) {
            true => Ok(pair),
            false => Err(SettingError::Value(format!("expected {expected}"))),
        }
    }

    /// Returns the range and the unit for messages, such as " from 1 to 2 mm".
    pub(super) fn limits(&self) -> String {
        let [low, high] = self.range;
        let range = match (low == f64::MIN_POSITIVE, high >= f64::MAX) {
            (true, true) => " above 0".to_owned(),
            (true, false) => format!(" above 0 and up to {high}"),
            _ => format!(" from {low} to {high}"),
        };
        let space = if self.name.is_empty() { "" } else { " " };
        format!("{range}{space}{}", self.name)
    }

    fn within(&self, value: &SettingValue) -> Option<f64> {
        self.number(value).filter(|&number| self.contains(number))
    }

    fn contains(&self, number: f64) -> bool {
        let [low, high] = self.range;
        (low..=high).contains(&number)
    }

    fn number(&self, value: &SettingValue) -> Option<f64> {
        match value {
            SettingValue::Words(text) if text.trim() == "inf" => Some(f64::INFINITY),
            SettingValue::Words(text) => number_with_unit(text, self.units, self.unit),
            other => other.number(),
        }
    }
}
