//! Reader of the JSON of optiland: surfaces at positions along z, object first, image last.
//!
//! The coefficients of an even asphere are those of the powers 2, 4, 6, ...; those of an odd one of
//! 1, 2, 3, ...

use std::path::Path;

use super::ReadReport;
use super::value::{Content, Json};
use crate::checks::{even_powers, medium, powers, radius};
use petzval_lens::LensError;
use petzval_lens::system::{MediumBehind, SequentialSystem, SystemAperture, SystemSurface};
use petzval_lens::{FieldKind, Fields, SpectralLine};
use petzval_lens::{Prescription, Row};

/// Reads a lens.
///
/// # Errors
/// Returns an error with line and column if a surface is invalid or not simulated.
pub(super) fn read(
    path: &Path,
    json: &Json<'_>,
    left_out: &mut ReadReport<'_>,
) -> Result<Prescription, LensError> {
    let mut system = SequentialSystem {
        name: json.get("name").and_then(Json::text).unwrap_or_default().to_owned(),
        ..SequentialSystem::default()
    };
    specify(json, &mut system, left_out)?;
    let surfaces = json.need("surface_group")?.need("surfaces")?.list()?;
    let [object, lens @ .., _] = surfaces else {
        return Err(json.error("no surfaces", "expected object, surfaces and image"));
    };
    let mut positions = Vec::new();
    for surface in surfaces {
        positions.push(position(surface, left_out)?);
    }
    let distance = positions.get(1).map_or(f64::INFINITY, |first| first - positions[0]);
    system.design.object_distance = Some(distance.abs());
    system.object_medium = material(object, "material_post", left_out)?;
    for (i, surface) in lens.iter().enumerate() {
        let thickness = positions[i + 2] - positions[i + 1];
        if !thickness.is_finite() {
            return Err(surface.error("an infinite thickness", "expected a finite position z"));
        }
        let mut read = read_surface(surface, left_out)?;
        read.row.thickness = thickness;
        system.surfaces.push(read);
    }
    if let Some(SystemAperture::EntrancePupil(0.0)) = system.aperture {
        system.aperture = None;
    }
    system.design.notes.extend(left_out.take_notes());
    system.build(path)
}

/// Returns the position of a surface along z.
fn position(surface: &Json<'_>, left_out: &mut ReadReport<'_>) -> Result<f64, LensError> {
    let frame = surface.need("geometry")?.need("cs")?;
    for name in ["x", "y", "rx", "ry", "rz"] {
        if let Some(value) = frame.get(name)
            && value.number()? != 0.0
        {
            left_out.leave_out(&value.line, value.word, "a tilted or decentred surface")?;
        }
    }
    frame.need("z")?.number_or_infinity()
}

fn read_surface(
    surface: &Json<'_>,
    left_out: &mut ReadReport<'_>,
) -> Result<SystemSurface, LensError> {
    let is = |name: &str| surface.get(name).is_some_and(Json::is_true);
    let mut row = Row { stop: is("is_stop"), ..Row::default() };
    let shape = surface.need("geometry")?;
    let kind = shape.need("type")?;
    if let Some(value) = shape.get("radius") {
        row.radius = radius(value.number_or_infinity()?)
            .map_err(|found| value.error(found, "expected 1e-6 mm or more"))?;
    }
    if let Some(conic) = shape.any(&["conic", "k"]) {
        row.conic = conic.number()?;
    }
    let coefficients = match shape.any(&["coefficients", "c"]) {
        Some(list) => list.numbers().unwrap_or_default(),
        None => Vec::new(),
    };
    let terms = match kind.text().unwrap_or_default() {
        "Plane" | "StandardGeometry" => Ok(Vec::new()),
        "EvenAsphere" => even_powers(2, &coefficients),
        "OddAsphere" => powers((1..).zip(coefficients)),
        name => {
            let what = format!("a surface of the type \"{name}\"");
            left_out.leave_out(&kind.line, kind.word, &what)?;
            Ok(Vec::new())
        }
    };
    row.asphere = terms.map_err(|found| kind.error(found, "expected powers from 2 to 30"))?;
    let reflects = is("is_reflective")
        || surface
            .get("interaction_model")
            .is_some_and(|model| model.get("is_reflective").is_some_and(Json::is_true));
    let medium = match reflects {
        true => MediumBehind::Mirror,
        false => material(surface, "material_post", left_out)?,
    };
    let kind = surface.get("type").and_then(Json::text).unwrap_or("Surface");
    if kind == "ParaxialSurface" {
        left_out.leave_out(&surface.line, surface.word, "an ideal lens of optiland")?;
    }
    let mut semi_diameter = None;
    if let Some(aperture) = surface.get("aperture") {
        let outer = aperture.get("r_max").map(Json::number_or_infinity).transpose()?;
        match outer {
            Some(semi) if semi.is_finite() && semi > 0.0 => semi_diameter = Some(semi),
            Some(_) => {}
            None => left_out.leave_out(
                &aperture.line,
                aperture.word,
                "an aperture that is no circle",
            )?,
        }
        if let Some(inner) = aperture.get("r_min") {
            row.obstruction = 2.0 * inner.number()?.max(0.0);
        }
    }
    let clips = semi_diameter.is_some();
    let line = surface.line.number;
    Ok(SystemSurface { line, row, medium, semi_diameter, clips, ..SystemSurface::default() })
}

