//! Memory limit of a render.

use petzval_base::io::ByteSize;
use petzval_image::ImageFormat;
use petzval_render::memory::{Estimate, MemoryTask, machine};
use pyo3::exceptions::PyMemoryError;
use pyo3::prelude::*;

use crate::argument::refused;
use crate::error::value_error;

/// A limit: bytes, or a text such as "8GiB".
pub enum MemorySetting {
    /// Bytes.
    Bytes(u64),
    /// A number with its unit.
    Text(String),
}

impl<'py> FromPyObject<'_, 'py> for MemorySetting {
    type Error = PyErr;

    fn extract(value: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(text) = value.extract() {
            return Ok(Self::Text(text));
        }
        let expected = "a whole number of bytes, or a text such as \"8GiB\"";
        let bytes = value.extract().map_err(|error| refused("memory", &value, expected, error));
        bytes.map(Self::Bytes)
    }
}

impl MemorySetting {
    pub fn bytes(&self) -> PyResult<u64> {
        match self {
            Self::Bytes(bytes) => Ok(*bytes),
            Self::Text(text) => match text.parse::<ByteSize>() {
                Ok(size) => Ok(size.0),
                Err(problem) => Err(value_error(format!("memory={text:?}: {problem}"))),
            },
        }
    }
}

/// Checks that a render is expected to stay below a limit.
pub fn check(job: &petzval::Job, threads: usize, limit: &MemorySetting) -> PyResult<()> {
    let most = limit.bytes()?;
    let threads = if threads == 0 { machine::cores() } else { threads };
    let task = MemoryTask::Render { threads };
    let estimate = Estimate::new(job, machine::resident(), task, Some(ImageFormat::Exr));
    // Pictures and layers become arrays while they are still there.
    let channels = 3 + petzval_render::aov::channels(&job.layer_request()) as u64;
    let pixels = job.frame.size().map(u64::from).iter().product::<u64>();
    let estimate = estimate.with_extra("arrays", 4 * pixels * channels);
    match estimate.bytes() > most {
        true => Err(PyMemoryError::new_err(format!(
            "this takes {estimate}, and memory allows {}; to take less, use a smaller resolution, \
             parts of the picture with crop, fewer layers or fewer threads",
            ByteSize(most)
        ))),
        false => Ok(()),
    }
}
