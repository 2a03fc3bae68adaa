//! Reader of the text of DiffOptics: type, distance from the surface before, radius, diameter and the
//! material behind; then the conic constant and the coefficients of the powers 4, 6, 8, ...
//!
//! Types: O object, S surface, A aperture stop, I image.

use std::path::Path;

use super::checks::{even_powers, medium, radius};
use super::report::ReadReport;
use super::text::Line;
use petzval_base::io::{ReadContext, excerpt};
use petzval_lens::LensError;
use petzval_lens::system::{MediumBehind, SequentialSystem, SystemSurface};
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
    let mut left_out = ReadReport::new(context);
    let mut system = SequentialSystem::default();
    let mut in_table = false;
    for line in Line::all(path, text) {
        let words: Vec<&str> = line.words().collect();
        let Some(&kind) = words.first() else { continue };
        if !in_table {
            in_table = kind.eq_ignore_ascii_case("type");
            if !in_table && system.source.is_none() {
                system.source = Some(line.text.trim().to_owned());
            }
            continue;
        }
        if words.len() < 5 {
            let expected = "expected type distance roc diameter material";
            return Err(line.error(kind, format!("{} columns", words.len()), expected));
        }
        let distance = line.number_of(words[1])?;
        if kind != "O"
            && let Some(before) = system.surfaces.last_mut()
        {
            before.row.thickness = distance;
        }
        match kind {
            "O" => {}
            "I" => break,
            _ => {
                let surface = surface(&line, &words, &mut left_out)?;
                system.surfaces.push(surface);
            }
        }
    }
    system.design.notes.extend(left_out.take_notes());
    system.build(path)
}

fn surface(
    line: &Line<'_>,
    words: &[&str],
    left_out: &mut ReadReport<'_>,
) -> Result<SystemSurface, LensError> {
    let mut row = Row { stop: words[0] == "A", ..Row::default() };
    if !["S", "A"].contains(&words[0]) {
        let what = format!("a surface of the type \"{}\"", excerpt(words[0]));
        left_out.leave_out(line, words[0], &what)?;
    }
    row.radius = radius(line.number_of(words[2])?)
        .map_err(|found| line.error(words[2], found, "expected 1e-6 mm or more, or 0"))?;
    let diameter = line.number_of(words[3])?;
    if let Some(word) = words.get(5) {
        row.conic = line.number_of(word)?;
    }
    let terms: Result<Vec<f64>, LensError> =
        words.iter().skip(6).map(|word| line.number_of(word)).collect();
    row.asphere = even_powers(4, &terms?)
        .map_err(|found| line.error(words[0], found, "expected powers up to 30"))?;
    let medium = match row.stop {
        true => MediumBehind::Same,
        false => medium(None, None, words[4], left_out)
            .map_err(|found| line.error(words[4], found, "expected a glass, or index/Abbe"))?,
    };
    let semi_diameter = Some(diameter / 2.0).filter(|semi| *semi > 0.0);
    let line = line.number;
    Ok(SystemSurface { line, row, medium, semi_diameter, clips: true, ..SystemSurface::default() })
}
