//! Reader of the text of the Optical Bench (Bill Claff, photonstophotos.net): sections of lines
//! whose cells are separated by tabs.
//!
//! `[lens data]` has the columns number, radius (or AS, FS, CG: aperture stop, field stop, cover
//! glass), thickness or its name, index, diameter, Abbe number, and perhaps a glass and its maker.
//! `[variable distances]` gives the named thicknesses for each state of zoom and focus; the first
//! state is the one that is read. Figures, notes and groups do not change the lens.

mod aspheres;
mod sections;
mod states;

use std::path::Path;

use self::sections::{Cell, Sections};
use self::states::States;
use super::checks::{medium, radius};
use super::report::ReadReport;
use super::text::Line;
use petzval_base::io::ReadContext;
use petzval_lens::LensError;
use petzval_lens::system::{MAX_SURFACES, SequentialSystem, SystemAperture, SystemSurface};
use petzval_lens::{FieldKind, Fields};
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
    let sections = Sections::read(path, text);
    let states = States::read(&sections)?;
    let mut system = SequentialSystem {
        name: sections.text("descriptive data", "title").unwrap_or_default().to_owned(),
        focal_length: states.value("Focal Length", 0)?,
        f_number: states.value("F-Number", 0)?.filter(|number| *number > 0.0),
        ..SequentialSystem::default()
    };
    system.aperture = system.f_number.map(SystemAperture::FNumber);
    if let Some(angle) = states.value("Angle of View", 0)?.filter(|angle| *angle > 0.0) {
        let points = [0.0, 0.7, 1.0].map(|share| [0.0, share * angle / 2.0]).to_vec();
        system.design.fields = Some(Fields { kind: FieldKind::Angle, points });
    }
    system.design.object_distance = states.value("d0", 0)?;
    for (line, cells) in sections.rows("lens data") {
        if cells.len() < 2 {
            continue;
        }
        if system.surfaces.len() == MAX_SURFACES {
            let found = format!("more than {MAX_SURFACES} surfaces");
            return Err(line.error(cells[0], found, "expected one lens"));
        }
        let surface = surface(line, cells, &states, &mut report)?;
        system.surfaces.push(surface);
    }
    let numbers: Vec<&str> = sections
        .rows("lens data")
        .filter(|(_, cells)| cells.len() >= 2)
        .map(|(_, cells)| cells[0])
        .collect();
    aspheres::read(&sections, &numbers, &mut system)?;
    states.configure(&sections, &mut system)?;
    system.design.notes.extend(report.finish());
    system.build(path)
}

/// Reads a line of the lens data.
fn surface(
    line: &Line<'_>,
    cells: &[Cell<'_>],
    states: &States<'_>,
    report: &mut ReadReport<'_>,
) -> Result<SystemSurface, LensError> {
    let cell = |i: usize| cells.get(i).copied().unwrap_or_default();
    let optional = |i: usize| match cell(i) {
        "" | "undefined" => Ok(None),
        word => sections::number(line, word).map(Some),
    };
    let mut row = Row::default();
    let mut clips = false;
    match cell(1).to_ascii_uppercase().as_str() {
        "AS" | "STO" | "STOP" => row.stop = true,
        "FS" => clips = true,
        "CG" | "∞" | "-∞" => {}
        _ => {
            let value = sections::length(line, cell(1))?;
            let expected = "expected 1e-6 mm or more, or AS, FS, CG or Infinity";
            row.radius = radius(value).map_err(|found| line.error(cell(1), found, expected))?;
        }
    }
    row.thickness = states.thickness(line, cell(2))?;
    let diameter = optional(4)?;
    let diameter = match row.stop {
        true => states.value("Aperture Diameter", 0)?.filter(|value| *value > 0.0).or(diameter),
        false => diameter,
    };
    if let Some(value) = diameter.filter(|value| *value < 0.0) {
        let expected = "expected the clear diameter in mm";
        return Err(line.error(cell(4), format!("diameter {value}"), expected));
    }
    // The two names that may follow are of the same glass, of two makers.
    let index = match optional(3)? {
        None => Some(1.0),
        index => index,
    };
    let medium = medium(index, optional(5)?, cell(6), report)
        .map_err(|found| line.error(cell(3), found, "expected an index from 1 to 10"))?;
    let semi_diameter = diameter.map(|diameter| diameter / 2.0).filter(|semi| *semi > 0.0);
    Ok(SystemSurface { line: line.number, row, medium, semi_diameter, clips, ..Default::default() })
}
