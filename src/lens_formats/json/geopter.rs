//! Reader of the JSON of Geopter: numbered surfaces of curvature, thickness and material; object
//! first, image last.
//!
//! The coefficients of an asphere are those of the powers 4, 6, 8, ...

use std::path::Path;

use super::ReadReport;
use super::value::Json;
use crate::checks::{even_powers, medium, radius_of_curvature};
use petzval_lens::LensError;
use petzval_lens::system::{SequentialSystem, SystemAperture, SystemSurface};
use petzval_lens::{FieldKind, Fields, SpectralLine};
use petzval_lens::{Prescription, Row};

/// Distance beyond which an object is distant (mm): Geopter writes 1e10.
const DISTANT: f64 = 1e9;

/// Reads a lens.
///
/// # Errors
/// Returns an error with line and column if a surface is invalid or not simulated.
pub(super) fn read(
    path: &Path,
    json: &Json<'_>,
    assembly: &Json<'_>,
    left_out: &mut ReadReport<'_>,
) -> Result<Prescription, LensError> {
    let text = |name: &str| json.get(name).and_then(Json::text).map(str::trim);
    let mut system = SequentialSystem {
        name: text("Title").unwrap_or_default().to_owned(),
        source: text("Note")
            .filter(|note| !note.is_empty())
            .map(|note| note.split_whitespace().collect::<Vec<_>>().join(" ")),
        ..SequentialSystem::default()
    };
    if let Some(spec) = json.get("Spec") {
        specify(spec, &mut system)?;
    }
    let mut surfaces: Vec<(usize, &Json<'_>)> = assembly
        .members()
        .iter()
        .filter_map(|(name, value)| Some((name.parse().ok()?, value)))
        .collect();
    surfaces.sort_by_key(|(number, _)| *number);
    let stop = assembly.get("Stop").map(Json::number).transpose()?;
    let [(_, object), lens @ .., _] = &surfaces[..] else {
        return Err(assembly.error("no surfaces", "expected object, surfaces and image"));
    };
    let distance = object.need("Thickness")?.number_or_infinity()?;
    system.design.object_distance =
        Some(if distance.abs() >= DISTANT { f64::INFINITY } else { distance });
    for &(number, surface) in lens {
        let mut read = read_surface(surface, left_out)?;
        let label = surface.get("Label").and_then(Json::text).unwrap_or_default();
        read.row.stop = match stop {
            Some(stop) => stop == number as f64,
            None => label.eq_ignore_ascii_case("stop"),
        };
        system.surfaces.push(read);
    }
    system.design.notes.extend(left_out.take_notes());
    system.build(path)
}

fn read_surface(
    surface: &Json<'_>,
    left_out: &mut ReadReport<'_>,
) -> Result<SystemSurface, LensError> {
    let curvature = surface.need("Curvature")?;
    let mut row = Row {
        radius: radius_of_curvature(curvature.number()?)
            .map_err(|found| curvature.error(found, "expected a radius of 1e-6 mm or more"))?,
        thickness: surface.need("Thickness")?.number()?,
        ..Row::default()
    };
    let kind = surface.need("Type")?;
    let coefficients = || match surface.get("Coefs") {
        None => Ok(Vec::new()),
        Some(terms) => terms.numbers(),
    };
    let terms = match kind.text().unwrap_or_default() {
        "SPH" => Ok(Vec::new()),
        "ASP" => even_powers(4, &coefficients()?),
        "ODD" => even_powers(3, &[]).and_then(|_| {
            let list = coefficients().unwrap_or_default();
            super::super::checks::powers((3..).zip(list))
        }),
        name => {
            let what = format!("a surface of the type \"{name}\"");
            left_out.leave_out(&kind.line, kind.word, &what)?;
            Ok(Vec::new())
        }
    };
    row.asphere = terms.map_err(|found| kind.error(found, "expected powers from 2 to 30"))?;
    if let Some(conic) = surface.get("Conic") {
        row.conic = conic.number()?;
    }
    let material = surface.need("Material")?;
    let name = material.text().unwrap_or_default();
    let medium = medium(None, None, name, left_out)
        .map_err(|found| material.error(found, "expected a glass, or \"index:Abbe\""))?;
    let mut semi_diameter = None;
    if let Some(aperture) = surface.get("Aperture") {
        let round = aperture.any(&["Radius", "MaxRadius", "R"]).or(match aperture.members() {
            [] => Some(aperture),
            _ => None,
        });
        match round.map(Json::number) {
            Some(Ok(semi)) if semi > 0.0 => semi_diameter = Some(semi),
            Some(Ok(_)) => {}
            _ => left_out.leave_out(
                &aperture.line,
                aperture.word,
                "an aperture that is no circle",
            )?,
        }
    }
    let clips = semi_diameter.is_some();
    let line = surface.line.number;
    Ok(SystemSurface { line, row, medium, semi_diameter, clips, ..SystemSurface::default() })
}

/// Reads aperture, fields and wavelengths.
fn specify(spec: &Json<'_>, system: &mut SequentialSystem) -> Result<(), LensError> {
    if let Some(pupil) = spec.get("Pupil") {
        let value = pupil.need("Value")?.number()?;
        let kind = pupil.need("Type")?;
        if value > 0.0 {
            system.aperture = Some(match kind.number()? {
                0.0 => SystemAperture::EntrancePupil(value),
                1.0 => SystemAperture::FNumber(value),
                2.0 => SystemAperture::ImageNa(value),
                3.0 => SystemAperture::ObjectNa(value),
                other => {
                    let expected = "expected 0 (entrance pupil), 1 (f-number), 2 or 3 (apertures)";
                    return Err(kind.error(format!("a pupil of the type {other}"), expected));
                }
            });
            if let Some(SystemAperture::FNumber(number)) = system.aperture {
                system.f_number = Some(number);
            }
        }
    }
    if let Some(field) = spec.get("Field") {
        let kind = match field.need("Type")?.number()? {
            0.0 => FieldKind::Angle,
            1.0 => FieldKind::ObjectHeight,
            _ => FieldKind::ImageHeight,
        };
        let coordinates = |name: &str| field.need(name).and_then(Json::numbers);
        let points = coordinates("X")?.into_iter().zip(coordinates("Y")?);
        system.design.fields = Some(Fields { kind, points: points.map(|(x, y)| [x, y]).collect() });
    }
    if let Some(light) = spec.get("Wvl") {
        let weights = match light.get("Weight") {
            None => Vec::new(),
            Some(weights) => weights.numbers()?,
        };
        let values = light.need("Value")?.numbers()?.into_iter().enumerate();
        let line = |(i, nm)| SpectralLine { nm, weight: weights.get(i).copied().unwrap_or(1.0) };
        system.design.wavelengths = values.map(line).collect();
        let primary = light.any(&["RefIndex", "Reference"]).map(Json::number).transpose()?;
        let last = system.design.wavelengths.len().saturating_sub(1);
        system.design.primary = primary.map_or(0, |primary| (primary.max(0.0) as usize).min(last));
    }
    Ok(())
}
