//! Lens files: which reader takes which.

use std::io::Read;
use std::path::Path;

use super::error::LensError;
use super::prescription::Prescription;
use super::{dat, foreign, toml};
use crate::source::{note, open};

/// No lens is longer than this; what is longer is no lens.
const MOST_BYTES: usize = 1 << 20;

/// Germanium in the far infrared has 4; nothing that a lens is made of has more than this.
pub(super) const MOST_INDEX: f64 = 10.0;

/// A radius that is shorter than this, mm, a nanometre, is no length that glass is ground to; the power
/// of one that is much shorter is infinite.
pub(super) const LEAST_RADIUS: f64 = 1e-6;

/// Reads a lens: petzval's own format from a `.toml` file, a `.dat` table from any other.
///
/// # Errors
/// Where the file cannot be read or is no lens, with the line.
pub fn read(path: &Path) -> Result<Prescription, LensError> {
    let io = |source| LensError::Io { path: path.to_owned(), source };
    let mut bytes = Vec::new();
    open(path)
        .and_then(|file| file.take(MOST_BYTES as u64 + 1).read_to_end(&mut bytes))
        .map_err(io)?;
    note(path, &bytes);
    if bytes.len() > MOST_BYTES {
        return Err(LensError::Malformed {
            path: path.to_owned(),
            line: 1 + bytes[..MOST_BYTES].iter().filter(|&&byte| byte == b'\n').count(),
            column: None,
            found: "the file goes on past 1 MiB here".into(),
            expected: "a lens is a few short lines".into(),
        });
    }
    if let Some(error) = foreign::refuse(path, &bytes) {
        return Err(error);
    }
    let text = String::from_utf8_lossy(&bytes);
    if path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml")) {
        return toml::parse(path, &text);
    }
    let lines: Vec<&str> = text.trim_start_matches('\u{feff}').lines().collect();
    dat::parse(path, &lines)
}
