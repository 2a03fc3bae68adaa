//! Reader of the `.fx` files of polynomial-optics and crayg: `[Metadata]`, `[Surfaces]` with a line
//! of column names, `[Aspheric Coefficients]` by the number of the surface from 0.
//!
//! polynomial-optics itself has files without sections, which [`table`] reads.
//!
//! The stop has radius 0 and air on both sides. "Housing-Radius" holds semi-diameters, and diameters
//! in some files.

mod table;

use std::path::Path;

use super::checks::{even_powers, medium, radius};
use super::report::ReadReport;
use super::text::Line;
use petzval_base::io::{ReadContext, excerpt};
use petzval_lens::LensError;
use petzval_lens::Paraxial;
use petzval_lens::system::{SequentialSystem, SystemSurface, choose_stop};
use petzval_lens::{Prescription, Row, TransverseAxis};

/// Smallest f-number of a lens in air (sine condition).
const FASTEST: f64 = 0.5;

/// Share of the curvature below which a square term is none: it is then the coefficient of h^4 under
/// a name that is one power too low.
const NO_SQUARE: f64 = 1e-2;

/// Parses a text.
///
/// # Errors
/// Returns an error with line and column if a line is invalid or the text describes no lens.
pub(super) fn parse(
    path: &Path,
    text: &str,
    context: &ReadContext,
) -> Result<Prescription, LensError> {
    if !text.lines().any(|line| line.trim_start().starts_with('[')) {
        return table::parse(path, text, context);
    }
    let mut left_out = ReadReport::new(context);
    let mut system =
        SequentialSystem { column_of_semi_diameters: true, ..SequentialSystem::default() };
    let mut section = String::new();
    let mut columns: Option<Vec<String>> = None;
    let mut coefficients: Vec<(Line<'_>, usize, Vec<f64>)> = Vec::new();
    for line in Line::all(path, text) {
        let content = line.text.split('#').next().unwrap_or_default().trim();
        if content.is_empty() {
            continue;
        }
        if let Some(name) = content.strip_prefix('[') {
            section = name.trim_end_matches(']').trim().to_lowercase();
            continue;
        }
        match section.as_str() {
            "surfaces" => match &columns {
                None => columns = Some(content.split_whitespace().map(str::to_lowercase).collect()),
                Some(names) => {
                    let words: Vec<&str> = content.split_whitespace().collect();
                    let surface = surface(&line, names, &words, &mut left_out)?;
                    system.surfaces.push(surface);
                }
            },
            "metadata" => metadata(&line, content, &mut system)?,
            name if name.starts_with("aspher") => {
                let (number, terms) = asphere(&line, content, &mut system)?;
                coefficients.push((line, number, terms));
            }
            _ => {
                let found = format!("a line of an unknown section \"[{}]\"", excerpt(&section));
                let expected = "expected [Metadata], [Surfaces] or [Aspheric Coefficients]";
                return Err(line.error(content, found, expected));
            }
        }
    }
    place_coefficients(&coefficients, &mut system)?;
    choose_stop(&mut system.surfaces);
    system.design.notes.extend(left_out.take_notes());
    let mut lens = system.build(path)?;
    limit_stop(&mut lens);
    Ok(lens)
}

fn metadata(
    line: &Line<'_>,
    content: &str,
    system: &mut SequentialSystem,
) -> Result<(), LensError> {
    let Some((key, value)) = content.split_once(':') else { return Ok(()) };
    let value = value.trim();
    match key.trim().to_lowercase().as_str() {
        "name" => system.name = value.trim_end_matches(',').to_owned(),
        "patent" => system.source = Some(value.to_owned()),
        "focal length" => system.focal_length = Some(line.number_of(value)?),
        "maximum f number" => system.f_number = Some(line.number_of(value)?),
        _ => {}
    }
    Ok(())
}

fn surface(
    line: &Line<'_>,
    names: &[String],
    words: &[&str],
    left_out: &mut ReadReport<'_>,
) -> Result<SystemSurface, LensError> {
    let place = |name: &str| names.iter().position(|column| column == name);
    // Files leave the Abbe number of air out.
    let skipped = place("abbe-no").filter(|&abbe| {
        words.len() + 1 == names.len() && words.get(abbe).is_some_and(|w| w.parse::<f64>().is_err())
    });
    let cell = |name: &str| {
        let at = place(name)?;
        match skipped {
            Some(abbe) if at == abbe => None,
            Some(abbe) if at > abbe => words.get(at - 1).copied(),
            _ => words.get(at).copied(),
        }
    };
    let need = |name: &str| {
        let found = format!("{} columns, and no {name}", words.len());
        cell(name).ok_or_else(|| {
            line.error(words[0], found, &format!("expected the columns {}", names.join(" ")))
        })
    };
    let number = |name: &str| cell(name).map(|word| line.number_of(word)).transpose();
    let stated = line.length_of(need("radius")?)?;
    let mut row = Row {
        radius: radius(stated)
            .map_err(|found| line.error(words[0], found, "expected 1e-6 mm or more, or 0"))?,
        ..Row::default()
    };
    let thickness = need("thickness")?;
    row.thickness = match thickness.chars().next() {
        Some(first) if first.is_alphabetic() => {
            let found = format!("a thickness \"{}\" without a value", excerpt(thickness));
            let expected = "replace it by the distance in mm at one state of zoom and focus";
            return Err(line.error(thickness, found, expected));
        }
        _ => line.number_of(thickness)?,
    };
    let geometry = cell("geometry").unwrap_or("SPHERICAL");
    match geometry.to_uppercase().as_str() {
        "SPHERICAL" | "ASPHERICAL" | "PLANAR" => {}
        "CYLINDER_X" | "CYL-X" => row.axis = Some(TransverseAxis::X),
        "CYLINDER_Y" | "CYL-Y" => row.axis = Some(TransverseAxis::Y),
        name => {
            left_out.leave_out(line, geometry, &format!("the geometry \"{}\"", excerpt(name)))?
        }
    }
    if row.radius.is_infinite() {
        row.axis = None;
    }
    let name = cell("material").unwrap_or_default();
    let medium = medium(number("ior")?, number("abbe-no")?, name, left_out)
        .map_err(|found| line.error(words[0], found, "expected an IOR from 1 to 10, or 0"))?;
    let semi_diameter = number("housing-radius")?.filter(|semi| *semi > 0.0);
    let line = line.number;
    Ok(SystemSurface { line, row, medium, semi_diameter, clips: true, ..SystemSurface::default() })
}

/// Reads "10: k=0 a2=8.669E-07 a4=...": the conic constant goes to its surface.
fn asphere(
    line: &Line<'_>,
    content: &str,
    system: &mut SequentialSystem,
) -> Result<(usize, Vec<f64>), LensError> {
    let mut words = content.split_whitespace();
    let first = words.next().unwrap_or_default();
    let number = first.trim_end_matches(':').parse::<usize>().ok();
    let Some(number) = number.filter(|&number| number < system.surfaces.len()) else {
        let found = format!("coefficients of a surface \"{}\"", excerpt(first));
        let last = system.surfaces.len().saturating_sub(1);
        return Err(line.error(first, found, &format!("expected its number, 0 to {last}")));
    };
    let mut terms = vec![0.0; 15];
    for word in words {
        let (name, value) = word.split_once('=').unwrap_or(("", word));
        let power = name.strip_prefix('a').and_then(|power| power.parse::<usize>().ok());
        match power {
            _ if name == "k" => system.surfaces[number].row.conic = line.number_of(value)?,
            Some(power) if power % 2 == 0 && (2..=30).contains(&power) => {
                terms[power / 2 - 1] = line.number_of(value)?;
            }
            _ => {
                let found = format!("\"{}\"", excerpt(word));
                return Err(line.error(word, found, "expected k=, or a2= to a30= for even powers"));
            }
        }
    }
    Ok((number, terms))
}

/// Gives the coefficients to their surfaces. Some files call the coefficient of h^4 "a2": their
/// square terms would not bend the surface.
fn place_coefficients(
    coefficients: &[(Line<'_>, usize, Vec<f64>)],
    system: &mut SequentialSystem,
) -> Result<(), LensError> {
    let share = |number: usize, terms: &[f64]| {
        let curvature = system.surfaces[number].row.curvature().abs();
        2.0 * terms[0].abs() / curvature.max(1e-6)
    };
    let squares = || coefficients.iter().filter(|(_, _, terms)| terms[0] != 0.0);
    let shifted = squares().next().is_some()
        && squares().all(|(_, number, terms)| share(*number, terms) < NO_SQUARE);
    for (line, number, terms) in coefficients {
        let first = if shifted { 4 } else { 2 };
        system.surfaces[*number].row.asphere = even_powers(first, terms)
            .map_err(|found| line.error(line.text, found, "expected powers up to 30"))?;
    }
    if shifted {
        system.design.notes.push(
            "the aspheric coefficients a2, a4, ... are taken as those of the powers 4, 6, ...: as \
             square terms those named a2 would not bend their surfaces"
                .to_owned(),
        );
    }
    Ok(())
}

/// Closes the stop to the stated f-number if its housing is wider.
fn limit_stop(lens: &mut Prescription) {
    let Some(stated) = lens.stated_f_number else { return };
    if stated < FASTEST {
        lens.design.notes.push(format!(
            "the stated f-number {stated} is none of a lens in air (0.5 at least) and is not used"
        ));
        lens.stated_f_number = None;
        return;
    }
    let open = lens.rows[lens.stop()].diameter;
    let f_number = Paraxial::new(lens).f_number().abs();
    if f_number.is_finite() && f_number > 0.0 && f_number < stated {
        lens.stop_down(open * f_number / stated);
    }
}
