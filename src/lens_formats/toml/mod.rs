//! Reader of petzval's own lens files, in TOML.
//!
//! The top level has `name`, `source`, `focal_length` (mm) and `f_number`, all optional. One
//! `[[surface]]` follows for each surface, from the scene to the film, with lengths in mm:
//!
//! | key | meaning | default |
//! |---|---|---|
//! | `radius` | radius of curvature, positive with the centre on the film side; 0 or `inf` for a plane | plane |
//! | `thickness` | distance to the next surface; may be negative | 0 |
//! | `diameter` | full clear diameter | an error |
//! | `index` | index of the medium behind: a number, or `[[nm, n], ...]` | air |
//! | `abbe` | Abbe number, beside a number for `index` | no dispersion |
//! | `glass` | catalogue name of the medium, instead of `index` | |
//! | `stop` | `true` for exactly one surface | |
//! | `conic` | conic constant k: 0 for a sphere, -1 for a paraboloid | 0 |
//! | `asphere` | `[[power, coefficient], ...]`, powers 2 to 30, even or odd | |
//! | `shape` | `"biconic"` or `"toroid"`: `radius_x` (and for a biconic `conic_x`) along x, all else along y | |
//! | `axis` | `"x"` or `"y"`: a cylinder that is straight along it | |
//! | `mirror` | `true` for a surface that reflects; the thicknesses behind it are then negative up to the next mirror | `false` |
//! | `coating` | coating of a glass-air surface: `"none"`, `"mgf2"`, `"broadband"`, `"perfect"`, or the name of a `[[coating]]` | bare |
//! | `obstruction` | diameter of an opaque disk around the axis | 0 |
//! | `apertures` | tables, each with `shape` (`"rectangle"` or `"ellipse"`), `half_widths` (`[x, y]`), `centre` (`[x, y]`, from the vertex), `rotation` (about the centre, from x towards y, degrees) and `obscures` (`true` for an opaque inside) | none |
//! | `blades` | blades of the stop: 3 to 64, with `rotation` (degrees) and `curvature` (0 to 1) | round |
//! | `aperture` | opening of the stop: `"circular"`, `"gaussian"`, `"square"`, `"pentagon"`, `"star"`, or a picture beside the lens file | round |
//! | `decentre` | `[x, y]`: displacement of the vertex, to the right and up as seen from behind the camera | `[0, 0]` |
//! | `tilt` | `[x, y]` [degrees]: rotation about the vertex, see [`Pose`](petzval_lens::Pose) | `[0, 0]` |
//!
//! A plane stop that names no medium is inside the medium before it; as the last surface it borders
//! on air. A decentred or tilted surface moves alone; the surfaces behind it stay. An `[[askew]]`
//! table moves an element or a group as one body:
//!
//! | key | meaning | default |
//! |---|---|---|
//! | `surfaces` | `[first, last]`, counted from 1 at the scene side | an error |
//! | `decentre` | `[x, y]` of the body | `[0, 0]` |
//! | `tilt` | `[x, y]` (degrees), about the vertex of its first surface in the centred lens | `[0, 0]` |
//!
//! A body may contain another; the inner one comes first in the file.
//!
//! A `[[coating]]` is a stack of films: `name`, and `layers` from air to glass, each a table with
//! `thickness` (nm) and a material, by `glass` or by `index` and `abbe`.
//!
//! The top level may also state the use of the lens: `wavelengths` (`[[nm, weight], ...]`),
//! `primary` (the number of the primary one), `object_distance` (mm before the front vertex, or
//! `inf`), `film_distance` (mm behind the rear vertex), and one `[[fields]]` with `kind` (`"angle"`,
//! `"object height"`, `"image height"`) and `points` (`[[x, y], ...]`).
//!
//! A `[[break]]` changes the axis of all that follows: `surface` is the number of the first surface
//! on the new axis (one more than there are for the film), `decentre` (`[x, y, z]`) and `tilt`
//! (`[x, y, z]` degrees, about x, then the new y, then the new z) or `axes` (three unit vectors)
//! place the new axes in the old ones.
//!
//! A `[[configuration]]` is a state of zoom and focus: `name`, `focal_length`, `f_number`,
//! `object_distance`, `magnification`, `film_distance`, and `thickness`, `curvature` and `diameter`
//! with `[[surface, value], ...]`. The first ones of a file that focus on distant objects are the
//! zoom settings; the others are focused nearer, in the same order.
//!
//! The `toml` crate is used because it keeps the position of every value, so that each error can
//! name its line and column.

mod aperture;
mod coating;
mod design;
mod formula;
mod iris;
mod medium;
mod pose;
mod row;
mod value;
mod write;

