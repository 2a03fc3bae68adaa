//! Scenes.

use std::path::PathBuf;

use petzval::{Description, read_scene};
use pyo3::prelude::*;

use crate::error::scene_error;
use crate::worker;

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
    /// Reads a scene in the language of pbrt-v4, or in glTF.
    #[new]
    fn new(py: Python<'_>, path: PathBuf) -> PyResult<Self> {
        let description = worker::run_whole(py, || read_scene(&path))?;
        let description = description.map_err(|errors| scene_error(&errors))?;
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
