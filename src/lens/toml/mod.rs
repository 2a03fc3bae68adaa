//! Petzval's own lens files, in TOML.
//!
//! At the top `name`, `source`, `focal_length` (mm) and `f_number`, all optional; then one
//! `[[surface]]` for each surface, from the scene to the film, lengths in mm:
//!
//! | key | means | without it |
//! |---|---|---|
//! | `radius` | of curvature, positive with the centre on the film side; 0 or `inf` a plane | plane |
//! | `thickness` | distance to the next surface; may be negative | 0 |
//! | `diameter` | full clear diameter | an error |
//! | `index` | of the medium behind: a number, or `[[nm, n], ...]` | air |
//! | `abbe` | Abbe number, beside a number for `index` | no dispersion |
//! | `glass` | the medium by its catalogue name, instead of `index` | |
//! | `stop` | `true` for exactly one surface | |
//! | `conic` | the constant k: 0 a sphere, -1 a paraboloid | 0 |
//! | `asphere` | `[[power, coefficient], ...]`, powers 2 to 20, even or odd | |
//! | `axis` | `"x"` or `"y"`: a cylinder that runs straight along it | |
//! | `coating` | of a face to air: `"none"`, `"mgf2"`, `"broadband"`, `"perfect"` | bare |
//! | `obstruction` | diameter of an opaque disk in the middle | 0 |
//! | `blades` | of the stop: 3 to 64, with `rotation` (degrees) and `curvature` (0 to 1) | round |
//! | `aperture` | of the stop: `"circular"`, `"gaussian"`, `"square"`, `"pentagon"`, `"star"`, or a picture beside the lens file | round |
//! | `decentre` | `[x, y]`: the vertex stands so far off the axis, to the right and up as seen from behind the camera | `[0, 0]` |
//! | `tilt` | `[x, y]`, degrees: turned about the vertex, see [`Pose`](crate::lens::Pose) | `[0, 0]` |
//!
//! A plane stop that names no medium stands in the medium before it; as the last surface it is a
//! face to air. A surface that is decentred or tilted moves alone; those behind it stay. An element or a group moves as one body under an `[[askew]]`
//! of its own:
//!
//! | key | means | without it |
//! |---|---|---|
//! | `surfaces` | `[first, last]`, counted from 1 at the scene side | an error |
//! | `decentre` | `[x, y]` of the body | `[0, 0]` |
//! | `tilt` | `[x, y]`, degrees, about where the vertex of its first surface should stand | `[0, 0]` |
//!
//! A body may lie in another: the inner one comes first in the file.
//!
//! The `toml` crate reads the grammar because it keeps the place of every value, so that each
//! error can name its line and column.

mod medium;
mod opening;
mod pose;
mod row;
mod value;

use std::path::Path;

use ::toml::de::{DeTable, DeValue};

use super::error::LensError;
use super::prescription::{Prescription, Row};
use value::{Section, Source};

const TOP: &[&str] = &["name", "source", "focal_length", "f_number", "surface", "askew"];

/// Reads the text of a lens in TOML; the path serves for its name, for pictures beside it and in
/// errors.
///
/// # Errors
/// Where the text is no TOML or no lens, with line and column.
pub fn parse(path: &Path, text: &str) -> Result<Prescription, LensError> {
    let source = Source { path, text };
    let table = DeTable::parse(text).map_err(|error| {
        let at = error.span().map_or(0, |span| span.start);
        let found = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        source.refuse(at, found, "expected TOML: key = value, one a line, under [[surface]]")
    })?;
    let top = Section { source, at: 0, table: table.get_ref() };
    top.only(TOP)?;

    let stem = || path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let positive = |key: &str| match top.finite(key)? {
        Some(number) if number <= 0.0 => {
            Err(top.refuse(key, format!("{key} is {number}"), "expected a number above 0"))
        }
        number => Ok(number),
    };
    let mut lens = Prescription {
        name: top.text("name")?.map_or_else(stem, str::to_owned),
        source: top.text("source")?.map(str::to_owned),
        stated_focal_length: top.finite("focal_length")?,
        stated_f_number: positive("f_number")?,
        rows: Vec::new(),
        askew: Vec::new(),
    };

    let mut stop: Option<usize> = None;
    let sections = surfaces(&top)?;
    for (i, section) in sections.iter().enumerate() {
        let ahead = lens.rows.last().cloned().unwrap_or_default();
        let row = row::read(section, &ahead, i + 1 == sections.len())?;
        if row.stop && stop.replace(section.at).is_some() {
            return Err(section.refuse("stop", "a second stop", "a lens has one"));
        }
        if let Some(before) = i.checked_sub(1) {
            medium::check_stop(&sections[before], &ahead, &row)?;
        }
        lens.rows.push(row);
    }
    let Some(stop) = stop else {
        let expected = "one surface must say stop = true";
        return Err(source.refuse(text.trim_end().len(), "the lens ends without a stop", expected));
    };
    if lens.rows.iter().all(Row::is_bare_stop) {
        return Err(source.refuse(stop, "a stop without any glass", "a lens has surfaces"));
    }
    lens.askew = pose::askew(&top, lens.rows.len())?;
    Ok(lens)
}

/// The tables under `[[surface]]`; at least one.
fn surfaces<'a>(top: &Section<'a>) -> Result<Vec<Section<'a>>, LensError> {
    let expected = "expected [[surface]] before the keys of each surface";
    let array = top.array("surface").filter(|array| !array.is_empty());
    let Some(array) = array else {
        let found =
            if top.has("surface") { "surface is no list" } else { "no surface in the file" };
        return Err(top.refuse("surface", found, expected));
    };
    array
        .iter()
        .map(|entry| {
            let at = entry.span().start;
            match entry.get_ref() {
                DeValue::Table(table) => Ok(Section { source: top.source, at, table }),
                _ => Err(top.source.refuse(at, "a surface without keys", expected)),
            }
        })
        .collect()
}

impl Row {
    /// A stop that bends no light.
    fn is_bare_stop(&self) -> bool {
        self.stop && self.is_plane() && self.index == 1.0
    }

    /// A surface without any curvature.
    fn is_plane(&self) -> bool {
        self.radius.is_infinite() && self.asphere.is_empty()
    }
}
