//! One `[[surface]]` table: its keys and its shape.

use super::iris;
use super::medium;
use super::pose;
use super::value::Section;
use crate::io::{excerpt, hint};
use crate::lens::prescription::coating::Coating;
use crate::lens::prescription::error::LensError;
use crate::lens::prescription::formats::MIN_RADIUS;
use crate::lens::prescription::{Row, TransverseAxis};

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
    "decentre",
    "tilt",
];

/// Reads a surface; `previous` is the one before it, or air, and `last` is true if none follows.
pub(super) fn read(section: &Section, previous: &Row, last: bool) -> Result<Row, LensError> {
    section.reject_unknown_keys(KEYS)?;
    let row = Row { stop: section.boolean("stop")?, ..shape(section)? };
    let (index, glass) = medium::read(section, &row, previous, last)?;
    Ok(Row {
        index,
        glass,
        iris: iris::read(section, row.stop)?,
        coating: coating(section, [previous.index, index])?,
        pose: pose::read(section)?,
        ..row
    })
}

fn shape(section: &Section) -> Result<Row, LensError> {
    let radius = match section.number("radius")? {
        Some(radius) if radius != 0.0 && radius.abs() < MIN_RADIUS => {
            let found = format!("radius is {radius:e}");
            return Err(section.error(
                "radius",
                found,
                "expected 1e-6 mm or more, or 0 for a plane",
            ));
        }
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
            k => format!("a conic with k = {k} ends before this height"),
        };
        return Err(section.error("diameter", found, expected));
    }
    if !row.sag(half).is_finite() {
        let expected = "expected smaller coefficients";
        return Err(section.error(
            "asphere",
            "an asphere with an infinite sag at its rim",
            expected,
        ));
    }
    Ok(Row { obstruction: obstruction(section, row.diameter)?, ..row })
}

fn diameter(section: &Section) -> Result<f64, LensError> {
    let expected = "expected the full clear diameter, above 0 mm";
    match section.finite("diameter")? {
        Some(diameter) if diameter > 0.0 => Ok(diameter),
        Some(diameter) => {
            Err(section.error("diameter", format!("diameter is {diameter}"), expected))
        }
        None => Err(section.error("diameter", "a surface without diameter", expected)),
    }
}

fn obstruction(section: &Section, diameter: f64) -> Result<f64, LensError> {
    let obstruction = section.finite("obstruction")?.unwrap_or(0.0);
    if (0.0..diameter).contains(&obstruction) {
        return Ok(obstruction);
    }
    let found = format!("obstruction is {obstruction}");
    let expected = format!("expected 0 to less than the diameter, {diameter} mm");
    Err(section.error("obstruction", found, expected))
}

fn asphere(section: &Section) -> Result<Vec<(u32, f64)>, LensError> {
    let form = "[[power, coefficient], ...]";
    let mut terms: Vec<(u32, f64)> = Vec::new();
    for (at, [power, coefficient]) in section.number_pairs("asphere", form)? {
        let error = |found: String, expected| Err(section.source.error_at(at, found, expected));
        if !(2.0..=20.0).contains(&power) || power.fract() != 0.0 {
            return error(format!("power {power}"), "expected a whole number from 2 to 20");
        }
        let power = power as u32;
        if terms.iter().any(|(earlier, _)| *earlier == power) {
            return error(format!("power {power} is stated twice"), "expected each power once");
        }
        terms.push((power, coefficient));
    }
    Ok(terms)
}

/// Reads the coating; `indices` are those before and behind the surface.
fn coating(section: &Section, indices: [f64; 2]) -> Result<Option<Coating>, LensError> {
    let Some(name) = section.string("coating")? else { return Ok(None) };
    let name = excerpt(name);
    let Some(coating) = Coating::named(&name) else {
        let found = format!("coating is \"{name}\"{}", hint(&name, Coating::NAMES));
        let expected = format!("expected {}", Coating::NAMES.join(", "));
        return Err(section.error("coating", found, expected));
    };
    let layers = matches!(coating, Coating::Mgf2 | Coating::Broadband);
    if layers && !Coating::applies_to(indices) {
        let found = format!("{} between indices {} and {}", coating.name(), indices[0], indices[1]);
        let expected = "leave it out: only faces of glass to air are coated";
        return Err(section.error("coating", found, expected));
    }
    Ok(Some(coating))
}

fn axis(section: &Section) -> Result<Option<TransverseAxis>, LensError> {
    let axis = match section.string("axis")? {
        None => return Ok(None),
        Some("x") => TransverseAxis::X,
        Some("y") => TransverseAxis::Y,
        Some(other) => {
            let found = format!("axis is \"{}\"", excerpt(other));
            return Err(section.error("axis", found, "expected \"x\" or \"y\""));
        }
    };
    for key in ["conic", "asphere"] {
        if section.has(key) {
            let expected = "a cylinder is a sphere in one direction; leave one of them out";
            return Err(section.error(key, format!("{key} and axis on one surface"), expected));
        }
    }
    Ok(Some(axis))
}
