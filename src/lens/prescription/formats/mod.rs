//! Readers of lens files, chosen by extension and content.

pub(crate) mod dat;
pub(crate) mod toml;
pub(crate) mod unsupported;

use std::io::Read;
use std::path::Path;

use super::Prescription;
use super::error::LensError;
use crate::io::{ReadContext, open};

/// Largest size of a lens file (bytes).
const MAX_BYTES: usize = 1 << 20;

/// Largest refractive index. Germanium in the far infrared has 4.
pub(crate) const MAX_INDEX: f64 = 10.0;

/// Smallest radius of curvature [mm]: a nanometre. The power of a much smaller one overflows.
pub(crate) const MIN_RADIUS: f64 = 1e-6;

/// Reads a lens: petzval's own format from a `.toml` file, a `.dat` table from any other.
///
/// # Errors
/// Returns an error if the file cannot be read or is not a lens, with the line.
pub fn read(path: &Path) -> Result<Prescription, LensError> {
    read_with(path, &ReadContext::default())
}

/// Reads a lens, and logs its files.
///
/// # Errors
/// Returns an error if the file cannot be read or is not a lens, with the line.
pub fn read_with(path: &Path, context: &ReadContext) -> Result<Prescription, LensError> {
    let io = |source| LensError::Io { path: path.to_owned(), source };
    let mut bytes = Vec::new();
    open(path)
        .and_then(|file| file.take(MAX_BYTES as u64 + 1).read_to_end(&mut bytes))
        .map_err(io)?;
    context.log(path, &bytes);
    if bytes.len() > MAX_BYTES {
        return Err(LensError::Malformed {
            path: path.to_owned(),
            line: 1 + bytes[..MAX_BYTES].iter().filter(|&&byte| byte == b'\n').count(),
            column: None,
            found: "the file is larger than 1 MiB".into(),
            expected: "expected a lens file of a few short lines".into(),
        });
    }
    if let Some(error) = unsupported::reject(path, &bytes) {
        return Err(error);
    }
    let text = String::from_utf8_lossy(&bytes);
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
        return toml::parse_with(path, &text, context);
    }
    let lines: Vec<&str> = text.trim_start_matches('\u{feff}').lines().collect();
    dat::parse(path, &lines)
}
