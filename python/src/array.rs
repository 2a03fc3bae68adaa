//! Arrays that users pass in.

use numpy::{PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn};
use petzval::Picture;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::error::value_error;

/// Returns an array of numbers as float32 in C order, copied only if it is something else.
pub fn floats<'py>(
    name: &str,
    value: &Bound<'py, PyAny>,
) -> PyResult<PyReadonlyArrayDyn<'py, f32>> {
    let numpy = value.py().import("numpy")?;
    let array = numpy.call_method1("asarray", (value,))?;
    let kind: String = array.getattr("dtype")?.getattr("kind")?.extract()?;
    if !["f", "i", "u", "b"].contains(&kind.as_str()) {
        let found = array.getattr("dtype")?;
        return Err(PyTypeError::new_err(format!(
            "{name}: the array is of {found}; expected real numbers"
        )));
    }
    let array = numpy.call_method1("require", (array, "float32", ["C", "A"]))?;
    let array = array.cast_into::<PyArrayDyn<f32>>()?;
    array.try_readonly().map_err(|error| value_error(format!("{name}: {error}")))
}

/// Returns how messages write a shape: `3 x 4`.
pub fn shown(shape: &[usize]) -> String {
    shape.iter().map(usize::to_string).collect::<Vec<_>>().join(" x ")
}

/// Returns the number of columns of an array of 3 x N.
pub fn columns(name: &str, array: &PyReadonlyArrayDyn<'_, f32>) -> PyResult<usize> {
    match array.as_array().shape() {
        [3, count] => Ok(*count),
        shape => Err(value_error(format!("{name}: the array is {}; expected 3 x N", shown(shape)))),
    }
}

/// Returns the picture of an array of height x width x 3.
pub fn picture(name: &str, value: &Bound<'_, PyAny>) -> PyResult<Picture> {
    let kind = value.py().import("numpy")?.call_method1("asarray", (value,))?;
    let kind = kind.getattr("dtype")?;
    if kind.getattr("kind")?.extract::<String>()? != "f" {
        return Err(PyTypeError::new_err(format!(
            "{name}: the array is of {kind}; expected floats of linear light"
        )));
    }
    let array = floats(name, value)?;
    match array.as_array().shape() {
        &[height, width, 3] if height * width > 0 => {
            let pixels = array.as_slice()?.as_chunks::<3>().0.to_vec();
            Ok(Picture { size: [width, height], pixels })
        }
        shape => Err(value_error(format!(
            "{name}: the array is {}; expected height x width x 3",
            shown(shape)
        ))),
    }
}
