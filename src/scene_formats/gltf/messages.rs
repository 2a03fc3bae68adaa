//! Errors and warnings about elements of a document, with their place in its text.

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use serde_json::value::RawValue;

use super::document::Document;
use crate::pbrt::SceneError;
use petzval_base::io::{Location, Warning};

/// The first warning of a message.
pub(super) struct CountedWarning {
    message: String,
    first: Warning,
    /// Number of further ones.
    more: u32,
}

impl Document {
    /// Returns the place of an element, such as `meshes/2/primitives/0`.
    pub fn location(&self, element: &str) -> Location {
        if self.binary {
            return Location { file: Arc::clone(&self.file), line: 1, column: 1 };
        }
        place(&self.file, &self.text, offset(&self.text, element))
    }

    /// Returns an error about an element.
    pub fn error(&self, element: &str, found: impl Into<String>, expected: &str) -> SceneError {
        let message = format!("{}: {}; {expected}", shown(element), found.into());
        match self.binary {
            true => not_text(&self.file, message),
            false => SceneError::Invalid { at: self.location(element), message },
        }
    }

    /// Returns the error for a part that exceeds the memory budget.
    pub fn too_large(&self, element: &str, refusal: &str) -> SceneError {
        let message = format!(
            "{}: {refusal}; use a smaller scene, a larger 'memory' or a larger machine",
            shown(element)
        );
        SceneError::Limit { at: self.location(element), message }
    }

    /// Adds a warning about an element; further ones of the same message are counted.
    pub fn warn(&self, element: &str, message: &str) {
        let mut warnings = self.warnings.borrow_mut();
        // Only the first is located: to find an element reads the text.
        match warnings.iter_mut().find(|counted| counted.message == message) {
            Some(counted) => counted.more += 1,
            None => warnings.push(CountedWarning {
                message: message.to_owned(),
                first: Warning {
                    at: self.location(element),
                    message: format!("{}: {message}", shown(element)),
                },
                more: 0,
            }),
        }
    }

    /// Returns the first warning of each message, with the number of the others.
    pub fn take_warnings(&self) -> Vec<Warning> {
        let all = self.warnings.take().into_iter();
        all.map(|CountedWarning { first, more, .. }| match more {
            0 => first,
            more => Warning {
                message: format!("{} (and {more} more like this)", first.message),
                ..first
            },
        })
        .collect()
    }
}

/// Returns the location of an offset (bytes) in a text.
fn place(file: &Arc<Path>, text: &str, offset: usize) -> Location {
    let before = &text[..offset];
    let line = before.matches('\n').count() + 1;
    let column = before.rsplit('\n').next().unwrap_or("").chars().count() + 1;
    let [line, column] = [line, column].map(|n| u32::try_from(n).unwrap_or(u32::MAX));
    Location { file: Arc::clone(file), line, column }
}

/// Returns how messages write the path of an element: `meshes[2].primitives[0]`.
fn shown(element: &str) -> String {
    let mut shown = String::new();
    for step in element.split('/') {
        match step.parse::<usize>() {
            Ok(index) => shown.push_str(&format!("[{index}]")),
            Err(_) if shown.is_empty() => shown.push_str(step),
            Err(_) => shown.push_str(&format!(".{step}")),
        }
    }
    shown
}

/// Returns the offset of an element in the text, or that of the last one on its path that is there.
fn offset(text: &str, element: &str) -> usize {
    let mut at = text;
    for step in element.split('/') {
        let next = match step.parse::<usize>() {
            Ok(index) => serde_json::from_str::<Vec<&RawValue>>(at)
                .ok()
                .and_then(|all| all.get(index).copied()),
            Err(_) => serde_json::from_str::<BTreeMap<String, &RawValue>>(at)
                .ok()
                .and_then(|all| all.get(step).copied()),
        };
        match next {
            Some(value) => at = value.get(),
            None => break,
        }
    }
    let start = at.as_ptr() as usize - text.as_ptr() as usize;
    // The text itself may begin with blanks.
    start + if start == 0 { text.len() - text.trim_start().len() } else { 0 }
}

/// Returns the message of an error in JSON without its line and column.
pub(super) fn without_place(error: &serde_json::Error) -> String {
    let message = error.to_string();
    match message.rfind(" at line ") {
        Some(end) => message[..end].to_owned(),
        None => message,
    }
}

pub(super) fn not_text(file: &Arc<Path>, message: impl Into<String>) -> SceneError {
    let at = Location { file: Arc::clone(file), line: 1, column: 1 };
    SceneError::NotText { at, message: message.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn elements_are_found_in_the_text() {
        let text = "\n{ \"a\": [ 1, {\"b\\u0063\": [true]} ],\n \"c\": 2 }";
        for (element, expected) in [
            ("a", "[ 1"),
            ("a/0", "1,"),
            ("a/1", "{\"b"),
            ("a/1/bc/0", "true"),
            ("c", "2 }"),
            // The last one that is there.
            ("a/7", "[ 1"),
            ("x", "{ \"a\""),
        ] {
            assert!(text[offset(text, element)..].starts_with(expected), "{element}");
        }
        assert_eq!(shown("meshes/2/primitives/0/attributes"), "meshes[2].primitives[0].attributes");
    }
}
