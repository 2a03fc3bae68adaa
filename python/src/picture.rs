//! Pictures of arrays: read, written and compared.

use std::path::PathBuf;

use numpy::PyArrayDyn;
use petzval::{EncodingOptions, Metric, Picture, measure};
use petzval_base::io::{FileLog, OutputFile, ReadContext};
use petzval_image::{PictureWindow, RawFile, WhiteBalance};
use petzval_tools::metric::DynamicRange;
use pyo3::prelude::*;

use crate::array;
use crate::error::{image_error, value_error, warn};
use crate::image::{ExposureSetting, bits_of};
use crate::worker;

/// Returns how far a picture is from a reference, both linear sRGB, height x width x 3, or height x width
/// if they are grey, by a metric: mse, relmse, mape, flip or psnr. `dynamic_range` is "high", or "low" for pictures that were clipped
/// to 0 to 1, of which flip and psnr depend on it.
#[pyfunction]
#[pyo3(name = "compare", signature = (picture, reference, metric = "flip", dynamic_range = "high"))]
pub fn compare(
    py: Python<'_>,
    picture: &Bound<'_, PyAny>,
    reference: &Bound<'_, PyAny>,
    metric: &str,
    dynamic_range: &str,
) -> PyResult<f64> {
    let metric: Metric =
        metric.parse().map_err(|problem| value_error(format!("metric: {problem}")))?;
    let (picture, _) = array::picture("picture", picture)?;
    let (reference, _) = array::picture("reference", reference)?;
    let range = match dynamic_range {
        "high" => DynamicRange::High,
        "low" => DynamicRange::Low,
        other => {
            let expected = "expected \"high\" or \"low\"";
            return Err(value_error(format!("dynamic_range={other:?}: {expected}")));
        }
    };
    for (name, picture) in [("picture", &picture), ("reference", &reference)] {
        let bad = picture.pixels.iter().position(|pixel| !pixel.iter().all(|v| v.is_finite()));
        if let Some(i) = bad {
            let [x, y] = [i % picture.size[0], i / picture.size[0]];
            return Err(value_error(format!("{name}: the pixel {x}, {y} is not finite")));
        }
    }
    let measured = worker::caught(py, || measure(metric, &picture, &reference, range))?;
    Ok(measured.map_err(value_error)?.value)
}

/// Reads a picture as an array of float32, height x width x 3, linear sRGB. A file of one channel, such as
/// that of a mosaic, gives height x width.
#[pyfunction]
pub fn read_image<'py>(py: Python<'py>, path: PathBuf) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
    let read = py.detach(|| Picture::read_with_grey(&path));
    let (picture, grey) = read.map_err(|error| image_error(&error))?;
    array::of_picture(py, &picture, grey)
}

/// Develops a raw file (.dng): levels, gain map, white balance, demosaicking, colours. Returns an array of float32, height x
/// width x 3, linear sRGB; height x width for a sensor without filters. `white_balance` is "as-shot", "auto", a
/// temperature such as "3200K", an illuminant such as "D65", or chromaticities "x,y".
#[pyfunction]
#[pyo3(signature = (path, white_balance = RawFile::AS_SHOT))]
pub fn develop<'py>(
    py: Python<'py>,
    path: PathBuf,
    white_balance: &str,
) -> PyResult<Bound<'py, PyArrayDyn<f32>>> {
    let white = WhiteBalance::parse(white_balance, RawFile::AS_SHOT)
        .map_err(|error| value_error(format!("white_balance: {error}, found {white_balance:?}")))?;
    let developed = py.detach(|| {
        let raw =
            RawFile::read(&path, &ReadContext::default()).map_err(|error| image_error(&error))?;
        raw.develop(white).map_err(|error| value_error(format!("{}: {error}", path.display())))
    })?;
    if !developed.left_out.is_empty() {
        let names = developed.left_out.join(", ");
        let text = format!("{} asks for corrections that are left out: {names}", path.display());
        warn(py, &text)?;
    }
    array::of_picture(py, &developed.picture, developed.white.is_none())
}

/// Writes an array of linear sRGB, height x width x 3: .exr, .png, .jpg or .tif. One of height x width makes a
/// file of one channel, `Y` in EXR. `bit_depth` is that of PNG, 8 by default, or 16.
#[pyfunction]
#[pyo3(signature = (path, pixels, exposure = ExposureSetting::Stops(0.0), bit_depth = None))]
pub fn write_image(
    py: Python<'_>,
    path: PathBuf,
    pixels: &Bound<'_, PyAny>,
    exposure: ExposureSetting,
    bit_depth: Option<u32>,
) -> PyResult<()> {
    let (picture, grey) = array::picture("pixels", pixels)?;
    let exposure = exposure.exposure()?;
    let bit_depth = bit_depth.map(bits_of).transpose()?;
    let encoding = EncodingOptions { exposure, bit_depth, grey, ..EncodingOptions::default() };
    let frame = picture.size.map(|side| side as u32);
    let window = PictureWindow { origin: [0, 0], frame };
    // The array is all that it is made of.
    let file = OutputFile::new(path, &FileLog::default()).map_err(value_error)?;
    py.detach(|| picture.write(&file, window, encoding, &Vec::new()))
        .map_err(|error| image_error(&error))
}
