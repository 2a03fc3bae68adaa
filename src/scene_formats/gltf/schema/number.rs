//! Integers and indices.
//!
//! An integer may be written with a fraction of 0 or with an exponent, as in `5126.0` and `9.2e1` (glTF
//! 2.0, section 3.1).

use std::fmt;

use serde::de::{Deserialize, Deserializer, Error, Unexpected, Visitor};

/// Magnitude up to which all integers are numbers of f64.
const EXACT: f64 = 9_007_199_254_740_992.0;
/// First index that is too large.
const INDEX_END: f64 = 4_294_967_296.0;

/// A size, a count or a code: an integer of 0 or more.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Integer(pub u64);

/// An index of an element in a list of the document, or of a set of texture coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Index(pub u32);

impl Index {
    /// Returns the index as that of a slice.
    pub fn value(self) -> usize {
        self.0 as usize
    }
}

struct IntegerVisitor;

impl Visitor<'_> for IntegerVisitor {
    type Value = Integer;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("an integer of 0 or more")
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Integer, E> {
        Ok(Integer(value))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Integer, E> {
        // Negative zero is no integer that JSON writes.
        let is_integer = value.fract() == 0.0 && value.is_sign_positive() && value <= EXACT;
        match is_integer {
            true => Ok(Integer(value as u64)),
            false => Err(E::invalid_value(Unexpected::Float(value), &self)),
        }
    }
}

impl<'de> Deserialize<'de> for Integer {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_u64(IntegerVisitor)
    }
}

struct IndexVisitor;

impl Visitor<'_> for IndexVisitor {
    type Value = Index;

    fn expecting(&self, formatter: &mut fmt::Formatter) -> fmt::Result {
        formatter.write_str("an index")
    }

    fn visit_u64<E: Error>(self, value: u64) -> Result<Index, E> {
        u32::try_from(value).map(Index).map_err(|_| too_large(&value))
    }

    fn visit_f64<E: Error>(self, value: f64) -> Result<Index, E> {
        match value {
            INDEX_END.. => Err(too_large(&value)),
            value => self.visit_u64(IntegerVisitor.visit_f64::<E>(value)?.0),
        }
    }
}

impl<'de> Deserialize<'de> for Index {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_u64(IndexVisitor)
    }
}

fn too_large<E: Error>(found: &dyn fmt::Debug) -> E {
    E::custom(format_args!("an index of {found:?}; expected less than 2^32"))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn integers(text: &str) -> Result<Vec<u64>, String> {
        let all: Result<Vec<Integer>, _> = serde_json::from_str(text);
        all.map(|all| all.iter().map(|i| i.0).collect()).map_err(|error| error.to_string())
    }

    fn indices(text: &str) -> Result<Vec<usize>, String> {
        let all: Result<Vec<Index>, _> = serde_json::from_str(text);
        all.map(|all| all.iter().map(|i| i.value()).collect()).map_err(|error| error.to_string())
    }

    #[test]
    fn integers_may_have_a_fraction_of_zero_or_an_exponent() {
        assert_eq!(
            integers("[5126, 5126.0, 5.126e3, 9.2e1, 0.0]"),
            Ok(vec![5126, 5126, 5126, 92, 0])
        );
        assert_eq!(integers("[18446744073709551615]"), Ok(vec![u64::MAX]));
        assert_eq!(indices("[0, 7.0, 1E2, 4294967295]"), Ok(vec![0, 7, 100, 4_294_967_295]));
    }

    #[test]
    fn other_numbers_are_refused_with_their_place() {
        for text in ["[1.5]", "[-1]", "[-0.0]", "[1e300]", "[\"1\"]", "[null]", "[true]"] {
            let error = integers(text).unwrap_err();
            assert!(
                error.contains("expected an integer of 0 or more at line 1"),
                "{text}: {error}"
            );
            assert!(indices(text).is_err(), "{text}");
        }
    }

    #[test]
    fn indices_of_two_to_the_32_and_more_are_refused_as_they_are_written() {
        for large in ["4294967296", "4294967296.0", "18446744073709551615", "1e30"] {
            let error = indices(&format!("[{large}]")).unwrap_err();
            let expected = format!("an index of {large}; expected less than 2^32 at line 1");
            assert!(error.starts_with(&expected), "{error}");
        }
    }
}
