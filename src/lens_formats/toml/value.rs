//! Typed access to the values of a TOML table, with their positions.

use std::cell::RefCell;
use std::path::Path;

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use petzval_base::io::{Location, ReadContext, excerpt, hint};
use petzval_lens::LensError;
use petzval_spectrum::GlassLibrary;

/// Largest number of tables of one kind.
const MAX_TABLES: usize = 256;

/// The file that is being read.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
    pub(super) context: &'a ReadContext,
    pub(super) glasses: &'a GlassLibrary,
    /// Notes about the glasses of the file, for the user.
    pub(super) notes: &'a RefCell<Vec<String>>,
}

impl Source<'_> {
    /// Adds a note once.
    pub(super) fn note(&self, note: String) {
        let mut notes = self.notes.borrow_mut();
        if !notes.contains(&note) {
            notes.push(note);
        }
    }

    /// Returns an error at a byte offset of the text.
    pub(super) fn error_at(
        &self,
        at: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> LensError {
        let Location { line, column, .. } = Location::in_text(self.path, self.text, at);
        LensError::Malformed {
            path: self.path.to_owned(),
            line: line as usize,
            column: Some(column as usize),
            found: found.into(),
            expected: expected.into(),
        }
    }
}

/// A table of the file.
#[derive(Clone, Copy)]
pub(super) struct Section<'a> {
    pub(super) source: Source<'a>,
    /// Byte offset of its start.
    pub(super) at: usize,
    pub(super) table: &'a DeTable<'a>,
}

/// Returns the value of an integer or float; TOML has `inf` and `nan`.
fn number(value: &DeValue) -> Option<f64> {
    match value {
        DeValue::Float(float) => float.as_str().parse().ok(),
        DeValue::Integer(integer) if integer.radix() == 10 => integer.as_str().parse().ok(),
        DeValue::Integer(integer) => {
            i64::from_str_radix(integer.as_str(), integer.radix()).ok().map(|i| i as f64)
        }
        _ => None,
    }
}

impl<'a> Section<'a> {
    fn value(&self, key: &str) -> Option<&'a Spanned<DeValue<'a>>> {
        self.table.iter().find(|(name, _)| name.get_ref() == key).map(|(_, value)| value)
    }

    pub(super) fn has(&self, key: &str) -> bool {
        self.value(key).is_some()
    }

    /// Returns the byte offset of the value of a key, or of the section if the key is missing.
    pub(super) fn position(&self, key: &str) -> usize {
        self.value(key).map_or(self.at, |value| value.span().start)
    }

    /// Returns an error at the value of a key.
    pub fn error(
        &self,
        key: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> LensError {
        self.source.error_at(self.position(key), found, expected)
    }

    fn wrong_type(&self, key: &str, value: &DeValue, expected: &str) -> LensError {
        let kind = match value {
            DeValue::Integer(_) | DeValue::Float(_) => "a number".to_owned(),
            DeValue::Array(_) => "an array".to_owned(),
            DeValue::Boolean(truth) => truth.to_string(),
            other => format!("a {}", other.type_str()),
        };
        self.error(key, format!("{key} is {kind}"), format!("expected {expected}"))
    }

    /// Returns an error for the first unknown key.
    pub(super) fn reject_unknown_keys(&self, known: &[&str]) -> Result<(), LensError> {
        let unknown = self.table.keys().filter(|key| !known.contains(&key.get_ref().as_ref()));
        let Some(key) = unknown.min_by_key(|key| key.span().start) else { return Ok(()) };
        let name = excerpt(key.get_ref());
        let near = hint(&name, known.iter().copied());
        let found = format!("unknown key \"{name}\"{near}");
        Err(self.source.error_at(
            key.span().start,
            found,
            format!("known are {}", known.join(", ")),
        ))
    }

    /// Returns a number that may be infinite.
    pub(super) fn number(&self, key: &str) -> Result<Option<f64>, LensError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        match number(value.get_ref()) {
            Some(number) if !number.is_nan() => Ok(Some(number)),
            Some(_) => Err(self.error(key, format!("{key} is nan"), "expected a number")),
            None => Err(self.wrong_type(key, value.get_ref(), "a number")),
        }
    }

    pub(super) fn finite(&self, key: &str) -> Result<Option<f64>, LensError> {
        match self.number(key)? {
            Some(number) if number.is_infinite() => {
                let found = format!("{key} is {number}");
                Err(self.error(key, found, "expected a finite number"))
            }
            number => Ok(number),
        }
    }

