//! Reader of the JSON of ISET: surfaces of radius, thickness, index and semi-aperture, in mm.
//!
//! The stop has radius 0. Its index counts if it is neither 0 nor that of the glass before it: then
//! it is a plane that refracts.

use std::path::Path;

use super::ReadReport;
use super::value::{Content, Json};
use crate::checks::{medium, powers, radius};
use petzval_lens::LensError;
use petzval_lens::Paraxial;
use petzval_lens::system::{MediumBehind, SequentialSystem, SystemSurface};
use petzval_lens::{CrossSection, Prescription, Row};
use petzval_lens::{MAX_INDEX, MIN_INDEX};
use petzval_spectrum::Glass;

/// Members of a surface that are read, or that say nothing about rays.
const KNOWN: [&str; 14] = [
    "radius",
    "thickness",
    "ior",
    "semi_aperture",
    "conic_constant",
    "aspheric_coefficients",
    "type",
    "name",
    "comment",
    "description",
    "transform",
    "note",
    "notes",
    "material",
];

/// Reads a lens.
///
/// # Errors
/// Returns an error with line and column if a surface is invalid or not simulated.
pub(super) fn read(
    path: &Path,
    json: &Json<'_>,
    surfaces: &Json<'_>,
    left_out: &mut ReadReport<'_>,
) -> Result<Prescription, LensError> {
    let mut system = SequentialSystem {
        name: json.get("name").and_then(Json::text).unwrap_or_default().to_owned(),
        column_of_semi_diameters: true,
        ..SequentialSystem::default()
    };
    if let Some(microlens) = json.get("microlens").filter(|value| !is_empty(value)) {
        left_out.leave_out(&microlens.line, microlens.word, "an array of microlenses")?;
    }
    let list = surfaces.list()?;
    for surface in list {
        let surface = read_surface(surface, &mut system, left_out)?;
        system.surfaces.push(surface);
    }
    let metadata = json.get("metadata");
    let stated = |names: &[&str]| match metadata.and_then(|metadata| metadata.any(names)) {
        None => Ok(None),
        Some(value) => value.number().map(|number| Some(number).filter(|number| *number > 0.0)),
    };
    let focal_length = stated(&["focalLength", "focal_length"])?;
    system.f_number = stated(&["fNumber", "fnumber"])?;
    system.design.notes.extend(left_out.take_notes());
    let mut lens = system.build(path)?;
    // Metres in most files, mm in some.
    let found = Paraxial::new(&lens).focal_length;
    lens.stated_focal_length = focal_length.map(|stated| {
        let metres = (1e3 * stated - found).abs() < (stated - found).abs();
        if metres { 1e3 * stated } else { stated }
    });
    Ok(lens)
}

fn is_empty(value: &Json<'_>) -> bool {
    match &value.content {
        Content::List(list) => list.is_empty(),
        Content::Object(members) => members.is_empty(),
        _ => false,
    }
}

fn read_surface(
    surface: &Json<'_>,
    system: &mut SequentialSystem,
    left_out: &mut ReadReport<'_>,
) -> Result<SystemSurface, LensError> {
    if let Some(kind) = surface.get("type")
        && let Some(name) = kind.text()
        && !["refractive", "spherical", "sphere", "stop", "diaphragm", "aspherical"]
            .contains(&name.to_ascii_lowercase().as_str())
    {
        left_out.leave_out(&kind.line, kind.word, &format!("a surface of the type \"{name}\""))?;
    }
    for (name, value) in surface.members() {
        if !KNOWN.contains(&name.as_str()) && !is_empty(value) {
            left_out.leave_out(&value.line, value.word, &format!("\"{name}\" of a surface"))?;
        }
    }
    if let Some(transform) = surface.get("transform").filter(|value| !is_empty(value)) {
        left_out.leave_out(&transform.line, transform.word, "a transformed surface")?;
    }
    let stated = surface.need("radius")?;
    let value = match &stated.content {
        Content::List(_) => pair(stated)?[1],
        _ => stated.number_or_infinity()?,
    };
    let mut row = Row {
        radius: radius(value)
            .map_err(|found| stated.error(found, "expected 1e-6 mm or more, or 0 at the stop"))?,
        stop: value == 0.0,
        thickness: surface.need("thickness")?.number()?,
        ..Row::default()
    };
    let mut conic_x = 0.0;
    if let Some(conic) = surface.get("conic_constant").filter(|value| !is_empty(value)) {
        let [x, y] = pair(conic)?;
        conic_x = x;
        row.conic = y;
    }
    let across = match &stated.content {
        Content::List(_) => pair(stated)?[0],
        _ => value,
    };
    if across != value || conic_x != row.conic {
        let radius =
            radius(across).map_err(|found| stated.error(found, "expected 1e-6 mm or more"))?;
        row.across = Some(CrossSection::Biconic { radius, conic: conic_x });
    }
    if let Some(terms) = surface.get("aspheric_coefficients").filter(|value| !is_empty(value)) {
        row.asphere = asphere(terms, left_out)?;
    }
    let index_of = |medium: &MediumBehind| match medium {
        MediumBehind::Index(index) => *index,
        MediumBehind::Glass(glass) => glass.nd(),
        _ => 1.0,
    };
    let before = system.surfaces.last().map_or(MediumBehind::Air, |before| before.medium.clone());
    let stated = surface.need("ior")?;
    let mut behind = index(stated, left_out)?;
    if row.stop && index_of(&behind) == index_of(&before) {
        behind = before;
    }
    let semi = surface.need("semi_aperture")?;
    let semi_diameter = semi.number()?;
    if semi_diameter <= 0.0 {
        let found = format!("a semi-aperture of {semi_diameter}");
        return Err(semi.error(found, "expected more than 0 mm"));
    }
    Ok(SystemSurface {
        line: surface.line.number,
        row,
        medium: behind,
        semi_diameter: Some(semi_diameter),
        clips: true,
        ..SystemSurface::default()
    })
}

