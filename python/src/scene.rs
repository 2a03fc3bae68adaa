//! Scenes.

use std::path::PathBuf;

use petzval::{Description, read_scene};
use pyo3::prelude::*;

use crate::error::{check_readable, value_error};

/// A scene file, read into memory.
///
/// One scene can be rendered many times, with other lenses, focus or film: its geometry and textures
/// are neither read nor copied again.
#[pyclass(frozen, subclass, module = "petzval")]
pub struct Scene {
    pub(crate) description: Description,
    path: PathBuf,
}

#[pymethods]
impl Scene {
    /// Reads a scene in the language of pbrt-v4.
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        check_readable(&path)?;
        let description = py.detach(|| read_scene(&path)).map_err(value_error)?;
        Ok(Self { description, path })
    }

    /// The scene file.
    #[getter]
    fn path(&self) -> PathBuf {
        self.path.clone()
    }

    fn __repr__(&self) -> String {
        format!("Scene({:?})", self.path.display().to_string())
    }
}
