//! One `[[surface]]`.

use super::value::{Section, shortened};
use crate::image::ImageError;
use crate::lens::error::LensError;
use crate::lens::file::MOST_INDEX;
use crate::lens::glass::{D_LINE, Glass, catalogue, nearest_glass};
use crate::lens::iris::{Iris, MASKS, Mask};
use crate::lens::prescription::{Axis, Row};
use crate::source::hint;

const KEYS: &[&str] = &[
    "radius",
    "thickness",
    "diameter",
    "index",
    "abbe",
    "glass",
    "stop",
    "conic",
    "asphere",
    "axis",
    "coating",
    "obstruction",
    "blades",
    "rotation",
    "curvature",
    "aperture",
];

/// Reads a surface; `ahead` is the one before it, or air.
pub(super) fn read(section: &Section, ahead: &Row) -> Result<Row, LensError> {
    section.only(KEYS)?;
    let row = Row { stop: section.flag("stop")?, ..shape(section)? };
    let row = medium(section, row, ahead)?;
    Ok(Row {
        iris: iris(section, row.stop)?,
        coating: section.text("coating")?.map(str::to_owned),
        ..row
    })
}

fn shape(section: &Section) -> Result<Row, LensError> {
    let radius = match section.number("radius")? {
        Some(radius) if radius != 0.0 && radius.is_finite() => radius,
        _ => f64::INFINITY,
    };
    let row = Row {
        radius,
        conic: section.finite("conic")?.unwrap_or(0.0),
        asphere: asphere(section)?,
        axis: axis(section)?,
        thickness: section.finite("thickness")?.unwrap_or(0.0),
        diameter: diameter(section)?,
        ..Row::default()
    };
    let half = row.diameter / 2.0;
    let bend = row.curvature() * half;
    if 1.0 - (1.0 + row.conic) * bend * bend < 0.0 {
        let found = format!("diameter {} on a radius of {radius}", row.diameter);
        let expected = match row.conic {
            0.0 => "a clear diameter is at most twice the radius".to_owned(),
            k => format!("a conic of k = {k} does not reach so far"),
        };
        return Err(section.refuse("diameter", found, expected));
    }
    if !row.sag(half).is_finite() {
        let expected = "expected a surface with a finite sag at its rim";
        return Err(section.refuse("asphere", "a coefficient that leads to infinity", expected));
    }
    Ok(Row { obstruction: obstruction(section, row.diameter)?, ..row })
}

fn diameter(section: &Section) -> Result<f64, LensError> {
    let expected = "expected the full clear diameter, above 0 mm";
    match section.finite("diameter")? {
        Some(diameter) if diameter > 0.0 => Ok(diameter),
        Some(diameter) => {
            Err(section.refuse("diameter", format!("diameter is {diameter}"), expected))
        }
        None => Err(section.refuse("diameter", "a surface without diameter", expected)),
    }
}

fn obstruction(section: &Section, diameter: f64) -> Result<f64, LensError> {
    let obstruction = section.finite("obstruction")?.unwrap_or(0.0);
    if (0.0..diameter).contains(&obstruction) {
        return Ok(obstruction);
    }
    let found = format!("obstruction is {obstruction}");
    let expected = format!("expected 0 to less than the diameter, {diameter} mm");
    Err(section.refuse("obstruction", found, expected))
}

fn asphere(section: &Section) -> Result<Vec<(u32, f64)>, LensError> {
    let form = "[[power, coefficient], ...]";
    let mut terms: Vec<(u32, f64)> = Vec::new();
    for (at, [power, coefficient]) in section.pairs("asphere", form)? {
        let refuse = |found: String, expected| Err(section.source.refuse(at, found, expected));
        if !(2.0..=20.0).contains(&power) || power.fract() != 0.0 {
            return refuse(format!("power {power}"), "expected a whole number from 2 to 20");
        }
        let power = power as u32;
        if terms.iter().any(|(earlier, _)| *earlier == power) {
            return refuse(format!("power {power} a second time"), "each power stands once");
        }
        terms.push((power, coefficient));
    }
    Ok(terms)
}

fn axis(section: &Section) -> Result<Option<Axis>, LensError> {
    let axis = match section.text("axis")? {
        None => return Ok(None),
        Some("x") => Axis::X,
        Some("y") => Axis::Y,
        Some(other) => {
            let found = format!("axis is \"{}\"", shortened(other));
            return Err(section.refuse("axis", found, "expected \"x\" or \"y\""));
        }
    };
    for key in ["conic", "asphere"] {
        if section.has(key) {
            let expected = "a cylinder is a sphere in one direction; leave one of them out";
            return Err(section.refuse(key, format!("{key} and axis on one surface"), expected));
        }
    }
    Ok(Some(axis))
}

/// Fills in the medium behind a surface.
fn medium(section: &Section, row: Row, ahead: &Row) -> Result<Row, LensError> {
    let stated = match section.has("glass") {
        true => by_name(section)?,
        false => by_index(section)?,
    };
    let (index, glass) = if row.stop && row.is_plane() {
        if let Some((index, glass)) = stated
            && (index != ahead.index || glass.disperses() && glass != ahead.glass)
        {
            let found =
                format!("the stop changes the medium, of index {}, to {index}", ahead.index);
            let expected = "leave it out: a stop without radius stands in what is before it";
            let key = if section.has("glass") { "glass" } else { "index" };
            return Err(section.refuse(key, found, expected));
        }
        (ahead.index, ahead.glass.clone())
    } else {
        stated.unwrap_or((1.0, Glass::Constant))
    };
    Ok(Row { index, glass, ..row })
}

