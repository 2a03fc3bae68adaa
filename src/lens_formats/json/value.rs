//! JSON values with their places.

use crate::text::Line;
use petzval_base::io::excerpt;
use petzval_lens::LensError;

/// A value and its place.
#[derive(Clone, Debug)]
pub(super) struct Json<'a> {
    /// The line in which the value begins.
    pub line: Line<'a>,
    /// The text of the value from its first character to the end of that line.
    pub word: &'a str,
    /// Its content.
    pub content: Content<'a>,
}

/// Content of a value.
#[derive(Clone, Debug)]
pub(super) enum Content<'a> {
    Null,
    Bool(bool),
    Number(f64),
    Text(String),
    List(Vec<Json<'a>>),
    /// Members in the order of the file.
    Object(Vec<(String, Json<'a>)>),
}

impl<'a> Json<'a> {
    /// Returns an error at this value.
    pub fn error(&self, found: impl Into<String>, expected: &str) -> LensError {
        self.line.error(self.word, found, expected)
    }

    /// Returns a member of an object; `None` if it is absent or null.
    pub fn get(&self, name: &str) -> Option<&Self> {
        let Content::Object(members) = &self.content else { return None };
        let member = members.iter().find(|(key, _)| key == name).map(|(_, value)| value)?;
        (!matches!(member.content, Content::Null)).then_some(member)
    }

    /// Returns the first member of one of these names.
    pub fn any(&self, names: &[&str]) -> Option<&Self> {
        names.iter().find_map(|name| self.get(name))
    }

    /// Returns a member of an object.
    ///
    /// # Errors
    /// Returns an error if there is none.
    pub fn need(&self, name: &str) -> Result<&Self, LensError> {
        let expected = format!("expected a member \"{name}\"");
        self.get(name).ok_or_else(|| self.error(format!("no \"{name}\""), &expected))
    }

    /// Returns the members of an object; none of any other value.
    pub fn members(&self) -> &[(String, Self)] {
        match &self.content {
            Content::Object(members) => members,
            _ => &[],
        }
    }

    /// Returns the values of a list.
    ///
    /// # Errors
    /// Returns an error if this is no list.
    pub fn list(&self) -> Result<&[Self], LensError> {
        match &self.content {
            Content::List(list) => Ok(list),
            _ => Err(self.error(self.kind(), "expected a list")),
        }
    }

    /// Returns a finite number; a text that is one counts as such.
    ///
    /// # Errors
    /// Returns an error if this is none.
    pub fn number(&self) -> Result<f64, LensError> {
        match self.any_number() {
            Some(number) if number.is_finite() => Ok(number),
            _ => {
                Err(self.error(format!("{} is no finite number", self.kind()), "expected a number"))
            }
        }
    }

    /// Returns a number that may be infinite.
    ///
    /// # Errors
    /// Returns an error if this is none.
    pub fn number_or_infinity(&self) -> Result<f64, LensError> {
        match self.any_number() {
            Some(number) if !number.is_nan() => Ok(number),
            _ => Err(self.error(format!("{} is no number", self.kind()), "expected a number")),
        }
    }

    fn any_number(&self) -> Option<f64> {
        match &self.content {
            Content::Number(number) => Some(*number),
            Content::Text(text) => text.trim().parse().ok(),
            _ => None,
        }
    }

    /// Returns the numbers of a list, or the one number.
    ///
    /// # Errors
    /// Returns an error if one is not finite.
    pub fn numbers(&self) -> Result<Vec<f64>, LensError> {
        match &self.content {
            Content::List(list) => list.iter().map(Self::number).collect(),
            _ => Ok(vec![self.number()?]),
        }
    }

    /// Returns the text, if it is one.
    pub fn text(&self) -> Option<&str> {
        match &self.content {
            Content::Text(text) => Some(text),
            _ => None,
        }
    }

    /// Returns whether this is `true`.
    pub fn is_true(&self) -> bool {
        matches!(self.content, Content::Bool(true))
    }

    fn kind(&self) -> String {
        match &self.content {
            Content::Null => "null".to_owned(),
            Content::Bool(value) => value.to_string(),
            Content::Number(number) => number.to_string(),
            Content::Text(text) => format!("\"{}\"", excerpt(text)),
            Content::List(_) => "a list".to_owned(),
            Content::Object(_) => "an object".to_owned(),
        }
    }
}
