//! Parameter lists, `"type name" [ values ]`, and typed access to their values.

use std::path::Path;
use std::sync::Arc;

use super::{SceneError, suggestion_or};
use petzval_base::io::{Location, ReadContext, hint};
use petzval_spectrum::ColourSpace;

/// The values of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Values {
    Numbers(Vec<f64>),
    Texts(Vec<String>),
    Booleans(Vec<bool>),
}

impl Values {
    /// Returns the type of a parameter whose declaration has none.
    pub(super) fn kind(&self) -> &'static str {
        match self {
            Self::Numbers(_) => "float",
            Self::Texts(_) => "string",
            Self::Booleans(_) => "bool",
        }
    }
}

/// A parameter.
#[derive(Clone, Debug)]
pub(super) struct Param {
    /// The type: one of [`KINDS`].
    pub(super) kind: String,
    pub(super) name: String,
    pub(super) values: Values,
    pub(super) at: Location,
}

/// The types of parameters, and the number of numbers in one value of each; 0 if it varies.
const KINDS: &[(&str, usize)] = &[
    ("integer", 1),
    ("float", 1),
    ("point2", 2),
    ("vector2", 2),
    ("point3", 3),
    ("vector3", 3),
    ("normal", 3),
    ("rgb", 3),
    ("xyz", 3),
    ("blackbody", 0),
    ("spectrum", 0),
    ("bool", 0),
    ("string", 0),
    ("texture", 0),
];

/// Returns the canonical name of a type: pbrt-v2 and v4 have several for some.
pub(super) fn kind_of(word: &str) -> Option<&'static str> {
    let word = match word {
        "point" => "point3",
        "vector" => "vector3",
        "normal3" => "normal",
        "color" => "rgb",
        other => other,
    };
    KINDS.iter().map(|(kind, _)| *kind).find(|kind| *kind == word)
}

/// Returns "; did you mean ...?" for an unknown type, or the types.
pub(super) fn kind_hint(word: &str) -> String {
    let kinds: Vec<&str> = KINDS.iter().map(|(kind, _)| *kind).collect();
    let hint = hint(word, kinds.iter().copied());
    suggestion_or(hint, &format!("expected one of {}", kinds.join(", ")))
}

/// The parameters of a directive.
#[derive(Clone, Debug)]
pub(super) struct Params {
    pub(super) all: Vec<Param>,
    /// The location of the directive.
    pub(super) at: Location,
    /// The space of its `rgb` colours.
    pub(super) space: ColourSpace,
    /// The folder to which its file names are relative.
    pub(super) folder: Arc<Path>,
    /// The memory budget and file log of the scene.
    pub(super) context: ReadContext,
}

impl Params {
    /// Returns the parameter of this name. The last of several counts, as in pbrt-v4.
    pub(super) fn find(&self, name: &str) -> Option<&Param> {
        self.all.iter().rev().find(|param| param.name == name)
    }