fn by_name(section: &Section) -> Result<Option<(f64, Glass)>, LensError> {
    for key in ["index", "abbe"] {
        if section.has(key) {
            let found = format!("{key} beside glass");
            return Err(section.refuse(key, found, "a glass has both by its name"));
        }
    }
    let Some(name) = section.text("glass")? else { return Ok(None) };
    let Some(glass) = catalogue(name) else {
        let near = nearest_glass(name)
            .map_or_else(String::new, |near| format!("; did you mean \"{near}\"?"));
        let found = format!("no glass \"{}\" in the catalogue{near}", shortened(name));
        let expected = "expected a listed name, or index and abbe as numbers";
        return Err(section.refuse("glass", found, expected));
    };
    Ok(Some((glass.nd(), Glass::Catalogue(glass))))
}

fn by_index(section: &Section) -> Result<Option<(f64, Glass)>, LensError> {
    let in_range = |at: usize, index: f64| {
        let found = format!("index {index}");
        let expected = format!("expected 1 (air) to {MOST_INDEX}");
        match (1.0..=MOST_INDEX).contains(&index) {
            true => Ok(index),
            false => Err(section.source.refuse(at, found, expected)),
        }
    };
    if section.array("index").is_some() {
        if section.has("abbe") {
            let found = "abbe beside a table of indices";
            return Err(section.refuse("abbe", found, "the table says how the index changes"));
        }
        let table = table(section, in_range)?;
        return Ok(Some((table.index(1.0, D_LINE), table)));
    }
    let index = section
        .number("index")?
        .map(|index| in_range(section.place("index"), index))
        .transpose()?;
    let abbe = section.finite("abbe")?;
    match (index, abbe) {
        (None, None) => Ok(None),
        (Some(index), None) => Ok(Some((index, Glass::Constant))),
        (Some(index), Some(vd)) if (5.0..=200.0).contains(&vd) => {
            Ok(Some((index, Glass::Abbe { vd })))
        }
        (Some(_), Some(vd)) => {
            Err(section.refuse("abbe", format!("abbe is {vd}"), "expected 5 to 200"))
        }
        (None, Some(_)) => Err(section.refuse(
            "abbe",
            "abbe without index",
            "expected index as a number beside it",
        )),
    }
}

fn table(
    section: &Section,
    in_range: impl Fn(usize, f64) -> Result<f64, LensError>,
) -> Result<Glass, LensError> {
    let form = "[[nm, n], ...]";
    let mut entries = section.pairs("index", form)?;
    for &(at, [nm, n]) in &entries {
        in_range(at, n)?;
        if !(100.0..=1e6).contains(&nm) {
            let found = format!("wavelength {nm}");
            return Err(section.source.refuse(at, found, "expected nm, 100 to 1000000"));
        }
    }
    entries.sort_by(|(_, a), (_, b)| a[0].total_cmp(&b[0]));
    if let Some(pair) = entries.windows(2).find(|pair| pair[0].1[0] == pair[1].1[0]) {
        let found = format!("wavelength {} a second time", pair[1].1[0]);
        return Err(section.source.refuse(pair[1].0, found, "each wavelength stands once"));
    }
    if entries.is_empty() {
        return Err(section.refuse(
            "index",
            "an empty table of indices",
            format!("expected {form}"),
        ));
    }
    Ok(Glass::Table(entries.into_iter().map(|(_, entry)| entry).collect()))
}

fn iris(section: &Section, stop: bool) -> Result<Iris, LensError> {
    for key in ["blades", "rotation", "curvature", "aperture"] {
        if section.has(key) && !stop {
            let found = format!("{key} on a surface that is not the stop");
            return Err(section.refuse(key, found, "only a surface with stop = true has it"));
        }
    }
    for key in ["rotation", "curvature"] {
        if section.has(key) && !section.has("blades") {
            let found = format!("{key} without blades");
            return Err(section.refuse(key, found, "expected blades = 3 to 64 beside it"));
        }
    }
    if section.has("blades") && section.has("aperture") {
        return Err(section.refuse("aperture", "aperture beside blades", "a stop has one of them"));
    }
    let Some(blades) = section.number("blades")? else {
        return section.text("aperture")?.map_or(Ok(Iris::Round), |name| shaped(section, name));
    };
    if !(3.0..=64.0).contains(&blades) || blades.fract() != 0.0 {
        let found = format!("blades is {blades}");
        return Err(section.refuse("blades", found, "expected a whole number from 3 to 64"));
    }
    let rotation = section.finite("rotation")?.unwrap_or(0.0);
    let curvature = section.number("curvature")?.unwrap_or(0.0);
    if !(0.0..=1.0).contains(&curvature) {
        let found = format!("curvature is {curvature}");
        let expected = "expected 0 (straight blades) to 1 (a circle)";
        return Err(section.refuse("curvature", found, expected));
    }
    Ok(Iris::Blades { count: blades as u32, rotation, curvature })
}

/// An opening by its name or its picture.
fn shaped(section: &Section, name: &str) -> Result<Iris, LensError> {
    if name == "circular" {
        return Ok(Iris::Round);
    }
    if let Some(mask) = Mask::named(name) {
        return Ok(Iris::Mask(mask));
    }
    let folder = section.source.path.parent().unwrap_or(std::path::Path::new(""));
    Mask::image(&folder.join(name)).map(Iris::Mask).map_err(|error| {
        let known = MASKS.iter().copied().chain(["circular"]);
        match error {
            ImageError::Format { .. } => {
                let found = format!("aperture is \"{}\"{}", shortened(name), hint(name, known));
                let names = MASKS.join(", ");
                let expected = format!("expected circular, {names}, or the path of a picture");
                section.refuse("aperture", found, expected)
            }
            other => section.refuse("aperture", other.to_string(), "expected a square picture"),
        }
    })
}
