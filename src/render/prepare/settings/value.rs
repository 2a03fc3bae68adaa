//! Values of settings as front ends give them, and their errors.

use std::fmt;

/// A value of a setting, as a front end gives it.
#[derive(Clone, Debug, PartialEq)]
pub enum SettingValue {
    /// Words of a command line, in which a number may have a unit, such as `43mm`.
    Words(String),
    /// A text of a program or of a file, in which numbers are no texts.
    Text(String),
    /// True or false.
    Flag(bool),
    /// A whole number.
    Whole(i64),
    /// A number, in the unit of the setting.
    Number(f64),
    /// A list.
    List(Vec<Self>),
    /// A value of a type that no setting takes.
    Other,
}

/// Error of a value that a setting does not take. Its text is what the setting expects.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum SettingError {
    /// The value has another type.
    #[error("{0}")]
    Type(String),
    /// The value has the type, but is not sound.
    #[error("{0}")]
    Value(String),
}

impl SettingValue {
    /// Returns the number of a value that is one.
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Number(number) => Some(*number),
            Self::Whole(number) => Some(*number as f64),
            _ => None,
        }
    }

    /// Returns the whole number of a value that is one.
    pub(super) fn whole(&self) -> Option<i64> {
        match self {
            Self::Whole(number) => Some(*number),
            _ => None,
        }
    }

    /// Returns the items of a list of `N` that are all of one type. Words are divided.
    ///
    /// # Errors
    /// Returns an error with the text `expected` for another type or number of items.
    pub(super) fn items<T, const N: usize>(
        &self,
        separator: &str,
        item: impl Fn(&Self) -> Option<T>,
        expected: &str,
    ) -> Result<[T; N], SettingError> {
        let unsound = || SettingError::Value(format!("expected {expected}"));
        let (items, refused) = match self {
            Self::Words(text) => {
                let parts = text.split(separator).map(|part| Self::Words(part.to_owned()));
                (parts.map(|part| item(&part)).collect::<Option<Vec<T>>>(), unsound())
            }
            Self::List(list) => (list.iter().map(item).collect(), type_error(expected)),
            _ => (None, type_error(expected)),
        };
        items.ok_or(refused)?.try_into().map_err(|_| unsound())
    }
}

impl fmt::Display for SettingValue {
    /// Writes equal numbers alike, whole or not.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Words(text) | Self::Text(text) => f.write_str(text),
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Whole(number) => write!(f, "{:?}", *number as f64),
            Self::Number(number) => write!(f, "{number:?}"),
            Self::List(items) => {
                let items: Vec<String> = items.iter().map(Self::to_string).collect();
                f.write_str(&items.join(","))
            }
            Self::Other => f.write_str("?"),
        }
    }
}

/// Returns the error of a value of another type.
pub(super) fn type_error(expected: &str) -> SettingError {
    SettingError::Type(format!("expected {expected}"))
}