use std::cell::RefCell;
use std::path::Path;

use ::toml::de::{DeTable, DeValue};

use petzval_base::io::ReadContext;
use petzval_lens::LensError;
use petzval_lens::{Prescription, Row};
use petzval_spectrum::GlassLibrary;
use value::{Section, Source};
pub use write::to_toml;

const TOP: [&str; 8] =
    ["name", "source", "focal_length", "f_number", "coating", "surface", "askew", "break"];

/// Parses a lens in TOML. The path names the lens, locates pictures beside it and appears in
/// errors.
///
/// # Errors
/// Returns an error with line and column if the text is not TOML or not a lens.
pub fn parse(path: &Path, text: &str) -> Result<Prescription, LensError> {
    parse_with(path, text, &ReadContext::default())
}

/// Parses a lens, and logs the pictures that it names.
pub(crate) fn parse_with(
    path: &Path,
    text: &str,
    context: &ReadContext,
) -> Result<Prescription, LensError> {
    let glasses = GlassLibrary::for_context(context)?;
    let notes = RefCell::default();
    let source = Source { path, text, context, glasses: &glasses, notes: &notes };
    let table = DeTable::parse(text).map_err(|error| {
        let at = error.span().map_or(0, |span| span.start);
        let found = error.message().split_whitespace().collect::<Vec<_>>().join(" ");
        source.error_at(at, found, "expected TOML: key = value, one a line, under [[surface]]")
    })?;
    let top = Section { source, at: 0, table: table.get_ref() };
    top.reject_unknown_keys(&[&TOP[..], &design::KEYS[..]].concat())?;

    let stem = || path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    let positive = |key: &str| match top.finite(key)? {
        Some(number) if number <= 0.0 => {
            Err(top.error(key, format!("{key} is {number}"), "expected a number above 0"))
        }
        number => Ok(number),
    };
    let name = top.string("name")?.map_or_else(stem, str::to_owned);
    let origin = top.string("source")?.map(str::to_owned);
    let stated_focal_length = top.finite("focal_length")?;
    let stated_f_number = positive("f_number")?;

    let stacks = coating::definitions(&top)?;
    let mut rows: Vec<Row> = Vec::new();
    let mut stop: Option<usize> = None;
    let sections = surfaces(&top)?;
    for (i, section) in sections.iter().enumerate() {
        let previous = rows.last().cloned().unwrap_or_default();
        let row = row::read(section, &stacks, &previous, i + 1 == sections.len())?;
        if row.stop && stop.replace(section.at).is_some() {
            return Err(section.error("stop", "a second stop", "a lens has one"));
        }
        if let Some(before) = i.checked_sub(1) {
            medium::check_stop(&sections[before], &previous, &row)?;
        }
        rows.push(row);
    }
    let Some(stop) = stop else {
        let expected = "one surface must say stop = true";
        return Err(source.error_at(
            text.trim_end().len(),
            "the lens ends without a stop",
            expected,
        ));
    };
    if rows.iter().all(is_bare_stop) {
        return Err(source.error_at(
            stop,
            "a stop without any glass",
            "expected at least one other surface",
        ));
    }
    let mut lens = Prescription {
        source: origin,
        stated_focal_length,
        stated_f_number,
        tilt_decenters: pose::tilt_decenters(&top, rows.len())?,
        breaks: pose::breaks(&top, rows.len())?,
        design: design::read(&top, rows.len())?,
        ..Prescription::new(name, rows)?
    };
    lens.design.notes.extend(notes.take());
    if !lens.design.wavelengths.is_empty() {
        lens = lens.at_wavelength(lens.design.primary_wavelength()).map_err(|error| {
            top.error("wavelengths", error.to_string(), "expected a range that the glasses have")
        })?;
    }
    Ok(lens)
}

/// Returns the tables under `[[surface]]`; at least one.
fn surfaces<'a>(top: &Section<'a>) -> Result<Vec<Section<'a>>, LensError> {
    let expected = "expected [[surface]] before the keys of each surface";
    let array = top.array("surface").filter(|array| !array.is_empty());
    let Some(array) = array else {
        let found =
            if top.has("surface") { "surface is not a list" } else { "no surface in the file" };
        return Err(top.error("surface", found, expected));
    };
    array
        .iter()
        .map(|entry| {
            let at = entry.span().start;
            match entry.get_ref() {
                DeValue::Table(table) => Ok(Section { source: top.source, at, table }),
                _ => Err(top.source.error_at(at, "a surface without keys", expected)),
            }
        })
        .collect()
}

/// Returns whether a row is a stop that does not refract.
fn is_bare_stop(row: &Row) -> bool {
    row.stop && row.is_plane() && row.index == 1.0
}
