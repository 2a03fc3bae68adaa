//! Arrays that users pass in.

use numpy::{IxDyn, PyArrayDyn, PyArrayMethods, PyReadonlyArrayDyn, ToPyArray};
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

/// Returns an array of the pixels of a picture: height x width x 3, or height x width if it is grey.
pub fn of_picture<'py>(
    py: Python<'py>,
    picture: &Picture,
    grey: bool,
) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
    let [width, height] = picture.size;
    if grey {
        let values: Vec<f32> = picture.pixels.iter().map(|[value, ..]| *value).collect();
        return values.to_pyarray(py).reshape(IxDyn(&[height, width]));
    }
    picture.pixels.as_flattened().to_pyarray(py).reshape(IxDyn(&[height, width, 3]))
}

/// Returns the picture of an array of height x width x 3, or of height x width, and whether it is such a
/// grey one.
pub fn picture(name: &str, value: &Bound<'_, PyAny>) -> PyResult<(Picture, bool)> {
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
            Ok((Picture { size: [width, height], pixels }, false))
        }
        &[height, width] if height * width > 0 => {
            let pixels = array.as_slice()?.iter().map(|value| [*value; 3]).collect();
            Ok((Picture { size: [width, height], pixels }, true))
        }
        shape => Err(value_error(format!(
            "{name}: the array is {}; expected height x width x 3, or height x width",
            shown(shape)
        ))),
    }
}
