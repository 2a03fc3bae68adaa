//! Messages about arguments of the wrong type or size.

use pyo3::exceptions::{PyOverflowError, PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyFrozenSet, PySet, PyString};

/// Most items of a list. An iterator may have no end.
const MOST_ITEMS: usize = 1 << 20;

/// Longest text of a value that a message repeats (characters).
const LONGEST: usize = 60;

/// Returns the exception of an argument that cannot be converted: `fstop='f/4': expected a number`.
/// Numbers that do not fit and sequences of another length raise `ValueError`, others `TypeError`.
pub fn refused(name: &str, value: &Bound<'_, PyAny>, expected: &str, error: PyErr) -> PyErr {
    let py = value.py();
    let Some(message) = about(name, value, &format!("expected {expected}")) else { return error };
    if error.is_instance_of::<PyTypeError>(py) {
        return PyTypeError::new_err(message);
    }
    match error.is_instance_of::<PyValueError>(py) || error.is_instance_of::<PyOverflowError>(py) {
        true => PyValueError::new_err(message),
        // An exception of the user's own object.
        false => error,
    }
}

/// Returns a message about an argument, such as `fstop='f/4': expected a number`; `None` if the value
/// cannot be shown.
pub fn about(name: &str, value: &Bound<'_, PyAny>, problem: &str) -> Option<String> {
    let shown = value.repr().ok()?.to_string();
    let shown = match shown.char_indices().nth(LONGEST) {
        Some((end, _)) => format!("{} ...", &shown[..end]),
        None => shown,
    };
    Some(format!("{name}={shown}: {problem}"))
}

/// Returns a value of a dictionary of settings. `expected` is what messages ask for.
pub fn setting<'py, T>(
    settings: &Bound<'py, PyDict>,
    name: &'static str,
    expected: &str,
) -> PyResult<T>
where
    T: for<'a> FromPyObject<'a, 'py>,
{
    let value = settings.as_any().get_item(name)?;
    value.extract().map_err(|error| refused(name, &value, expected, T::Error::into(error)))
}

/// Items of a list or of another ordered collection. Its own statement of its length is not trusted, as
/// that of PyO3's lists is, which reserve so much memory.
pub struct Listed<T>(pub Vec<T>);

impl<'py, T> FromPyObject<'_, 'py> for Listed<T>
where
    T: for<'a> FromPyObject<'a, 'py>,
{
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        let unordered = value.is_instance_of::<PyDict>()
            || value.is_instance_of::<PySet>()
            || value.is_instance_of::<PyFrozenSet>();
        if unordered || value.is_instance_of::<PyString>() {
            return Err(PyTypeError::new_err("expected a list"));
        }
        let mut items = Vec::new();
        for item in value.try_iter()? {
            if items.len() == MOST_ITEMS {
                let problem = format!("expected a list of at most {MOST_ITEMS} items");
                return Err(PyValueError::new_err(problem));
            }
            items.push(item?.extract().map_err(T::Error::into)?);
        }
        Ok(Self(items))
    }
}
