//! One `[[surface]]`: its keys and its shape.

use super::medium;
use super::opening;
use super::pose;
use super::value::Section;
use crate::lens::coating::Coating;
use crate::lens::error::LensError;
use crate::lens::file::LEAST_RADIUS;
use crate::lens::prescription::{Axis, Row};
use crate::source::{excerpt, hint};

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

/// Reads a surface; `ahead` is the one before it, or air, and `last` says that none follows.
pub(super) fn read(section: &Section, ahead: &Row, last: bool) -> Result<Row, LensError> {
    section.only(KEYS)?;
    let row = Row { stop: section.flag("stop")?, ..shape(section)? };
    let (index, glass) = medium::read(section, &row, ahead, last)?;
    Ok(Row {
        index,
        glass,
        iris: opening::read(section, row.stop)?,
        coating: coating(section, [ahead.index, index])?,
        pose: pose::read(section)?,
        ..row
    })
}

fn shape(section: &Section) -> Result<Row, LensError> {
    let radius = match section.number("radius")? {
        Some(radius) if radius != 0.0 && radius.abs() < LEAST_RADIUS => {
            let found = format!("radius is {radius:e}");
            return Err(section.refuse(
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

/// `indices` are those before and behind the surface.
fn coating(section: &Section, indices: [f64; 2]) -> Result<Option<Coating>, LensError> {
    let Some(name) = section.text("coating")? else { return Ok(None) };
    let name = excerpt(name);
    let Some(coating) = Coating::named(&name) else {
        let found = format!("coating is \"{name}\"{}", hint(&name, Coating::NAMES));
        let expected = format!("expected {}", Coating::NAMES.join(", "));
        return Err(section.refuse("coating", found, expected));
    };
    let layers = matches!(coating, Coating::Mgf2 | Coating::Broadband);
    if layers && !Coating::fits(indices) {
        let found = format!("{} between indices {} and {}", coating.name(), indices[0], indices[1]);
        let expected = "leave it out: only faces of glass to air are coated";
        return Err(section.refuse("coating", found, expected));
    }
    Ok(Some(coating))
}

fn axis(section: &Section) -> Result<Option<Axis>, LensError> {
    let axis = match section.text("axis")? {
        None => return Ok(None),
        Some("x") => Axis::X,
        Some("y") => Axis::Y,
        Some(other) => {
            let found = format!("axis is \"{}\"", excerpt(other));
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