fn material(
    surface: &Json<'_>,
    name: &str,
    left_out: &mut ReadReport<'_>,
) -> Result<MediumBehind, LensError> {
    let Some(material) = surface.get(name) else { return Ok(MediumBehind::Same) };
    let bad =
        |found: String| material.error(found, "expected a material with an index or a known glass");
    let number = |name: &str| match material.get(name) {
        Some(value) => match &value.content {
            Content::List(list) => list.first().map(Json::number).transpose(),
            _ => value.number().map(Some),
        },
        None => Ok(None),
    };
    let kind = material.get("type").and_then(Json::text).unwrap_or_default();
    if kind == "Mirror" {
        return Ok(MediumBehind::Mirror);
    }
    let glass = material.get("name").and_then(Json::text).unwrap_or_default();
    let file = material.get("filename").and_then(Json::text).unwrap_or_default();
    let stem = file.rsplit(['/', '\\']).next().unwrap_or_default();
    let glass = if glass.is_empty() { stem.trim_end_matches(".yml") } else { glass };
    let index = number("index")?;
    if index.is_none() && glass.is_empty() {
        return Err(bad(format!("a material of the type \"{kind}\"")));
    }
    medium(index, number("abbe")?, glass, left_out).map_err(bad)
}

/// Reads aperture, fields and wavelengths.
fn specify(
    json: &Json<'_>,
    system: &mut SequentialSystem,
    left_out: &mut ReadReport<'_>,
) -> Result<(), LensError> {
    if let Some(aperture) = json.get("aperture") {
        let kind = aperture.any(&["type", "ap_type"]);
        let value = aperture.need("value")?.number()?;
        match kind.and_then(Json::text).unwrap_or_default() {
            _ if value <= 0.0 => {}
            "EPD" => system.aperture = Some(SystemAperture::EntrancePupil(value)),
            "imageFNO" => {
                system.aperture = Some(SystemAperture::FNumber(value));
                system.f_number = Some(value);
            }
            "objectNA" => system.aperture = Some(SystemAperture::ObjectNa(value)),
            "float_by_stop_size" => {}
            name => {
                let what = format!("an aperture of the type \"{name}\"");
                left_out.leave_out(&aperture.line, aperture.word, &what)?;
            }
        }
    }
    if let Some(fields) = json.get("fields") {
        let list = fields.need("fields")?.list()?;
        let kind = fields.get("field_type").or_else(|| list.first()?.get("field_type"));
        let kind = match kind.and_then(Json::text).unwrap_or("angle") {
            "angle" => FieldKind::Angle,
            "object_height" => FieldKind::ObjectHeight,
            _ => FieldKind::ImageHeight,
        };
        let mut points = Vec::new();
        for field in list {
            points.push([field.need("x")?.number()?, field.need("y")?.number()?]);
        }
        system.design.fields = Some(Fields { kind, points });
    }
    if let Some(light) = json.get("wavelengths") {
        for line in light.need("wavelengths")?.list()? {
            let unit = match line.get("unit").and_then(Json::text).unwrap_or("um") {
                "nm" => 1.0,
                "mm" => 1e6,
                _ => 1e3,
            };
            let weight = line.get("weight").map(Json::number).transpose()?.unwrap_or(1.0);
            let nm = unit * line.need("value")?.number()?;
            if line.get("is_primary").is_some_and(Json::is_true) {
                system.design.primary = system.design.wavelengths.len();
            }
            system.design.wavelengths.push(SpectralLine { nm, weight });
        }
    }
    Ok(())
}
