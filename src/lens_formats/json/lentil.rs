//! Reader of lentil's database of lenses: one object for each lens, with its elements.
//!
//! The stop is the element of the material "iris", and its radius of curvature means nothing. An
//! aspherical equation lists the coefficients of the powers 4, 6, 8, ...

use std::path::Path;

use super::ReadReport;
use super::value::Json;
use crate::checks::{even_powers, medium, radius};
use petzval_lens::LensError;
use petzval_lens::system::{SequentialSystem, SystemSurface};
use petzval_lens::{Prescription, Row, TransverseAxis};

/// Number of lenses that an error lists.
const LISTED: usize = 60;

/// Returns the elements of a lens, if this is one: those of the patent, or the adjusted ones, which
/// lentil itself prefers.
pub(super) fn elements<'a, 'b>(lens: &'b Json<'a>) -> Option<&'b Json<'a>> {
    lens.any(&["optical-elements-adjusted", "optical-elements-patent"])
}

/// Reads the lens of a key or of a name.
///
/// # Errors
/// Returns an error that lists the lenses if none or several have that name, or the error of the
/// lens.
pub(super) fn read(
    path: &Path,
    json: &Json<'_>,
    entry: Option<&str>,
    left_out: &mut ReadReport<'_>,
) -> Result<Prescription, LensError> {
    let lenses = || json.members().iter().filter(|(_, lens)| elements(lens).is_some());
    let wanted = entry.map(str::to_lowercase);
    let is_wanted = |key: &str, lens: &Json<'_>| {
        wanted.as_ref().is_some_and(|wanted| *wanted == key || name(lens).to_lowercase() == *wanted)
    };
    let mut chosen = lenses().filter(|(key, lens)| is_wanted(key, lens));
    let first =
        if lenses().count() == 1 && entry.is_none() { lenses().next() } else { chosen.next() };
    if let (Some((key, lens)), None) = (first, chosen.next()) {
        return read_lens(path, key, lens, left_out);
    }
    let list = lenses().take(LISTED).map(|(key, lens)| format!("\n  #{key}  {}", name(lens)));
    let found = match entry {
        None => format!("a file of {} lenses", lenses().count()),
        Some(entry) if first.is_some() => format!("several lenses are named \"{entry}\""),
        Some(entry) => format!("no lens \"{entry}\" among {}", lenses().count()),
    };
    let file = path.file_name().unwrap_or_default().to_string_lossy();
    let expected = format!("choose one, as in {file}#KEY:{}", list.collect::<String>());
    Err(json.error(found, &expected))
}

/// Returns the name of a lens: year, maker and product.
fn name(lens: &Json<'_>) -> String {
    let year = lens.get("year").and_then(|year| year.number().ok());
    let text = |key: &str| lens.get(key).and_then(Json::text).map(str::to_owned);
    let parts = [year.map(|year| year.to_string()), text("company"), text("product-name")];
    parts.into_iter().flatten().collect::<Vec<_>>().join(" ")
}

/// Reads one lens.
///
/// # Errors
/// Returns an error with line and column if an element is invalid or not simulated.
pub(super) fn read_lens(
    path: &Path,
    key: &str,
    lens: &Json<'_>,
    left_out: &mut ReadReport<'_>,
) -> Result<Prescription, LensError> {
    let text = |name: &str| lens.get(name).and_then(Json::text).map(str::to_owned);
    let list = elements(lens).ok_or_else(|| lens.error("no elements", "expected a lens"))?;
    // What lentil traced is a check; the patent's round figure may be of another scale.
    let stated = lens.any(&["focal-length-mm-raytraced", "focal-length-mm-patent"]);
    let unscaled = |name: &str| lens.get(name).and_then(|states| states.get("unscaled"));
    let mut system = SequentialSystem {
        name: format!("{} {key}", name(lens)),
        source: text("patent-number"),
        focal_length: stated.map(Json::number).transpose()?,
        f_number: unscaled("fstop").map(Json::number).transpose()?,
        column_of_semi_diameters: true,
        ..SequentialSystem::default()
    };
    for element in list.list()? {
        let surface = read_element(element, left_out)?;
        system.surfaces.push(surface);
    }
    system.design.notes.extend(left_out.take_notes());
    system.build(path)
}

fn read_element(
    element: &Json<'_>,
    left_out: &mut ReadReport<'_>,
) -> Result<SystemSurface, LensError> {
    let material = element.get("material").and_then(Json::text).unwrap_or_default();
    let stop = material.eq_ignore_ascii_case("iris");
    let mut row = Row { stop, thickness: element.need("thickness")?.number()?, ..Row::default() };
    let stated = element.need("radius")?;
    if !stop {
        row.radius = radius(stated.number_or_infinity()?)
            .map_err(|found| stated.error(found, "expected 1e-6 mm or more"))?;
    }
    if let Some(geometry) = element.get("lens-geometry") {
        match geometry.text().unwrap_or_default() {
            "spherical" | "aspherical" | "planar" | "" => {}
            // The axis of the cylinder.
            "cyl-x" if !stop => row.axis = Some(TransverseAxis::X),
            "cyl-y" if !stop => row.axis = Some(TransverseAxis::Y),
            "cyl-x" | "cyl-y" => {}
            name => {
                let what = format!("an element of the geometry \"{name}\"");
                left_out.leave_out(&geometry.line, geometry.word, &what)?;
            }
        }
    }
    if let Some(terms) = element.get("aspherical-equation") {
        row.asphere = even_powers(4, &terms.numbers()?)
            .map_err(|found| terms.error(found, "expected powers up to 30"))?;
    }
    let number = |name: &str| element.get(name).map(Json::number).transpose();
    let medium = medium(number("ior")?, number("abbe")?, material, left_out)
        .map_err(|found| element.error(found, "expected \"ior\" from 1 to 10"))?;
    let semi_diameter = number("housing-radius")?.filter(|semi| *semi > 0.0);
    let line = element.line.number;
    Ok(SystemSurface { line, row, medium, semi_diameter, clips: true, ..SystemSurface::default() })
}
