//! Reader of the JSON of DeepLens: surfaces of curvature, semi-diameter and the material behind.
//!
//! The coefficients `ai` are those of the powers 2, 4, 6, ...; "1.83481/42.7" is a material of that
//! index and Abbe number.

use std::path::Path;

use super::ReadReport;
use super::value::Json;
use crate::checks::{even_powers, medium, radius, radius_of_curvature};
use petzval_lens::LensError;
use petzval_lens::RayTransferMatrix;
use petzval_lens::system::{MediumBehind, SequentialSystem, SystemSurface};
use petzval_lens::{Prescription, Row};

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
    let stated = |names: &[&str]| json.any(names).map(Json::number).transpose();
    let info = json.any(&["name", "info"]).and_then(Json::text).unwrap_or_default();
    let mut system = SequentialSystem {
        name: info.to_owned(),
        focal_length: stated(&["foclen"])?,
        f_number: stated(&["fnum"])?.filter(|number| *number > 0.0),
        ..SequentialSystem::default()
    };
    for surface in surfaces.list()? {
        let kind = surface.need("type")?.text().unwrap_or_default().to_ascii_lowercase();
        if kind == "sensor" {
            break;
        }
        let read = read_surface(surface, &kind, left_out)?;
        system.surfaces.push(read);
    }
    system.design.notes.extend(left_out.take_notes());
    system.build(path)
}

fn read_surface(
    surface: &Json<'_>,
    kind: &str,
    left_out: &mut ReadReport<'_>,
) -> Result<SystemSurface, LensError> {
    let place = surface.need("type")?;
    let mut row = Row::default();
    match kind {
        "spheric" | "aspheric" | "asphericnorm" => {
            row.radius = match surface.any(&["roc", "c", "(c)"]) {
                None => f64::INFINITY,
                Some(value) => {
                    let number = value.number_or_infinity()?;
                    let found = match surface.get("roc") {
                        Some(_) => radius(number),
                        None => radius_of_curvature(number),
                    };
                    found.map_err(|found| value.error(found, "expected 1e-6 mm or more"))?
                }
            };
            if let Some(conic) = surface.get("k").filter(|_| kind != "spheric") {
                row.conic = conic.number()?;
            }
            if kind == "asphericnorm" {
                left_out.leave_out(&place.line, place.word, "an asphere of normalized height")?;
            } else if let Some(terms) = surface.get("ai").filter(|_| kind == "aspheric") {
                row.asphere = even_powers(2, &terms.numbers()?)
                    .map_err(|found| terms.error(found, "expected powers up to 30"))?;
            }
        }
        "plane" => {}
        "aperture" | "stop" => row.stop = true,
        "thinlens" => {
            let focal_length = surface.any(&["foclen", "f"]).ok_or_else(|| {
                surface.error("a thin lens without \"foclen\"", "expected its focal length")
            })?;
            let value = focal_length.number()?;
            if value == 0.0 {
                return Err(focal_length.error("a focal length of 0", "expected another"));
            }
            let matrix = RayTransferMatrix { c: -1.0 / value, ..RayTransferMatrix::IDENTITY };
            row.ideal = Some([matrix; 2]);
        }
        _ => {
            let what = format!("a surface of the type \"{}\"", place.text().unwrap_or_default());
            left_out.leave_out(&place.line, place.word, &what)?;
        }
    }
    row.thickness = match surface.get("d_next") {
        Some(thickness) => thickness.number()?,
        None => 0.0,
    };
    let medium = match surface.get("mat2") {
        None => MediumBehind::Same,
        Some(material) => {
            let name = material.text().unwrap_or_default();
            medium(None, None, name, left_out)
                .map_err(|found| material.error(found, "expected a glass, or \"index/Abbe\""))?
        }
    };
    // Square surfaces state their side.
    let side = surface.any(&["l", "size"]).map(Json::number).transpose()?;
    let semi = match surface.get("r") {
        Some(semi) => Some(semi.number()?),
        None => side.map(|side| side / std::f64::consts::SQRT_2),
    };
    if surface.get("is_square").is_some_and(Json::is_true) && row.stop {
        left_out.leave_out(&place.line, place.word, "a square stop")?;
    }
    Ok(SystemSurface {
        line: surface.line.number,
        row,
        medium,
        semi_diameter: semi.filter(|semi| *semi > 0.0),
        clips: false,
        ..SystemSurface::default()
    })
}
