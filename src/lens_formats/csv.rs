//! Reader of tables with a line of column names: "radius;thickness;material;index;v-no;sa".
//!
//! A plane has no radius; the stop is a plane with air on both sides; "sa" is the semi-aperture.

use std::path::Path;

use super::checks::{medium, radius};
use super::report::ReadReport;
use super::text::Line;
use petzval_base::io::ReadContext;
use petzval_lens::LensError;
use petzval_lens::system::{SequentialSystem, SystemSurface, choose_stop};
use petzval_lens::{Prescription, Row};

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
    let mut system =
        SequentialSystem { column_of_semi_diameters: true, ..SequentialSystem::default() };
    let mut columns: Option<(char, Vec<String>)> = None;
    for line in Line::all(path, text) {
        let content = line.text.trim();
        if content.is_empty() || content.starts_with('#') {
            continue;
        }
        let Some((separator, names)) = &columns else {
            let separator = if content.contains(';') { ';' } else { ',' };
            let names = content.split(separator).map(|name| name.trim().to_lowercase()).collect();
            columns = Some((separator, names));
            continue;
        };
        let cells: Vec<&str> = line.text.split(*separator).map(str::trim).collect();
        if cells.iter().all(|cell| cell.is_empty()) {
            continue;
        }
        if cells.len() > names.len() {
            let found = format!("{} columns", cells.len());
            return Err(line.error(content, found, &format!("expected {}", names.join(" "))));
        }
        let surface = surface(&line, names, &cells, &mut report)?;
        system.surfaces.push(surface);
    }
    choose_stop(&mut system.surfaces);
    system.design.notes.extend(report.finish());
    system.build(path)
}

fn surface(
    line: &Line<'_>,
    names: &[String],
    cells: &[&str],
    report: &mut ReadReport<'_>,
) -> Result<SystemSurface, LensError> {
    let cell = |aliases: &[&str]| {
        let at = names.iter().position(|name| aliases.contains(&name.as_str()))?;
        cells.get(at).copied().filter(|cell| !cell.is_empty())
    };
    let number = |aliases: &[&str]| cell(aliases).map(|cell| line.number_of(cell)).transpose();
    let mut row = Row::default();
    if let Some(word) = cell(&["radius", "roc"]) {
        row.radius = radius(line.length_of(word)?)
            .map_err(|found| line.error(word, found, "expected 1e-6 mm or more, or nothing"))?;
    }
    row.thickness = number(&["thickness", "distance"])?.unwrap_or(0.0);
    if let Some(conic) = number(&["conic", "k"])? {
        row.conic = conic;
    }
    let name = cell(&["material", "glass"]).unwrap_or_default();
    let index = number(&["index", "ior", "n", "nd"])?;
    let medium = medium(index, number(&["v-no", "vd", "abbe", "v"])?, name, report)
        .map_err(|found| line.error(line.text, found, "expected an index from 1 to 10, or air"))?;
    let full = number(&["diameter"])?.map(|diameter| diameter / 2.0);
    let semi = number(&["sa", "semi_aperture", "semi-aperture", "semi-diameter"])?;
    let semi_diameter = semi.or(full).filter(|semi| *semi > 0.0);
    let line = line.number;
    Ok(SystemSurface { line, row, medium, semi_diameter, clips: true, ..SystemSurface::default() })
}
