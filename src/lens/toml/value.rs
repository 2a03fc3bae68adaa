//! Values by key, with the lines where they stand.

use std::path::Path;

use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

use crate::lens::error::LensError;
use crate::source::{excerpt, hint};

/// The file that is being read.
#[derive(Clone, Copy)]
pub(super) struct Source<'a> {
    pub(super) path: &'a Path,
    pub(super) text: &'a str,
}

impl Source<'_> {
    /// The error at a byte of the text.
    pub(super) fn refuse(
        &self,
        at: usize,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> LensError {
        let before = &self.text.as_bytes()[..at.min(self.text.len())];
        let line_start =
            before.iter().rposition(|&byte| byte == b'\n').map_or(0, |place| place + 1);
        // Characters, not bytes: those that continue one do not count.
        let ahead = before[line_start..].iter().filter(|&&byte| byte & 0xc0 != 0x80);
        LensError::Malformed {
            path: self.path.to_owned(),
            line: 1 + before.iter().filter(|&&byte| byte == b'\n').count(),
            column: Some(1 + ahead.count()),
            found: found.into(),
            expected: expected.into(),
        }
    }
}

/// A table of the file.
#[derive(Clone, Copy)]
pub(super) struct Section<'a> {
    pub(super) source: Source<'a>,
    /// Where it begins, in bytes.
    pub(super) at: usize,
    pub(super) table: &'a DeTable<'a>,
}

/// Integer or float; `inf` and `nan` are numbers of TOML too.
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

    /// Where the value of a key stands, or the section if there is none.
    pub(super) fn place(&self, key: &str) -> usize {
        self.value(key).map_or(self.at, |value| value.span().start)
    }

    /// The error at the value of a key.
    pub(super) fn refuse(
        &self,
        key: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> LensError {
        self.source.refuse(self.place(key), found, expected)
    }

    fn wrong_type(&self, key: &str, value: &DeValue, expected: &str) -> LensError {
        let kind = match value {
            DeValue::Integer(_) | DeValue::Float(_) => "a number".to_owned(),
            DeValue::Array(_) => "an array".to_owned(),
            DeValue::Boolean(truth) => truth.to_string(),
            other => format!("a {}", other.type_str()),
        };
        self.refuse(key, format!("{key} is {kind}"), format!("expected {expected}"))
    }

    /// Refuses the first key that is none of those known.
    pub(super) fn only(&self, known: &[&str]) -> Result<(), LensError> {
        let strange = self.table.keys().filter(|key| !known.contains(&key.get_ref().as_ref()));
        let Some(key) = strange.min_by_key(|key| key.span().start) else { return Ok(()) };
        let name = excerpt(key.get_ref());
        let near = hint(&name, known.iter().copied());
        let found = format!("unknown key \"{name}\"{near}");
        Err(self.source.refuse(key.span().start, found, format!("known are {}", known.join(", "))))
    }

    /// A number, perhaps infinite.
    pub(super) fn number(&self, key: &str) -> Result<Option<f64>, LensError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        match number(value.get_ref()) {
            Some(number) if !number.is_nan() => Ok(Some(number)),
            Some(_) => Err(self.refuse(key, format!("{key} is nan"), "expected a number")),
            None => Err(self.wrong_type(key, value.get_ref(), "a number")),
        }
    }

    pub(super) fn finite(&self, key: &str) -> Result<Option<f64>, LensError> {
        match self.number(key)? {
            Some(number) if number.is_infinite() => {
                let found = format!("{key} is {number}");
                Err(self.refuse(key, found, "expected a finite number"))
            }
            number => Ok(number),
        }
    }

    pub(super) fn text(&self, key: &str) -> Result<Option<&'a str>, LensError> {
        let Some(value) = self.value(key) else { return Ok(None) };
        match value.get_ref() {
            DeValue::String(text) => Ok(Some(text.as_ref())),
            other => Err(self.wrong_type(key, other, "a string in quotes")),
        }
    }

    pub(super) fn flag(&self, key: &str) -> Result<bool, LensError> {
        match self.value(key).map(|value| value.get_ref()) {
            None => Ok(false),
            Some(DeValue::Boolean(truth)) => Ok(*truth),
            Some(other) => Err(self.wrong_type(key, other, "true or false")),
        }
    }

    /// The array of a key; nothing where the value is something else.
    pub(super) fn array(&self, key: &str) -> Option<&'a DeArray<'a>> {
        self.value(key).and_then(|value| value.get_ref().as_array())
    }

    /// Two finite numbers in an array, with its place.
    pub(super) fn couple(
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
            Some(&[a, b]) if a.is_finite() && b.is_finite() => Ok(Some((self.place(key), [a, b]))),
            _ => Err(self.refuse(key, format!("{key} is no pair of finite numbers"), expected)),
        }
    }

    /// Pairs of finite numbers, each with its place.
    pub(super) fn pairs(&self, key: &str, form: &str) -> Result<Vec<(usize, [f64; 2])>, LensError> {
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
                        let found = format!("an entry of {key} is no pair of finite numbers");
                        Err(self.source.refuse(at, found, format!("expected {form}")))
                    }
                }
            })
            .collect()
    }
}
