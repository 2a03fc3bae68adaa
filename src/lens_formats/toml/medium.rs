//! MediumBehind behind a surface: `index`, `abbe`, `glass`.

use super::formula;
use super::value::Section;
use crate::WAVELENGTHS;
use petzval_base::io::excerpt;
use petzval_lens::LensError;
use petzval_lens::Row;
use petzval_lens::{MAX_INDEX, MIN_INDEX};
use petzval_spectrum::{Glass, GlassMatch};

/// Reads the index and the dispersion of the medium behind a surface; `previous` is the surface
/// before it.
///
/// A surface that names no medium borders on air. A plane stop without one is inside the medium
/// before it, except as the last surface: the film is in air.
pub(super) fn read(
    section: &Section,
    row: &Row,
    previous: &Row,
    last: bool,
) -> Result<(f64, Glass), LensError> {
    Ok(match stated(section)? {
        Some(medium) => medium,
        None if row.stop && row.is_plane() && !last => (previous.index, previous.glass.clone()),
        None => (1.0, Glass::Constant),
    })
}

/// Reads the index and the dispersion that a table states, if it names a medium.
pub(super) fn stated(section: &Section) -> Result<Option<(f64, Glass)>, LensError> {
    match formula::read(section)? {
        Some(glass) => Ok(Some((glass.nd(), glass))),
        None if section.has("glass") => by_name(section),
        None => by_index(section),
    }
}

/// Returns the medium behind a mirror: that before it.
pub(super) fn behind_mirror(section: &Section, previous: &Row) -> Result<(f64, Glass), LensError> {
    for key in ["glass", "index", "abbe"] {
        if section.has(key) {
            let expected = "leave it out: the medium behind a mirror is that before it";
            return Err(section.error(key, format!("{key} at a mirror"), expected));
        }
    }
    Ok((previous.index, previous.glass.clone()))
}

/// Rejects a plane stop between two glasses that names no medium, because it may be inside the
/// first or be its surface to air.
pub(super) fn check_stop(stop: &Section, row: &Row, next: &Row) -> Result<(), LensError> {
    let silent = row.stop && row.is_plane() && !stop.has("glass") && !stop.has("index");
    if !silent || row.index == 1.0 || next.index == 1.0 {
        return Ok(());
    }
    let index = row.index;
    let found = format!("a plane stop behind a medium of index {index} names no medium");
    let expected = format!(
        "write index = {index} (or its glass) for a stop inside this medium, or index = 1 for a \
         plane face to air"
    );
    Err(stop.source.error_at(stop.at, found, expected))
}

fn by_name(section: &Section) -> Result<Option<(f64, Glass)>, LensError> {
    for key in ["index", "abbe"] {
        if section.has(key) {
            let found = format!("{key} beside glass");
            return Err(section.error(
                key,
                found,
                "expected one of them: the glass implies index and abbe",
            ));
        }
    }
    let Some(name) = section.string("glass")? else { return Ok(None) };
    let library = section.source.glasses;
    if let Some(fault) = library.fault(name) {
        let found = format!("the glass \"{}\" cannot be used", excerpt(name));
        return Err(section.error("glass", found, fault));
    }
    let found = library.find(name, &[]);
    let Some(GlassMatch { glass, substitution: None, ambiguity }) = found else {
        // A file of petzval's own names its glass exactly: a substitute is only suggested.
        let near = match found {
            Some(GlassMatch { glass: Glass::Catalogue(glass), .. }) => Some(glass.name.to_string()),
            _ => library.suggest(name).map(str::to_owned),
        };
        let near = near.map_or_else(String::new, |near| format!("; did you mean \"{near}\"?"));
        let found = format!("no glass \"{}\" in the catalogue{near}", excerpt(name));
        let expected = "expected a listed name, one of a catalogue ('catalogue'), or index and abbe as \
                        numbers";
        return Err(section.error("glass", found, expected));
    };
    if let Some(ambiguity) = ambiguity {
        section.source.note(ambiguity);
    }
    Ok(Some((glass.nd(), glass)))
}

fn by_index(section: &Section) -> Result<Option<(f64, Glass)>, LensError> {
    let in_range = |at: usize, index: f64| {
        let found = format!("index {index}");
        let expected = format!("expected 1 (air) to {MAX_INDEX}, or {MIN_INDEX} for a gas");
        match (MIN_INDEX..=MAX_INDEX).contains(&index) {
            true => Ok(index),
            false => Err(section.source.error_at(at, found, expected)),
        }
    };
    if section.array("index").is_some() {
        if section.has("abbe") {
            let found = "abbe beside a table of indices";
            return Err(section.error(
                "abbe",
                found,
                "expected one of them: the table already states the dispersion",
            ));
        }
        let table = table(section, in_range)?;
        return Ok(Some((table.nd(), table)));
    }
    let index = section
        .number("index")?
        .map(|index| in_range(section.position("index"), index))
        .transpose()?;
    let abbe = section.finite("abbe")?;
    match (index, abbe) {
        (None, None) => Ok(None),
        (Some(index), None) => Ok(Some((index, Glass::Constant))),
        (Some(index), Some(vd)) if (5.0..=200.0).contains(&vd) => {
            Ok(Some((index, Glass::Abbe { nd: index, vd })))
        }
        (Some(_), Some(vd)) => {
            Err(section.error("abbe", format!("abbe is {vd}"), "expected 5 to 200"))
        }
        (None, Some(_)) => {
            Err(section.error("abbe", "abbe without index", "expected index as a number beside it"))
        }
    }
}

fn table(
    section: &Section,
    in_range: impl Fn(usize, f64) -> Result<f64, LensError>,
) -> Result<Glass, LensError> {
    let form = "[[nm, n], ...]";
    let mut entries = section.number_pairs("index", form)?;
    for &(at, [nm, n]) in &entries {
        in_range(at, n)?;
        if !WAVELENGTHS.contains(&nm) {
            let found = format!("wavelength {nm}");
            return Err(section.source.error_at(at, found, "expected nm, 100 to 1000000000"));
        }
    }
    entries.sort_by(|(_, a), (_, b)| a[0].total_cmp(&b[0]));
    if let Some(pair) = entries.windows(2).find(|pair| pair[0].1[0] == pair[1].1[0]) {
        let found = format!("wavelength {} is stated twice", pair[1].1[0]);
        return Err(section.source.error_at(pair[1].0, found, "expected each wavelength once"));
    }
    if entries.is_empty() {
        return Err(section.error(
            "index",
            "an empty table of indices",
            format!("expected {form}"),
        ));
    }
    Ok(Glass::Table(entries.into_iter().map(|(_, entry)| entry).collect()))
}
