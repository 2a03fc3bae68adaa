//! Python package of petzval: lenses, scenes and pictures as NumPy arrays.
//!
//! `petzval/__init__.py` is the public package; this module is its engine. All work that takes time
//! runs without the interpreter's lock.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod argument;
mod array;
mod chart;
mod checkpoint;
mod dataset;
mod error;
mod image;
mod image_quality;
mod job;
mod lens;
mod lens_models;
mod lens_source;
mod measure;
mod memory;
mod passes;
mod picture;
mod scene;
mod scene_arrays;
mod sensor;
mod settings;
mod trace;
mod worker;

use pyo3::prelude::*;

/// Engine of the package petzval.
#[pymodule]
fn _petzval(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<lens::Lens>()?;
    module.add_class::<scene::Scene>()?;
    module.add_class::<scene_arrays::ArrayScene>()?;
    module.add_class::<job::Job>()?;
    module.add_class::<image::Image>()?;
    module.add_class::<passes::Passes>()?;
    module.add_class::<image_quality::ImageQuality>()?;
    module.add_class::<sensor::Sensor>()?;
    module.add_function(wrap_pyfunction!(chart::chart, module)?)?;
    module.add_function(wrap_pyfunction!(dataset::dataset, module)?)?;
    module.add_function(wrap_pyfunction!(job::prepare, module)?)?;
    module.add_function(wrap_pyfunction!(lens_models::lens_models, module)?)?;
    module.add_function(wrap_pyfunction!(measure::measure_edge, module)?)?;
    module.add_function(wrap_pyfunction!(measure::measure_texture, module)?)?;
    module.add_function(wrap_pyfunction!(measure::measure_grid, module)?)?;
    module.add_function(wrap_pyfunction!(measure::measure_greys, module)?)?;
    module.add_function(wrap_pyfunction!(measure::measure_shading, module)?)?;
    module.add_function(wrap_pyfunction!(measure::measure_star, module)?)?;
    module.add_function(wrap_pyfunction!(measure::measure_colours, module)?)?;
    module.add_function(wrap_pyfunction!(measure::measure_noise, module)?)?;
    module.add_function(wrap_pyfunction!(image::read_layers, module)?)?;
    module.add_function(wrap_pyfunction!(picture::compare, module)?)?;
    module.add_function(wrap_pyfunction!(picture::read_image, module)?)?;
    module.add_function(wrap_pyfunction!(picture::develop, module)?)?;
    module.add_function(wrap_pyfunction!(picture::write_image, module)?)?;
    module.add_function(wrap_pyfunction!(scene_arrays::scene_of_arrays, module)?)
}
