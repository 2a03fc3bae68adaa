//! One `[[surface]]` table: its keys and its shape.

use super::aperture;
use super::coating;
use super::iris;
use super::medium;
use super::pose;
use super::value::Section;
use crate::{MAX_POWER, MIN_RADIUS};
use petzval_base::io::excerpt;
use petzval_lens::LayerStack;
use petzval_lens::LensError;
use petzval_lens::RayTransferMatrix;
use petzval_lens::{CrossSection, Row, TransverseAxis};

const KEYS: &[&str] = &[
    "radius",
    "thickness",
    "diameter",
    "index",
    "abbe",
    "glass",
    "stop",
    "conic",
    "shape",
    "radius_x",
    "conic_x",
    "asphere",
    "axis",
    "coating",
    "obstruction",
    "apertures",
    "mirror",
    "formula",
    "ideal",
    "blades",
    "rotation",
    "curvature",
    "aperture",
    "decentre",
    "tilt",
];

/// Reads a surface; `stacks` are the coatings that the file defines, `previous` is the surface before it,
/// or air, and `last` is true if none follows.
pub(super) fn read(
    section: &Section,
    stacks: &[LayerStack],
    previous: &Row,
    last: bool,
) -> Result<Row, LensError> {
    section.reject_unknown_keys(KEYS)?;
    let row = Row { stop: section.boolean("stop")?, ..shape(section)? };
    let mirror = section.boolean("mirror")?;
    let (index, glass) = match mirror {
        true => medium::behind_mirror(section, previous)?,
        false => medium::read(section, &row, previous, last)?,
    };
    let ideal = section.numbers(
        "ideal",
        8,
        "expected ideal = [[a, b, c, d], [a, b, c, d]], ray-transfer matrices along x and y",
    )?;
    let matrix = |v: &[f64]| RayTransferMatrix { a: v[0], b: v[1], c: v[2], d: v[3] };
    Ok(Row {
        ideal: ideal.map(|v| [matrix(&v[..4]), matrix(&v[4..])]),
        index,
        glass,
        mirror,
        iris: iris::read(section, row.stop)?,
        apertures: aperture::read(section)?,
        coating: coating::of_surface(section, stacks, [previous.index, index])?,
        pose: pose::read(section)?,
        ..row
    })
}

fn shape(section: &Section) -> Result<Row, LensError> {
    let radius = radius(section, "radius")?;
    let row = Row {
        radius,
        conic: section.finite("conic")?.unwrap_or(0.0),
        asphere: asphere(section)?,
        across: across(section)?,
        axis: axis(section)?,
        thickness: section.finite("thickness")?.unwrap_or(0.0),
        diameter: diameter(section)?,
        ..Row::default()
    };
    let half = row.diameter / 2.0;
    if row.diameter > row.edge() {
        let across =
            row.across.map(|across| format!(" along y, {} along x", 1.0 / across.curvature()));
        let across = across.unwrap_or_default();
        let found = format!("diameter {} on a radius of {radius}{across}", row.diameter);
        let expected = match row.conic {
            _ if row.across.is_some() => {
                format!("the surface ends at a diameter of {:.6} mm", row.edge())
            }
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

fn radius(section: &Section, key: &str) -> Result<f64, LensError> {
    match section.number(key)? {
        Some(radius) if radius != 0.0 && radius.abs() < MIN_RADIUS => {
            let found = format!("{key} is {radius:e}");
            Err(section.error(key, found, "expected 1e-6 mm or more, or 0 for a plane"))
        }
        Some(radius) if radius != 0.0 && radius.is_finite() => Ok(radius),
        _ => Ok(f64::INFINITY),
    }
}

/// Reads the section along x of a biconic or a toroid.
fn across(section: &Section) -> Result<Option<CrossSection>, LensError> {
    let Some(shape) = section.string("shape")? else {
        for key in ["radius_x", "conic_x"] {
            if section.has(key) {
                let expected = "expected shape = \"biconic\" or \"toroid\" beside it";
                return Err(section.error(key, format!("{key} without a shape"), expected));
            }
        }
        return Ok(None);
    };
    if section.has("axis") {
        let expected = "leave axis out: radius_x = 0 makes a toroid straight along x";
        return Err(section.error("axis", "axis and shape on one surface", expected));
    }
    let radius = radius(section, "radius_x")?;
    if !section.has("radius_x") {
        let expected = "expected radius_x, the radius along x in mm, or 0 for none";
        return Err(section.error(
            "shape",
            format!("a {} without radius_x", excerpt(shape)),
            expected,
        ));
    }
    match shape {
        "biconic" => {
            let conic = section.finite("conic_x")?.unwrap_or(0.0);
            Ok(Some(CrossSection::Biconic { radius, conic }))
        }
        "toroid" if section.has("conic_x") => {
            let expected = "leave it out: a toroid is circular along x";
            Err(section.error("conic_x", "conic_x on a toroid", expected))
        }
        "toroid" => Ok(Some(CrossSection::Toroid { radius })),
        other => {
            let found = format!("shape is \"{}\"", excerpt(other));
            Err(section.error("shape", found, "expected \"biconic\" or \"toroid\""))
        }
    }
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
        if !(2.0..=f64::from(MAX_POWER)).contains(&power) || power.fract() != 0.0 {
            return error(format!("power {power}"), "expected a whole number from 2 to 30");
        }
        let power = power as u32;
        if terms.iter().any(|(earlier, _)| *earlier == power) {
            return error(format!("power {power} is stated twice"), "expected each power once");
        }
        terms.push((power, coefficient));
    }
    Ok(terms)
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