    /// Returns the numbers of a parameter of one of these types. Their number is a multiple of that
    /// of one value.
    pub(super) fn numbers(
        &self,
        name: &str,
        kinds: &[&'static str],
    ) -> Result<Option<&[f64]>, SceneError> {
        let Some(param) = self.find(name) else { return Ok(None) };
        let Values::Numbers(numbers) = &param.values else {
            return Err(param.wrong_type(kinds));
        };
        if !kinds.contains(&param.kind.as_str()) {
            return Err(param.wrong_type(kinds));
        }
        let each = KINDS.iter().find(|(kind, _)| *kind == param.kind).map_or(1, |(_, n)| *n);
        if numbers.is_empty() || (each > 1 && numbers.len() % each != 0) {
            return Err(SceneError::at(
                param.at.clone(),
                format!("{} numbers for \"{} {}\"", numbers.len(), param.kind, param.name),
                format!("expected a positive multiple of {each}"),
            ));
        }
        Ok(Some(numbers))
    }

    /// Returns a number, or the default if it is not given.
    pub(super) fn float(&self, name: &str, default: f64) -> Result<f64, SceneError> {
        Ok(self.maybe_float(name)?.unwrap_or(default))
    }

    /// Returns a number, if it is given.
    pub(super) fn maybe_float(&self, name: &str) -> Result<Option<f64>, SceneError> {
        let Some(numbers) = self.numbers(name, &["float", "integer"])? else { return Ok(None) };
        match numbers {
            [number] => Ok(Some(*number)),
            _ => Err(self.wrong_count(name, numbers.len(), "one number")),
        }
    }

    /// Returns a number above 0, or the default if it is not given.
    pub(super) fn positive(&self, name: &str, default: f64) -> Result<f64, SceneError> {
        let value = self.float(name, default)?;
        if value > 0.0 {
            return Ok(value);
        }
        Err(self.refuse(name, format!("\"{name}\" is {value}"), "expected more than 0"))
    }

    /// Returns a whole number from 1 to a limit, if it is given.
    pub(super) fn count(&self, name: &str, most: u32) -> Result<Option<u32>, SceneError> {
        let Some(number) = self.maybe_float(name)? else { return Ok(None) };
        if number.fract() == 0.0 && (1.0..=f64::from(most)).contains(&number) {
            return Ok(Some(number as u32));
        }
        let expected = format!("expected a whole number from 1 to {most}");
        Err(self.refuse(name, format!("\"{name}\" is {number}"), expected))
    }

    /// Returns a seed, if it is given: the low 32 bits of any whole number.
    pub(super) fn seed(&self, name: &str) -> Result<Option<u32>, SceneError> {
        let Some(number) = self.maybe_float(name)? else { return Ok(None) };
        if number.fract() == 0.0 && number.abs() < 9e15 {
            return Ok(Some(number as i64 as u32));
        }
        Err(self.refuse(name, format!("\"{name}\" is {number}"), "expected a whole number"))
    }

    /// Returns three numbers, if they are given.
    pub(super) fn triple(&self, name: &str) -> Result<Option<[f64; 3]>, SceneError> {
        let Some(numbers) = self.numbers(name, &["point3", "vector3", "float"])? else {
            return Ok(None);
        };
        match *numbers {
            [x, y, z] => Ok(Some([x, y, z])),
            _ => Err(self.wrong_count(name, numbers.len(), "three numbers")),
        }
    }

    /// Returns a string of type `string`, if it is given.
    pub(super) fn text(&self, name: &str) -> Result<Option<&str>, SceneError> {
        self.one_text(name, "string")
    }

    /// Returns the strings of a parameter of type `string`, if it is given.
    pub(super) fn texts(&self, name: &str) -> Result<Option<&[String]>, SceneError> {
        let Some(param) = self.find(name) else { return Ok(None) };
        match &param.values {
            Values::Texts(texts) if param.kind == "string" => Ok(Some(texts)),
            _ => Err(param.wrong_type(&["string"])),
        }
    }

    /// Returns the name of a texture, if a parameter is of type `texture`.
    pub(super) fn texture(&self, name: &str) -> Result<Option<&str>, SceneError> {
        match self.find(name) {
            Some(param) if param.kind == "texture" => self.one_text(name, "texture"),
            _ => Ok(None),
        }
    }

    fn one_text(&self, name: &str, kind: &'static str) -> Result<Option<&str>, SceneError> {
        let Some(param) = self.find(name) else { return Ok(None) };
        match &param.values {
            Values::Texts(texts) if param.kind == kind => match &texts[..] {
                [text] => Ok(Some(text)),
                _ => Err(self.wrong_count(name, texts.len(), "one string")),
            },
            _ => Err(param.wrong_type(&[kind])),
        }
    }

    /// Returns a boolean, if it is given. pbrt-v2 writes it as a string.
    pub(super) fn boolean(&self, name: &str) -> Result<Option<bool>, SceneError> {
        let Some(param) = self.find(name) else { return Ok(None) };
        match &param.values {
            Values::Booleans(values) if values.len() == 1 => Ok(Some(values[0])),
            Values::Texts(texts) if texts == &["true"] => Ok(Some(true)),
            Values::Texts(texts) if texts == &["false"] => Ok(Some(false)),
            _ => Err(param.wrong_type(&["bool"])),
        }
    }

    /// Returns an error at a parameter, or at the directive if it is not given.
    pub(super) fn refuse(
        &self,
        name: &str,
        found: impl Into<String>,
        expected: impl Into<String>,
    ) -> SceneError {
        SceneError::at(self.location(name), found, expected)
    }

    /// Returns the location of a parameter, or of the directive if it is not given.
    pub(super) fn location(&self, name: &str) -> Location {
        self.find(name).map_or(&self.at, |param| &param.at).clone()
    }

    pub(super) fn wrong_count(&self, name: &str, found: usize, expected: &str) -> SceneError {
        self.refuse(name, format!("{found} values for \"{name}\""), format!("expected {expected}"))
    }
}

impl Param {
    /// Returns the error for a parameter of the wrong type.
    pub(super) fn wrong_type(&self, kinds: &[&'static str]) -> SceneError {
        let kinds = kinds.join(" or ");
        SceneError::at(
            self.at.clone(),
            format!("\"{} {}\" with these values", self.kind, self.name),
            format!("expected \"{}\" of type {kinds}", self.name),
        )
    }
}
