//! Reader of the `.dat` lens tables of pbrt: four columns, millimetres, scene side first.
//!
//! The columns are `radius  thickness  index  diameter`. Radius 0 marks the stop, and `#` starts a
//! comment. Index 0 at the stop means air; a stop whose index differs from that of the medium
//! before it is a plane that refracts. Two conventions share the format: the thickness is the
//! distance AFTER the surface (pbrt's own files, with any number in the last row) or the distance
//! BEFORE it (first row 0, last row not 0).
//!
//! A single number before the rows is the focal length (files of ISET) or, if it equals the number
//! of rows, that number (files of crayg).

use std::path::Path;

use super::{MAX_INDEX, MIN_RADIUS};
use crate::io::excerpt;
use crate::lens::prescription::error::LensError;
use crate::lens::prescription::{Prescription, Row};

/// Parses the lines of a lens table. The path names the lens and appears in errors.
///
/// # Errors
/// Returns an error with the line if a line is invalid or the table describes no lens.
pub fn parse(path: &Path, lines: &[impl AsRef<str>]) -> Result<Prescription, LensError> {
    let error = |line: usize, found: String, expected: &str| LensError::Malformed {
        path: path.to_owned(),
        line,
        column: None,
        found,
        expected: expected.to_owned(),
    };

    let mut table: Vec<(usize, [f64; 4])> = Vec::new();
    let mut single: Option<(usize, f64)> = None;
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
                    return Err(error(line, found, expected));
                }
            }
        }
        match numbers[..] {
            [] => {}
            [number] if table.is_empty() && single.is_none() => single = Some((line, number)),
            [radius, thickness, index, diameter] => {
                table.push((line, [radius, thickness, index, diameter]));
            }
            _ => {
                let found = match numbers.len() {
                    1 => "1 column".to_owned(),
                    count => format!("{count} columns"),
                };
                return Err(error(line, found, "expected four: radius thickness index diameter"));
            }
        }
    }
    let (Some(first), Some(last)) = (table.first(), table.last()) else {
        return Err(error(
            lines.len().max(1),
            "no surface in the file".into(),
            "expected rows of radius thickness index diameter, in mm",
        ));
    };

    let stated_focal_length = match single {
        Some((line, 0.0)) => {
            let expected = "expected the focal length in mm, or a row";
            return Err(error(line, "a focal length of 0".into(), expected));
        }
        Some((_, number)) if number != table.len() as f64 => Some(number),
        _ => None,
    };
    let thickness_is_before = first.1[1] == 0.0 && last.1[1] != 0.0;
    let distances: Vec<f64> = table.iter().map(|(_, row)| row[1]).collect();
    let mut rows: Vec<Row> = Vec::with_capacity(table.len());
    let mut stop_line = None;
    for (i, &(line, [radius, _, index, diameter])) in table.iter().enumerate() {
        let thickness = match thickness_is_before {
            true => distances.get(i + 1).copied().unwrap_or(0.0),
            false => distances[i],
        };
        let stop = radius == 0.0;
        if stop && let Some(earlier) = stop_line.replace(line) {
            let found = format!("a second stop (radius 0), after the one in line {earlier}");
            return Err(error(line, found, "a lens has one"));
        }
        if !stop && radius.abs() < MIN_RADIUS {
            let found = format!("radius {radius:e}");
            return Err(error(line, found, "expected 1e-6 mm or more, or 0 at the stop"));
        }
        let medium = if stop && index == 0.0 { 1.0 } else { index };
        let index_before = rows.last().map_or(1.0, |row| row.index);
        if !(1.0..=MAX_INDEX).contains(&medium) {
            let found = format!("index {index:?}");
            return Err(error(line, found, "expected 1 (air) to 10; 0 only at the stop"));
        }
        // Behind the last row there is air. Elsewhere 0 is ambiguous.
        if stop && index == 0.0 && index_before != 1.0 && i + 1 < table.len() {
            let found = format!("the stop changes the index from {index_before} to 0");
            let expected = format!(
                "write {index_before} for a stop inside this medium, or 1 for a plane face to air"
            );
            return Err(error(line, found, &expected));
        }
        if diameter <= 0.0 {
            let found = format!("diameter {diameter}");
            return Err(error(line, found, "expected the full clear diameter, above 0 mm"));
        }
        if !stop && diameter / 2.0 > radius.abs() {
            let found = format!("diameter {diameter} on a sphere of radius {radius}");
            return Err(error(line, found, "a clear diameter is at most twice the radius"));
        }
        let radius = if stop { f64::INFINITY } else { radius };
        rows.push(Row { radius, thickness, index: medium, diameter, stop, ..Row::default() });
    }
    if stop_line.is_none() {
        return Err(error(
            last.0,
            "the table ends without a stop".into(),
            "one row must have radius 0",
        ));
    }
    if rows.len() < 2 {
        let expected = "expected at least one other surface";
        return Err(error(last.0, "a stop without any glass".into(), expected));
    }
    let name = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
    Ok(Prescription { stated_focal_length, ..Prescription::new(name, rows)? })
}
