//! Sentences on numbers that a report does not have.

use super::inputs::ReportInputs;
use super::section::{ReportSection, Table, WAVELENGTH_COLUMN};

/// Reason for which a column or a figure may lack numbers.
#[derive(Debug)]
pub(super) struct Absence {
    /// Beginning of the names of the columns and figures.
    pub name: &'static str,
    /// Reason, as a sentence without a full stop.
    pub why: &'static str,
    /// Whether the number does not exist even for a perfect lens, such as the radius of a plane.
    pub usual: bool,
}

impl Absence {
    /// Returns the absence of a number that no lens has.
    pub fn usual(name: &'static str, why: &'static str) -> Self {
        Self { name, why, usual: true }
    }

    /// Returns the absence of a number that other lenses have.
    pub fn of_lens(name: &'static str, why: &'static str) -> Self {
        Self { name, why, usual: false }
    }
}

/// A reason, and the names of all numbers that it holds for.
struct Gap {
    names: Vec<String>,
    why: String,
    usual: bool,
}

/// States the reason for every number of a section that is not finite, and names every field
/// without a chief ray.
pub(super) fn state_missing(section: &mut ReportSection, inputs: &ReportInputs) {
    let mut gaps: Vec<Gap> = Vec::new();
    let mut add = |name: &str, field: Option<f64>| {
        let known = section.absences.iter().find(|absence| name.starts_with(absence.name));
        let (why, usual) = match known {
            Some(absence) => (absence.why.to_owned(), absence.usual),
            None => (of_field(inputs, field), false),
        };
        match gaps.iter_mut().find(|gap| gap.why == why) {
            Some(gap) if gap.names.iter().any(|known| known == name) => (),
            Some(gap) => gap.names.push(name.to_owned()),
            None => gaps.push(Gap { names: vec![name.to_owned()], why, usual }),
        }
    };
    for (name, ..) in section.figures.iter().filter(|(_, value, _)| !value.is_finite()) {
        add(name, None);
    }
    let own = inputs.field_column();
    let mut by_field = false;
    let mut dark = inputs.left_out.clone();
    for table in &section.tables {
        let place = table.columns.iter().position(|column| column == own);
        by_field |= place.is_some();
        for row in &table.rows {
            if let Some(place) = place
                && inputs.traced(row[place]).is_none()
                && is_empty(table, own, row)
            {
                dark.push(row[place]);
                continue;
            }
            for (name, _) in table.columns.iter().zip(row).filter(|(_, value)| !value.is_finite()) {
                add(name, place.map(|place| row[place]));
            }
        }
    }
    dark.sort_by(f64::total_cmp);
    dark.dedup();
    if by_field && !dark.is_empty() {
        let names: Vec<String> = dark.iter().map(|&f| inputs.field_name(f)).collect();
        let text = format!(
            "No ray passes the vertex of the stop, so that there are no numbers: fields {}.",
            names.join(", ")
        );
        section.missing.push((text, false));
    }
    section.missing.extend(
        gaps.into_iter().map(|gap| (format!("{}: {}.", gap.names.join(", "), gap.why), gap.usual)),
    );
}

/// Returns whether a row holds nothing but its field and wavelength.
fn is_empty(table: &Table, field_column: &str, row: &[f64]) -> bool {
    let is_key = |column: &str| column == field_column || column == WAVELENGTH_COLUMN;
    table.columns.iter().zip(row).all(|(column, value)| value.is_nan() || is_key(column))
}

/// Returns the reason for which a field lacks a number.
fn of_field(inputs: &ReportInputs, field: Option<f64>) -> String {
    let Some(field) = field else { return "the lens does not determine it".to_owned() };
    let name = inputs.field_name(field);
    let Some(rays) = inputs.traced(field) else {
        return format!("no light of field {name} passes the lens");
    };
    let lit = |wavelength: &usize| {
        rays.grids[*wavelength].as_ref().is_some_and(|grid| grid.open().next().is_some())
    };
    let dark: Vec<usize> = inputs.wavelengths().filter(|wavelength| !lit(wavelength)).collect();
    if dark.len() == rays.grids.len() {
        return format!("no light of field {name} passes the lens");
    }
    if dark.is_empty() {
        return format!("the few rays of field {name} that pass the lens do not determine it");
    }
    let dark: Vec<String> = dark.into_iter().map(|i| inputs.wavelength_name(i)).collect();
    format!("no light of field {name} passes the lens at {}", dark.join(", "))
}
