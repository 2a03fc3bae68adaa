//! Scenes.

use std::path::{Path, PathBuf};

use petzval::{Description, ReadContext};
use petzval_scene_formats::read_with;
use pyo3::prelude::*;

use crate::error::scene_error;
use crate::memory::MemorySetting;
use crate::scene_arrays::ArrayScene;
use crate::worker;

/// A scene in memory: a file that was read, or arrays.
///
/// One scene can be rendered many times, with other lenses, focus or film: its geometry and textures
/// are neither read nor copied again.
#[pyclass(frozen, subclass, module = "petzval")]
pub struct Scene {
    pub(crate) description: Description,
    path: Option<PathBuf>,
}

impl Scene {
    /// Returns the path of its file, if there is one.
    pub fn file(&self) -> Option<&Path> {
        self.path.as_deref()
    }
}

/// The source of a scene.
enum SceneSource {
    File(PathBuf),
    Arrays(Box<Description>),
}

impl<'py> FromPyObject<'_, 'py> for SceneSource {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        match value.cast::<ArrayScene>() {
            Ok(arrays) => Ok(Self::Arrays(Box::new(arrays.get().description.clone()))),
            Err(_) => value.extract().map(Self::File),
        }
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
    fn new(py: Python<'_>, path: SceneSource, memory: Option<MemorySetting>) -> PyResult<Self> {
        let path = match path {
            SceneSource::File(path) => path,
            SceneSource::Arrays(description) => {
                return Ok(Self { description: *description, path: None });
            }
        };
        let context = match memory {
            Some(memory) => ReadContext::with_memory(memory.bytes()?),
            None => ReadContext::default(),
        };
        let (shared, file) = (context.clone(), path.clone());
        let work = move || read_with(&file, &shared);
        let description = worker::run_or_abandon(py, || context.stop(), work)?;
        let description = description.map_err(|errors| scene_error(&errors))?;
        Ok(Self { description, path: Some(path) })
    }

    /// The scene file; `None` if the scene is one of arrays.
    #[getter]
    fn path(&self) -> Option<PathBuf> {
        self.path.clone()
    }

    fn __repr__(&self) -> String {
        match &self.path {
            Some(path) => format!("Scene({:?})", path.display().to_string()),
            None => "<Scene of arrays>".to_owned(),
        }
    }
}
