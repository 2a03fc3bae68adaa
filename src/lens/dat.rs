//! The `.dat` lens tables of pbrt: four columns, millimetres, scene side first.
//!
//! `radius  thickness  index  diameter`: radius 0 is the stop, `#` starts a comment. Index 0 at the
//! stop means air; a stop with another index than the medium before it is a plane that refracts. Two conventions share the format: the thickness column
//! holds the distance AFTER the surface (last row 0, or anything: pbrt's own files), or the
//! distance BEFORE it (first row 0, last row not).
//!
//! A lone number before the rows is the focal length (ISET's files), or, where it equals the number
//! of rows, that number (crayg's).

use std::path::Path;

use super::error::LensError;
use super::file::{LEAST_RADIUS, MOST_INDEX};
use super::prescription::{Prescription, Row};
use crate::source::excerpt;

/// Reads the lines of a lens table; the path serves for its name and in errors.
///
/// # Errors
/// Where a line is not what a lens table may hold.
pub fn parse(path: &Path, lines: &[impl AsRef<str>]) -> Result<Prescription, LensError> {
    let refuse = |line: usize, found: String, expected: &str| LensError::Malformed {
        path: path.to_owned(),
        line,
        column: None,
        found,
        expected: expected.to_owned(),
    };

    let mut table: Vec<(usize, [f64; 4])> = Vec::new();
    let mut lone: Option<(usize, f64)> = None;
    for (i, text) in lines.iter().enumerate() {
        let text = text.as_ref();
        let line = i + 1;
        let data = text.split('#').next().unwrap_or_default();
        let mut numbers = Vec::with_capacity(4);
        for word in data.split_whitespace() {
            match word.parse::<f64>() {
                Ok(number) if number.is_finite() => numbers.push(number),
                _ => {
                    let found = format!("\"{}\" is not a finite number", excerpt(word));
                    let expected = "expected radius thickness index diameter; # starts a comment";
                    return Err(refuse(line, found, expected));
                }
            }
        }
        match numbers[..] {
            [] => {}
            [number] if table.is_empty() && lone.is_none() => lone = Some((line, number)),
            [radius, thickness, index, diameter] => {
                table.push((line, [radius, thickness, index, diameter]));
            }
            _ => {
                let found = match numbers.len() {
                    1 => "1 column".to_owned(),
                    count => format!("{count} columns"),
                };
                return Err(refuse(line, found, "expected four: radius thickness index diameter"));
            }
        }
    }
    let (Some(first), Some(last)) = (table.first(), table.last()) else {
        return Err(refuse(
            lines.len().max(1),
            "no surface in the file".into(),
            "expected rows of radius thickness index diameter, in mm",
        ));
    };

    let stated_focal_length = match lone {
        Some((line, 0.0)) => {
            let expected = "expected the focal length in mm, or a row";
            return Err(refuse(line, "a focal length of 0".into(), expected));
        }
        Some((_, number)) if number != table.len() as f64 => Some(number),
        _ => None,
    };
    let before = first.1[1] == 0.0 && last.1[1] != 0.0;
    let distances: Vec<f64> = table.iter().map(|(_, row)| row[1]).collect();
    let mut rows: Vec<Row> = Vec::with_capacity(table.len());
    let mut stop_line = None;
    for (i, &(line, [radius, _, index, diameter])) in table.iter().enumerate() {
        let thickness = match before {
            true => distances.get(i + 1).copied().unwrap_or(0.0),
            false => distances[i],
        };
        let stop = radius == 0.0;
        if stop && let Some(earlier) = stop_line.replace(line) {
            let found = format!("a second stop (radius 0), after the one in line {earlier}");
            return Err(refuse(line, found, "a lens has one"));
        }
        if !stop && radius.abs() < LEAST_RADIUS {
            let found = format!("radius {radius:e}");
            return Err(refuse(line, found, "expected 1e-6 mm or more, or 0 at the stop"));
        }
        let medium = if stop && index == 0.0 { 1.0 } else { index };
        let ahead = rows.last().map_or(1.0, |row| row.index);
        if !(1.0..=MOST_INDEX).contains(&medium) {
            let found = format!("index {index:?}");
            return Err(refuse(line, found, "expected 1 (air) to 10; 0 only at the stop"));
        }
        // Behind the last row is the air before the film. Elsewhere 0 has two readings.
        if stop && index == 0.0 && ahead != 1.0 && i + 1 < table.len() {
            let found = format!("the stop changes the index from {ahead} to 0");
            let expected = format!(
                "write {ahead} for a stop inside this medium, or 1 for a plane face to air"
            );
            return Err(refuse(line, found, &expected));
        }
        if diameter <= 0.0 {
            let found = format!("diameter {diameter}");
            return Err(refuse(line, found, "expected the full clear diameter, above 0 mm"));
        }
        if !stop && diameter / 2.0 > radius.abs() {
            let found = format!("diameter {diameter} on a sphere of radius {radius}");
            return Err(refuse(line, found, "a clear diameter is at most twice the radius"));
        }
        let radius = if stop { f64::INFINITY } else { radius };
        rows.push(Row { radius, thickness, index: medium, diameter, stop, ..Row::default() });
    }
    if stop_line.is_none() {
        return Err(refuse(
            last.0,
            "the table ends without a stop".into(),
            "one row must have radius 0",
        ));
    }
    if rows.len() < 2 {
        return Err(refuse(last.0, "a stop without any glass".into(), "a lens has surfaces"));
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Prescription { name, stated_focal_length, rows, ..Prescription::default() })
}