    pub(super) fn string(&self, key: &str) -> Result<Option<&'a str>, LensError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        match value.get_ref() {
            DeValue::String(text) => Ok(Some(text.as_ref())),
            other => Err(self.wrong_type(key, other, "a string in quotes")),
        }
    }

    pub(super) fn boolean(&self, key: &str) -> Result<bool, LensError> {
        match self.value(key).map(|value| value.get_ref()) {
            None => Ok(false),
            Some(DeValue::Boolean(truth)) => Ok(*truth),
            Some(other) => Err(self.wrong_type(key, other, "true or false")),
        }
    }

    /// Returns the array of a key; `None` for a value of another type.
    pub(super) fn array(&self, key: &str) -> Option<&'a DeArray<'a>> {
        self.value(key).and_then(|value| value.get_ref().as_array())
    }

    /// Returns the finite numbers of an array, at most `most`; none if the key is missing.
    pub(super) fn number_list(&self, key: &str, most: usize) -> Result<Vec<f64>, LensError> {
        let Some(value) = self.value(key) else { return Ok(Vec::new()) };
        let Some(array) = self.array(key) else {
            return Err(self.wrong_type(key, value.get_ref(), "a list of numbers"));
        };
        let numbers: Option<Vec<f64>> =
            array.iter().map(|v| number(v.get_ref()).filter(|v| v.is_finite())).collect();
        match numbers {
            Some(numbers) if numbers.len() <= most => Ok(numbers),
            _ => Err(self.error(
                key,
                format!("{key} is not a list of finite numbers"),
                format!("expected at most {most} numbers"),
            )),
        }
    }

    /// Returns the numbers of an array, which may be an array of arrays, if there are `count`.
    pub(super) fn numbers(
        &self,
        key: &str,
        count: usize,
        expected: &str,
    ) -> Result<Option<Vec<f64>>, LensError> {
        fn collect(array: &DeArray, all: &mut Vec<f64>) -> bool {
            array.iter().all(|value| match value.get_ref() {
                DeValue::Array(inner) => collect(inner, all),
                value => number(value).filter(|v| v.is_finite()).map(|v| all.push(v)).is_some(),
            })
        }
        if !self.has(key) {
            return Ok(None);
        }
        let mut all = Vec::new();
        let numbers = self.array(key).is_some_and(|array| collect(array, &mut all));
        if numbers && all.len() == count {
            return Ok(Some(all));
        }
        Err(self.error(key, format!("{key} is not {count} finite numbers"), expected))
    }

    /// Returns the tables under a key such as `[[surface]]`; empty if the key is missing.
    pub(super) fn tables(&self, key: &str, expected: &str) -> Result<Vec<Self>, LensError> {
        if !self.has(key) {
            return Ok(Vec::new());
        }
        let Some(array) = self.array(key) else {
            return Err(self.error(key, format!("{key} is not a list"), expected));
        };
        if array.len() > MAX_TABLES {
            let found = format!("{} entries of {key}", array.len());
            return Err(self.error(key, found, format!("expected at most {MAX_TABLES}")));
        }
        let table = |entry: &'a Spanned<DeValue<'a>>| {
            let at = entry.span().start;
            match entry.get_ref() {
                DeValue::Table(table) => Ok(Self { source: self.source, at, table }),
                _ => {
                    let found = format!("an entry of {key} without keys");
                    Err(self.source.error_at(at, found, expected))
                }
            }
        };
        array.iter().map(table).collect()
    }

    /// Returns an array of two finite numbers, with its byte offset.
    pub(super) fn number_pair(
        &self,
        key: &str,
        expected: &str,
    ) -> Result<Option<(usize, [f64; 2])>, LensError> {
        if !self.has(key) {
            return Ok(None);
        }
        let numbers: Option<Vec<f64>> =
            self.array(key).and_then(|array| array.iter().map(|v| number(v.get_ref())).collect());
        match numbers.as_deref() {
            Some(&[a, b]) if a.is_finite() && b.is_finite() => {
                Ok(Some((self.position(key), [a, b])))
            }
            _ => Err(self.error(key, format!("{key} is not a pair of finite numbers"), expected)),
        }
    }

    /// Returns an array of pairs of finite numbers, each with its byte offset.
    pub(super) fn number_pairs(
        &self,
        key: &str,
        form: &str,
    ) -> Result<Vec<(usize, [f64; 2])>, LensError> {
        let Some(value) = self.value(key) else { return Ok(Vec::new()) };
        let Some(array) = self.array(key) else {
            return Err(self.wrong_type(key, value.get_ref(), form));
        };
        array
            .iter()
            .map(|entry| {
                let at = entry.span().start;
                let numbers: Option<Vec<f64>> = entry
                    .get_ref()
                    .as_array()
                    .and_then(|pair| pair.iter().map(|v| number(v.get_ref())).collect());
                match numbers.as_deref() {
                    Some(&[a, b]) if a.is_finite() && b.is_finite() => Ok((at, [a, b])),
                    _ => {
                        let found = format!("an entry of {key} is not a pair of finite numbers");
                        Err(self.source.error_at(at, found, format!("expected {form}")))
                    }
                }
            })
            .collect()
    }
}
