//! Measurements of test charts in arrays, and of the noise of a sensor, as JSON.

use std::fmt::Display;
use std::path::PathBuf;

use petzval::Picture;
use petzval_base::io::ReadContext;
use petzval_tools::chart_analysis::{
    ColourPatches, DotGrid, EdgeResponse, GreySteps, Shading, StarChart, StarResponse,
    TextureResponse, luminance,
};
use petzval_tools::sensor_analysis::{ChannelTransfer, ListError, evaluate_file};
use pyo3::prelude::*;
use serde_json::Value;

use crate::array;
use crate::error::{read_error, value_error};
use crate::worker;

/// First column and row of a region, and those that no longer belong to it.
type Region = (i64, i64, i64, i64);

/// Returns a region of a picture.
fn within(region: Region, picture: &Picture) -> PyResult<[[usize; 2]; 2]> {
    let (x0, y0, x1, y1) = region;
    let [width, height] = picture.size;
    let is_within = |low: i64, high: i64, size: usize| {
        (0..high).contains(&low) && usize::try_from(high).is_ok_and(|high| high <= size)
    };
    match is_within(x0, x1, width) && is_within(y0, y1, height) {
        true => Ok([[x0, y0], [x1, y1]].map(|at| at.map(|n| n as usize))),
        false => Err(value_error(format!(
            "region={region:?}: the picture has {width} x {height} pixels; expected x0, y0, x1, y1 within it"
        ))),
    }
}

/// Measures a region of an array, and returns the result as JSON.
fn measure_region<T: Send, E: Display + Send>(
    py: Python<'_>,
    pixels: &Bound<'_, PyAny>,
    region: Region,
    measure: impl FnOnce(&Picture, [[usize; 2]; 2]) -> Result<T, E> + Send,
    json: fn(&T) -> Value,
) -> PyResult<String> {
    let (picture, _) = array::picture("pixels", pixels)?;
    let place = within(region, &picture)?;
    let found = worker::caught(py, || measure(&picture, place))?;
    let found = found.map_err(|error| value_error(format!("region={region:?}: {error}")))?;
    Ok(json(&found).to_string())
}

/// Returns the value of a pixel that is measured: that of a grey picture, or the luminance.
fn value([r, g, b]: [f32; 3]) -> f64 {
    luminance([r, g, b].map(f64::from))
}

#[pyfunction]
pub fn measure_edge(py: Python<'_>, pixels: &Bound<'_, PyAny>, region: Region) -> PyResult<String> {
    let measure = |picture: &Picture, place| EdgeResponse::measure(picture, place, value);
    measure_region(py, pixels, region, measure, EdgeResponse::json)
}

#[pyfunction]
pub fn measure_texture(
    py: Python<'_>,
    pixels: &Bound<'_, PyAny>,
    region: Region,
    chart: &Bound<'_, PyAny>,
    second: Option<&Bound<'_, PyAny>>,
) -> PyResult<String> {
    let (picture, _) = array::picture("pixels", pixels)?;
    let (chart, _) = array::picture("chart", chart)?;
    let place = within(region, &picture)?;
    let second = second.map(|second| array::picture("second", second)).transpose()?;
    let other = second.as_ref().map_or(&picture, |(second, _)| second);
    within(region, other)?;
    let texture =
        worker::caught(py, || TextureResponse::measure([&picture, other], place, &chart, value))?;
    let texture = texture.map_err(|error| value_error(format!("region={region:?}: {error}")))?;
    Ok(texture.json().to_string())
}

#[pyfunction]
pub fn measure_grid(py: Python<'_>, pixels: &Bound<'_, PyAny>) -> PyResult<String> {
    let (picture, _) = array::picture("pixels", pixels)?;
    let grid = worker::caught(py, || DotGrid::measure(&picture))?;
    Ok(grid.map_err(value_error)?.json().to_string())
}

#[pyfunction]
pub fn measure_colours(
    py: Python<'_>,
    pixels: &Bound<'_, PyAny>,
    region: Region,
) -> PyResult<String> {
    measure_region(py, pixels, region, ColourPatches::measure, ColourPatches::json)
}

#[pyfunction]
pub fn measure_star(
    py: Python<'_>,
    pixels: &Bound<'_, PyAny>,
    region: Region,
    cycles: u32,
    modulation: f64,
) -> PyResult<String> {
    if !(8..=720).contains(&cycles) {
        return Err(value_error(format!("cycles={cycles}: expected 8 to 720")));
    }
    if !(0.01..=1.0).contains(&modulation) {
        return Err(value_error(format!("modulation={modulation}: expected 0.01 to 1")));
    }
    let chart = StarChart { cycles: f64::from(cycles), modulation };
    let measure = |picture: &Picture, place| StarResponse::measure(picture, place, chart, value);
    measure_region(py, pixels, region, measure, StarResponse::json)
}

#[pyfunction]
pub fn measure_greys(
    py: Python<'_>,
    pixels: &Bound<'_, PyAny>,
    region: Region,
) -> PyResult<String> {
    measure_region(py, pixels, region, GreySteps::measure, GreySteps::json)
}

#[pyfunction]
pub fn measure_shading(py: Python<'_>, pixels: &Bound<'_, PyAny>) -> PyResult<String> {
    let (picture, _) = array::picture("pixels", pixels)?;
    let shading = worker::caught(py, || Shading::measure(&picture))?;
    Ok(shading.map_err(value_error)?.json().to_string())
}

#[pyfunction]
pub fn measure_noise(py: Python<'_>, list: PathBuf) -> PyResult<String> {
    let channels = worker::caught(py, || evaluate_file(&list, &ReadContext::default()))?;
    let channels = channels.map_err(|error| match &error {
        ListError::Read(error) => read_error(error),
        _ => value_error(error),
    })?;
    Ok(Value::Array(channels.iter().map(ChannelTransfer::json).collect()).to_string())
}
