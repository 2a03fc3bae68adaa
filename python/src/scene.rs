//! Scenes.

use std::path::{Path, PathBuf};

use petzval::{Description, ReadContext};
use petzval_scene_formats::read_with;
use pyo3::prelude::*;

use crate::error::scene_error;
use crate::memory::MemorySetting;
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

impl Scene {
    /// Returns the path of its file.
    pub fn file(&self) -> &Path {
        &self.path
    }
}

#[pymethods]
impl Scene {
    /// Reads a scene in the language of pbrt-v4, or in glTF.
    ///
    /// `memory` is the most that it may take: bytes, or a text such as "8GiB". Ctrl-C ends the wait at
    /// once; what was begun ends soon after in the background.
    #[new]
    #[pyo3(signature = (path, memory = None))]
    fn new(py: Python<'_>, path: PathBuf, memory: Option<MemorySetting>) -> PyResult<Self> {
        let context = match memory {
            Some(memory) => ReadContext::with_memory(memory.bytes()?),
            None => ReadContext::default(),
        };
        let (shared, file) = (context.clone(), path.clone());
        let work = move || read_with(&file, &shared);
        let description = worker::run_or_abandon(py, || context.stop(), work)?;
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
