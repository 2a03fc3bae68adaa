//! Pictures of arrays: read, written and compared.

use std::path::PathBuf;

use numpy::{AllowTypeChange, PyArray3, PyArrayLike3, PyArrayMethods, ToPyArray};
use petzval::io::image::PictureWindow;
use petzval::metric::DynamicRange;
use petzval::{EncodingOptions, Metric, Picture, measure};
use pyo3::prelude::*;

use crate::error::{image_error, value_error};
use crate::image::ExposureSetting;

/// An array of pixels of any number type.
type Pixels<'py> = PyArrayLike3<'py, f32, AllowTypeChange>;

/// Returns the picture of an array of height x width x 3.
fn picture(name: &str, pixels: &Pixels<'_>) -> PyResult<Picture> {
    let view = pixels.as_array();
    let (height, width, channels) = view.dim();
    if channels != 3 || height * width == 0 {
        return Err(value_error(format!(
            "{name}: the array is {height} x {width} x {channels}; expected height x width x 3"
        )));
    }
    let pixels = view.rows().into_iter().map(|row| [row[0], row[1], row[2]]).collect();
    Ok(Picture { size: [width, height], pixels })
}

/// Returns how far a picture is from a reference, both linear sRGB, height x width x 3, by a metric:
/// mse, relmse, mape, flip or psnr.
#[pyfunction]
#[pyo3(name = "compare", signature = (picture, reference, metric = "flip"))]
pub fn compare(
    py: Python<'_>,
    picture: Pixels<'_>,
    reference: Pixels<'_>,
    metric: &str,
) -> PyResult<f64> {
    let metric: Metric =
        metric.parse().map_err(|problem| value_error(format!("metric: {problem}")))?;
    let picture = self::picture("picture", &picture)?;
    let reference = self::picture("reference", &reference)?;
    let measured = py.detach(|| measure(metric, &picture, &reference, DynamicRange::High));
    Ok(measured.map_err(value_error)?.value)
}

/// Reads a picture as an array of float32, height x width x 3, linear sRGB.
#[pyfunction]
pub fn read_image<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyArray3<f32>>> {
    let picture = py.detach(|| Picture::read(&path)).map_err(|error| image_error(&error))?;
    let [width, height] = picture.size;
    picture.pixels.as_flattened().to_pyarray(py).reshape([height, width, 3])
}

/// Writes an array of linear sRGB, height x width x 3: .exr, .png or .jpg.
#[pyfunction]
#[pyo3(signature = (path, pixels, exposure = ExposureSetting::Stops(0.0)))]
pub fn write_image(
    py: Python<'_>,
    path: PathBuf,
    pixels: Pixels<'_>,
    exposure: ExposureSetting,
) -> PyResult<()> {
    let picture = picture("pixels", &pixels)?;
    let encoding = EncodingOptions { exposure: exposure.exposure()?, ..EncodingOptions::default() };
    let frame = picture.size.map(|side| side as u32);
    let window = PictureWindow { origin: [0, 0], frame };
    py.detach(|| picture.write(&path, window, encoding, &Vec::new()))
        .map_err(|error| image_error(&error))
}