/// Numbers along x and y: a list of two, or one for both.
fn pair(value: &Json<'_>) -> Result<[f64; 2], LensError> {
    match value.numbers()?[..] {
        [both] => Ok([both; 2]),
        [x, y] => Ok([x, y]),
        ref all => Err(value.error(format!("{} numbers", all.len()), "expected one, or [x, y]")),
    }
}

/// Powers and coefficients: an object {"a4": ...}. A plain list does not say its powers.
fn asphere(terms: &Json<'_>, left_out: &mut ReadReport<'_>) -> Result<Vec<(u32, f64)>, LensError> {
    let mut found = Vec::new();
    for (name, value) in terms.members() {
        let power = name.trim_start_matches(['a', 'A']).parse().map_err(|_| {
            value.error(format!("a coefficient named \"{name}\""), "expected a4, a6, ...")
        })?;
        found.push((power, value.number()?));
    }
    if let Content::List(list) = &terms.content {
        let what = "a list of aspheric coefficients without their powers";
        if list.iter().any(|value| !matches!(value.number(), Ok(0.0))) {
            left_out.leave_out(&terms.line, terms.word, what)?;
        }
    }
    powers(found).map_err(|found| terms.error(found, "expected powers from 2 to 30"))
}

/// An index, or a table of wavelengths (nm) and indices.
fn index(value: &Json<'_>, left_out: &mut ReadReport<'_>) -> Result<MediumBehind, LensError> {
    let bad = |found: String| value.error(found, "expected an index from 1 to 10");
    let Content::List(list) = &value.content else {
        return medium(Some(value.number()?), None, "", left_out).map_err(bad);
    };
    let [wavelengths, indices] = &list[..] else {
        return Err(bad(format!("a list of {} values", list.len())));
    };
    let (wavelengths, indices) = (wavelengths.numbers()?, indices.numbers()?);
    let mut table: Vec<[f64; 2]> =
        wavelengths.iter().zip(&indices).map(|(&nm, &index)| [nm, index]).collect();
    let rises = table.windows(2).all(|pair| pair[0][0] < pair[1][0]);
    let plausible = |&[nm, index]: &[f64; 2]| nm > 0.0 && (MIN_INDEX..=MAX_INDEX).contains(&index);
    if table.is_empty() || wavelengths.len() != indices.len() || !rises {
        return Err(bad(format!("{} wavelengths, {} indices", wavelengths.len(), indices.len())));
    }
    if let Some([nm, index]) = table.iter().find(|entry| !plausible(entry)) {
        return Err(bad(format!("an index of {index} at {nm} nm")));
    }
    match table[..] {
        [[_, only]] => medium(Some(only), None, "", left_out).map_err(bad),
        _ if table.iter().all(|[_, index]| *index == 1.0) => Ok(MediumBehind::Air),
        _ => Ok(MediumBehind::Glass(Glass::Table(std::mem::take(&mut table).into()))),
    }
}
