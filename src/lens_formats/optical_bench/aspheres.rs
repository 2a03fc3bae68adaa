//! Aspheres of the Optical Bench.
//!
//! A line has the number of its surface, the radius, the conic constant k and the coefficients. They
//! are those of the powers 4, 6, 8, ...; with the constant `AsphericalA2` of 2, 4, 6, ...; with
//! `AsphericalOddCount` n of 3, 4, 5, 6, ..., of which the first n odd powers are listed. A line
//! without a number may name the columns instead: "A4", "A6", "k". Patents that state kappa = 1 + k
//! are entered with k.

use super::sections::{Sections, number};
use crate::checks::powers;
use petzval_base::io::excerpt;
use petzval_lens::LensError;
use petzval_lens::system::SequentialSystem;

/// Difference of two radii of the same surface, as a share.
const SAME_RADIUS: f64 = 1e-3;

/// Reads the aspheres into the surfaces of these numbers.
///
/// # Errors
/// Returns an error with line and column if a line is invalid or its surface is unknown.
pub(super) fn read(
    sections: &Sections<'_>,
    numbers: &[&str],
    system: &mut SequentialSystem,
) -> Result<(), LensError> {
    for (line, cells) in sections.rows("constants") {
        let known = ["AsphericalOddCount", "AsphericalA2"].contains(&cells[0]);
        if cells[0].starts_with("Aspherical") && !known {
            let found = format!("an unknown form of aspheres, {}", excerpt(cells[0]));
            return Err(line.error(cells[0], found, "expected AsphericalOddCount or AsphericalA2"));
        }
    }
    let odd = match sections.row("constants", "AsphericalOddCount") {
        None => None,
        Some((line, cells)) => match cells.get(1).and_then(|cell| cell.parse::<u32>().ok()) {
            Some(count) if count <= 9 => Some(count),
            _ => {
                let expected = "expected the number of odd powers, 0 to 9";
                return Err(line.error(cells[0], "no count of odd powers", expected));
            }
        },
    };
    let square = sections.row("constants", "AsphericalA2").is_some();
    let mut columns: Option<Vec<&str>> = None;
    for (line, cells) in sections.rows("aspherical data") {
        if cells.len() < 2 {
            continue;
        }
        let Some(surface) = numbers.iter().position(|number| *number == cells[0]) else {
            if cells[1..].iter().any(|cell| label(cell).is_some()) {
                columns = Some(cells.to_vec());
                continue;
            }
            let found = format!("an asphere of an unknown surface \"{}\"", excerpt(cells[0]));
            return Err(line.error(cells[0], found, "expected a number of [lens data]"));
        };
        let mut conic = 0.0;
        let mut terms: Vec<(u32, f64)> = Vec::new();
        let mut next = implied_powers(odd, square);
        for (i, &cell) in cells.iter().enumerate().skip(1) {
            let (name, value) = match cell.split_once('=') {
                Some((name, value)) => (Some(name.trim()), value.trim()),
                None => (columns.as_ref().and_then(|names| names.get(i).copied()), cell),
            };
            let labelled = name.and_then(label);
            if value.is_empty() || value == "undefined" {
                // An empty cell holds the place of its power.
                if i > 2 && labelled.is_none() {
                    next.next();
                }
                continue;
            }
            if i == 1 && labelled.is_none() {
                let stated = system.surfaces[surface].row.radius;
                let radius = match value.to_ascii_lowercase().as_str() {
                    "infinity" | "inf" => f64::INFINITY,
                    _ => number(line, value)?,
                };
                if (radius.recip() - stated.recip()).abs() > SAME_RADIUS * stated.recip().abs()
                    && radius != 0.0
                {
                    system.design.notes.push(format!(
                        "line {}: the radius {radius} of the asphere differs from that of its \
                         surface, {stated}, which is used",
                        line.number
                    ));
                }
                continue;
            }
            let value = number(line, value)?;
            match labelled {
                Some(Label::Conic) => conic = value,
                Some(Label::Power(power)) => terms.push((power, value)),
                None if i == 2 => conic = value,
                None => terms.push((next.next().unwrap_or(u32::MAX), value)),
            }
        }
        let row = &mut system.surfaces[surface].row;
        row.conic = conic;
        row.asphere = powers(terms)
            .map_err(|found| line.error(cells[0], found, "expected powers from 2 to 30"))?;
    }
    Ok(())
}

/// Powers of coefficients without labels.
fn implied_powers(odd: Option<u32>, square: bool) -> impl Iterator<Item = u32> {
    let first = if odd.is_some() {
        3
    } else if square {
        2
    } else {
        4
    };
    let most_odd = odd.map_or(0, |count| 1 + 2 * count);
    (first..).filter(move |power| power % 2 == 0 || *power <= most_odd)
}

/// Meaning of a labelled column.
enum Label {
    Conic,
    Power(u32),
}

fn label(name: &str) -> Option<Label> {
    if ["k", "K", "κ", "Conic", "conic"].contains(&name) {
        return Some(Label::Conic);
    }
    name.strip_prefix(['A', 'a', 'C', 'c'])?.parse().ok().map(Label::Power)
}
