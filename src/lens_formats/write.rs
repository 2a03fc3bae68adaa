//! Writers of lens files, chosen by the extension of the name.

use std::fmt::Write as _;
use std::path::Path;

use super::toml::to_toml;
use super::zmx::write::to_zmx;
use petzval_lens::Iris;
use petzval_lens::LensError;
use petzval_lens::{Prescription, Row};
use petzval_spectrum::Glass;

/// A lens as the text of a file.
#[derive(Clone, Debug, PartialEq)]
pub struct WrittenLens {
    /// Content of the file.
    pub text: String,
    /// Sentences about properties of the lens that the file does not hold.
    pub notes: Vec<String>,
}

/// Returns the text of a lens file of this name: `.toml` holds everything, `.zmx` (Zemax) nearly
/// everything, `.dat` centred spheres of constant index.
///
/// # Errors
/// Returns an error if the extension is unknown or the format cannot hold the lens.
pub fn write_lens(path: &Path, lens: &Prescription) -> Result<WrittenLens, LensError> {
    let extension = path.extension().unwrap_or_default().to_string_lossy().to_lowercase();
    match extension.as_str() {
        "toml" => Ok(WrittenLens { text: to_toml(lens), notes: Vec::new() }),
        "zmx" => to_zmx(path, lens),
        "dat" => Ok(WrittenLens { text: to_dat(path, lens)?, notes: Vec::new() }),
        _ => Err(LensError::Unwritable {
            path: path.to_owned(),
            found: "the name says no format that can be written".to_owned(),
            expected: "expected .toml, .zmx or .dat".to_owned(),
        }),
    }
}

/// Writes the four columns of pbrt: radius, thickness, index, diameter (mm).
fn to_dat(path: &Path, lens: &Prescription) -> Result<String, LensError> {
    let error = |found: String| LensError::Unwritable {
        path: path.to_owned(),
        found: format!("a .dat table cannot hold {found}"),
        expected: "write a .toml file".to_owned(),
    };
    if lens.is_misaligned() {
        return Err(error("tilts, decentres and folds".to_owned()));
    }
    let mut text = format!("# {}\n", lens.name.replace(char::is_control, " "));
    if let Some(source) = &lens.source {
        let _ = writeln!(text, "# {}", source.replace(char::is_control, " "));
    }
    text.push_str("# radius  thickness  index  diameter; mm, scene side first; radius 0: stop\n");
    for (number, row) in (1..).zip(&lens.rows) {
        if let Some(found) = beyond_dat(row) {
            return Err(error(format!("{found} (surface {number})")));
        }
        // The reader takes the last thickness for any number.
        let radius = match (row.stop, row.radius.is_infinite()) {
            (true, _) => 0.0,
            (false, true) => PLANE,
            (false, false) => row.radius,
        };
        let Row { thickness, index, diameter, .. } = row;
        let _ = writeln!(text, "{radius:?} {thickness:?} {index:?} {diameter:?}");
    }
    Ok(text)
}

/// Radius of a plane in a table in which 0 is the stop (mm): as good as infinite in f64.
const PLANE: f64 = 1e15;

/// Returns what a row has that a table has not.
fn beyond_dat(row: &Row) -> Option<&'static str> {
    let found = [
        (row.stop && row.radius.is_finite(), "a stop on a sphere"),
        (row.conic != 0.0, "a conic"),
        (!row.asphere.is_empty(), "an asphere"),
        (row.axis.is_some(), "a cylinder"),
        (row.glass != Glass::Constant, "dispersion"),
        (row.obstruction != 0.0, "an obstruction"),
        (!row.apertures.is_empty(), "a rectangular, elliptical or decentred aperture"),
        (row.iris != Iris::Round, "the shape of an iris"),
        (row.mirror, "a mirror"),
        (row.coating.is_some(), "a coating"),
        (row.ideal.is_some(), "an ideal lens"),
    ];
    found.into_iter().find(|(has, _)| *has).map(|(_, name)| name)
}
