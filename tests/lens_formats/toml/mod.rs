//! Lens files in TOML: the meaning of every key, the errors, and the lenses of the repository.

mod coatings;
mod errors;
mod keys;
mod lenses;

use std::path::Path;

use petzval_lens::{LensError, Prescription};
use petzval_lens_formats::parse_toml;

fn parsed(text: &str) -> Result<Prescription, LensError> {
    parse_toml(Path::new("test.toml"), text)
}

/// Reads a singlet whose front surface has these keys, with a stop behind it.
fn singlet(keys: &str) -> Result<Prescription, LensError> {
    parsed(&format!(
        "[[surface]]\n{keys}\n[[surface]]\nradius = -30\nthickness = 1\ndiameter = 8\n\
         [[surface]]\nstop = true\ndiameter = 6\n"
    ))
}

/// Reads a singlet with a stop of these keys behind it.
fn stopped(keys: &str) -> Result<Prescription, LensError> {
    parsed(&format!(
        "[[surface]]\nradius = 30\ndiameter = 8\nindex = 1.5\n[[surface]]\ndiameter = 8\n\
         [[surface]]\nstop = true\ndiameter = 6\n{keys}\n"
    ))
}

/// Removes the column from an error.
fn by_line(error: &str) -> String {
    let (place, message) = error.split_once(": ").expect("a place, and what is wrong there");
    let (line, _) = place.rsplit_once(':').expect("a column");
    format!("{line}: {message}")
}
