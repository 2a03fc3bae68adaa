//! Reader of the lens tables of polynomial-optics: a line for each surface, without sections.
//!
//! A line is `radius thickness material [nd Vd] housing-radius`. The material is `air`, `iris` (the
//! stop, in the medium before it) or a word; `cx_` before it tells a cylinder that bends light along
//! x. A thickness `a/b/c` holds the short, middle and long state of a zoom. `#!scale s` scales the
//! lengths behind it, and `#!aspheric=k,a4,a6,a8,a10` states conic constant and coefficients.

use std::path::Path;

use super::super::MAX_SURFACES;
use super::super::checks::{even_powers, medium, radius};
use super::super::report::ReadReport;
use super::super::text::Line;
use petzval_base::io::ReadContext;
use petzval_lens::INFINITE;
use petzval_lens::LensError;
use petzval_lens::system::{MediumBehind, SequentialSystem, SystemSurface, choose_stop};
use petzval_lens::{Configuration, Quantity, Setting};
use petzval_lens::{Prescription, Row, TransverseAxis};

/// Columns of a line, for messages.
const COLUMNS: &str = "expected radius thickness material [nd Vd] housing-radius";

/// Names of the states of a zoom.
const STATES: [&str; 3] = ["short", "middle", "long"];

/// Parses a text.
///
/// # Errors
/// Returns an error with line and column if a line is invalid or the text describes no lens.
pub(super) fn parse(
    path: &Path,
    text: &str,
    context: &ReadContext,
) -> Result<Prescription, LensError> {
    let mut report = ReadReport::new(context);
    let mut system = SequentialSystem::default();
    let mut zoom: Vec<(usize, [f64; 3])> = Vec::new();
    let mut scale = 1.0;
    for line in Line::all(path, text) {
        let content = line.text.trim();
        if let Some(value) = content.strip_prefix("#!scale") {
            let value = value.trim_start_matches([' ', '\t', '=', ':']);
            scale = line.number_of(value)?;
            if scale <= 0.0 {
                let found = format!("a scale of {scale}");
                return Err(line.error(value, found, "expected a factor above 0"));
            }
        } else if !content.is_empty() && !content.starts_with(['#', '/']) {
            if system.surfaces.len() == MAX_SURFACES {
                let found = format!("more than {MAX_SURFACES} surfaces");
                return Err(line.error(content, found, "expected one lens"));
            }
            let (surface, thicknesses) = surface(&line, scale, &mut report)?;
            if thicknesses.iter().any(|thickness| *thickness != thicknesses[0]) {
                zoom.push((system.surfaces.len(), thicknesses));
            }
            system.surfaces.push(surface);
        }
    }
    if !zoom.is_empty() {
        let state = |(i, name): (usize, &&str)| Configuration {
            name: (*name).to_owned(),
            settings: zoom
                .iter()
                .map(|&(row, values)| Setting {
                    row,
                    quantity: Quantity::Thickness,
                    value: values[i],
                })
                .collect(),
            ..Configuration::default()
        };
        system.design.configurations = STATES.iter().enumerate().map(state).collect();
    }
    if !system.surfaces.iter().any(|surface| surface.row.stop) {
        choose_stop(&mut system.surfaces);
    }
    system.design.notes.extend(report.finish());
    system.build(path)
}

/// Reads a surface, and its thicknesses in the states of the zoom (mm).
fn surface(
    line: &Line<'_>,
    scale: f64,
    report: &mut ReadReport<'_>,
) -> Result<(SystemSurface, [f64; 3]), LensError> {
    let (columns, asphere) = match line.text.split_once("#!aspheric=") {
        Some((columns, asphere)) => (columns, Some(asphere)),
        None => (line.text, None),
    };
    let columns = columns.split('#').next().unwrap_or_default();
    let words: Vec<&str> = columns.split_whitespace().collect();
    let [radius_word, thickness, material, numbers @ ..] = &words[..] else {
        return Err(line.error(words[0], format!("{} columns", words.len()), COLUMNS));
    };
    let stated = scale * line.length_of(radius_word)?;
    let mut row = Row {
        radius: radius(stated)
            .map_err(|found| line.error(radius_word, found, "expected 1e-6 mm or more"))?,
        ..Row::default()
    };
    let mut thicknesses = Vec::new();
    for word in thickness.split('/') {
        let value = scale * line.number_of(word)?;
        if value.abs() >= INFINITE {
            return Err(line.error(word, format!("a thickness of {value} mm"), "expected less"));
        }
        thicknesses.push(value);
    }
    let [short, others @ ..] = &thicknesses[..] else {
        return Err(line.error(thickness, "no thickness", COLUMNS));
    };
    if others.len() > 2 {
        let found = format!("{} thicknesses", thicknesses.len());
        return Err(line.error(thickness, found, "expected short/middle/long"));
    }
    // A state that is not stated is the short one.
    let states = [0, 1, 2].map(|i: usize| *thicknesses.get(i).unwrap_or(short));
    row.thickness = *short;
    let name = match material.strip_prefix("cx_") {
        Some(name) => {
            row.axis = (!row.radius.is_infinite()).then_some(TransverseAxis::Y);
            name
        }
        None => material,
    };
    let (index, abbe, housing) = match numbers {
        [housing] => (None, None, housing),
        [index, abbe, housing] => {
            (Some(line.number_of(index)?), Some(line.number_of(abbe)?), housing)
        }
        _ => {
            let found = format!("{} columns", words.len());
            return Err(line.error(radius_word, found, COLUMNS));
        }
    };
    let housing_radius = scale * line.number_of(housing)?;
    if housing_radius <= 0.0 {
        let found = format!("a housing radius of {housing_radius} mm");
        return Err(line.error(housing, found, "expected more than 0"));
    }
    let medium = match name.to_ascii_lowercase().as_str() {
        "iris" => {
            // Files give the plane of the iris a large radius.
            row.stop = true;
            row.radius = f64::INFINITY;
            row.axis = None;
            MediumBehind::Same
        }
        "air" => MediumBehind::Air,
        _ => medium(index, abbe, name, report).map_err(|found| {
            line.error(material, found, "expected nd from 1 to 10 and Vd behind the material")
        })?,
    };
    if let Some(text) = asphere {
        let words: Vec<&str> = text.split(',').map(str::trim).collect();
        let values =
            words.iter().map(|word| line.number_of(word)).collect::<Result<Vec<f64>, _>>()?;
        let (Some(conic), Some(terms)) = (values.first(), values.get(1..=4)) else {
            let found = format!("{} aspheric coefficients", values.len());
            return Err(line.error(text, found, "expected k,a4,a6,a8,a10"));
        };
        row.conic = *conic;
        row.asphere = even_powers(4, terms)
            .map_err(|found| line.error(text, found, "expected k,a4,a6,a8,a10"))?;
    }
    let surface = SystemSurface {
        line: line.number,
        row,
        medium,
        semi_diameter: Some(housing_radius),
        clips: true,
        ..SystemSurface::default()
    };
    Ok((surface, states))
}
