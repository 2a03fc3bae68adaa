//! Files, rows and glass catalogues of lenses, as Python gives them.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use petzval::ReadContext;
use pyo3::prelude::*;

use crate::argument::{Listed, refused};

/// A surface of a table: radius (0: plane), distance to the next, index behind it, diameter.
pub type TableRow = [f64; 4];

/// Where a lens comes from.
pub enum LensSource {
    /// A lens file.
    File(PathBuf),
    /// Rows.
    Table(Vec<TableRow>),
}

impl<'py> FromPyObject<'_, 'py> for LensSource {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(path) = value.extract() {
            return Ok(Self::File(path));
        }
        let expected = "a path, or rows (radius, thickness, index, diameter)";
        let rows = value.extract().map_err(|error| refused("path", &value, expected, error));
        rows.map(|Listed(rows)| Self::Table(rows))
    }
}

/// The file of a lens, which renders read again.
#[derive(Clone)]
pub enum LensFile {
    /// On disk.
    Path(PathBuf),
    /// In memory: the text of a lens that was given as a table.
    Table(Arc<[u8]>),
}

/// Name of tables in messages and among the inputs of a picture.
const TABLE: &str = "the lens table";

impl LensFile {
    /// Returns the path by which readers find it in the context of [`Self::attach`].
    pub fn path(&self) -> &Path {
        match self {
            Self::Path(path) => path,
            Self::Table(_) => Path::new(TABLE),
        }
    }

    /// Returns the path of a file on disk.
    pub fn on_disk(&self) -> Option<&Path> {
        match self {
            Self::Path(path) => Some(path),
            Self::Table(_) => None,
        }
    }

    /// Returns the context with the file, if it is in memory.
    pub fn attach(&self, context: ReadContext) -> ReadContext {
        match self {
            Self::Path(_) => context,
            Self::Table(text) => context.with_lens(TABLE.into(), text.clone()),
        }
    }
}

/// Glass catalogues: a path, or a list of them.
pub enum CatalogueSetting {
    /// One.
    One(PathBuf),
    /// A list.
    List(Vec<PathBuf>),
}

impl Default for CatalogueSetting {
    fn default() -> Self {
        Self::List(Vec::new())
    }
}

impl<'py> FromPyObject<'_, 'py> for CatalogueSetting {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(path) = value.extract() {
            return Ok(Self::One(path));
        }
        let refused = |error| refused("catalogue", &value, Self::EXPECTED, error);
        value.extract().map(|Listed(paths)| Self::List(paths)).map_err(refused)
    }
}

impl CatalogueSetting {
    /// Expected of the argument.
    pub const EXPECTED: &str = "the path of a glass catalogue, or a list of paths";

    pub fn paths(&self) -> Vec<PathBuf> {
        match self {
            Self::One(path) => vec![path.clone()],
            Self::List(paths) => paths.clone(),
        }
    }
}
