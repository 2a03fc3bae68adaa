//! Reader of the `.dat` lens tables of pbrt: four columns, millimetres, scene side first.
//!
//! The columns are `radius  thickness  index  diameter`; a word may follow that tells a cylinder:
//! CYLINDER_X or CYLINDER_Y, by its axis. `#`, `%` and `//` start a comment. Radius 0 marks the stop;
//! of several such rows it is the one that does not refract, and the others are planes, as are those of
//! infinite radius. Index 0 at a plane or the stop means air, and a stop whose medium differs from that before it is a plane that refracts;
//! it is the medium of before if the next vertex is at the stop, or if the focal length is then nearer
//! to the one that the file states.
//! Two conventions share the format: the thickness is the distance AFTER the surface (pbrt's own
//! files, with any number in the last row) or the distance BEFORE it (first row 0, last row not 0).
//!
//! A single number before the rows is the focal length (files of ISET) or, if it equals the number
//! of rows, that number (files of crayg).

use std::path::Path;

use super::MIN_RADIUS;
use petzval_base::io::excerpt;
use petzval_lens::LensError;
use petzval_lens::Paraxial;
use petzval_lens::{MAX_INDEX, MIN_INDEX};
use petzval_lens::{Prescription, Row, TransverseAxis};

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

    let mut table: Vec<(usize, [f64; 4], Option<TransverseAxis>)> = Vec::new();
    let mut single: Option<(usize, f64)> = None;
    for (i, text) in lines.iter().enumerate() {
        let text = text.as_ref();
        let line = i + 1;
        let data = text.split(['#', '%']).next().unwrap_or_default();
        let data = data.split("//").next().unwrap_or_default();
        let mut numbers = Vec::with_capacity(4);
        let mut axis = None;
        for word in data.split_whitespace() {
            match word.parse::<f64>() {
                Ok(number) if number.is_finite() => numbers.push(number),
                // A plane, and not the stop that radius 0 marks.
                Ok(radius) if radius.is_infinite() && numbers.is_empty() => numbers.push(radius),
                _ if numbers.len() == 4 && axis_of(word).is_some() => {
                    axis = axis_of(word).flatten();
                }
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
                table.push((line, [radius, thickness, index, diameter], axis));
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
    let distances: Vec<f64> = table.iter().map(|(_, row, _)| row[1]).collect();
    let mut rows: Vec<Row> = Vec::with_capacity(table.len());
    let is_stop = stops(&table);
    let mut stop_line = None;
    // The row of a stop of index 0 behind a medium that may go on behind it.
    let mut ambiguous = None;
    for (i, &(line, [radius, _, index, diameter], axis)) in table.iter().enumerate() {
        let thickness = match thickness_is_before {
            true => distances.get(i + 1).copied().unwrap_or(0.0),
            false => distances[i],
        };
        let plane = radius == 0.0;
        let stop = is_stop[i];
        if stop && let Some(earlier) = stop_line.replace(line) {
            let found = format!("a second stop (radius 0), after the one in line {earlier}");
            return Err(error(line, found, "a lens has one"));
        }
        if !plane && radius.abs() < MIN_RADIUS {
            let found = format!("radius {radius:e}");
            return Err(error(line, found, "expected 1e-6 mm or more, or 0 at the stop"));
        }
        let index_before = rows.last().map_or(1.0, |row| row.index);
        let medium = match stop && index == 0.0 {
            // No room for air.
            true if thickness == 0.0 && i + 1 < table.len() => index_before,
            true => 1.0,
            // The rear face of a filter: air.
            false if plane && index == 0.0 => 1.0,
            false => index,
        };
        if !(MIN_INDEX..=MAX_INDEX).contains(&medium) {
            let found = format!("index {index:?}");
            return Err(error(line, found, "expected 1 (air) to 10; 0 only at a plane"));
        }
        if medium == 1.0 && index == 0.0 && index_before != 1.0 {
            ambiguous = Some((i, index_before));
        }
        if diameter <= 0.0 {
            let found = format!("diameter {diameter}");
            return Err(error(line, found, "expected the full clear diameter, above 0 mm"));
        }
        if diameter / 2.0 > radius.abs() && !plane {
            let found = format!("diameter {diameter} on a sphere of radius {radius}");
            return Err(error(line, found, "a clear diameter is at most twice the radius"));
        }
        let radius = if plane { f64::INFINITY } else { radius };
        let axis = axis.filter(|_| !plane);
        rows.push(Row { radius, thickness, index: medium, diameter, stop, axis, ..Row::default() });
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
    let mut lens = Prescription { stated_focal_length, ..Prescription::new(name, rows)? };
    if let (Some((stop, index)), Some(stated)) = (ambiguous, stated_focal_length) {
        let mut inside = lens.clone();
        inside.rows[stop].index = index;
        let distance = |lens: &Prescription| (Paraxial::new(lens).focal_length - stated).abs();
        if distance(&inside) < distance(&lens) {
            inside.design.notes.push(format!(
                "the stop in line {} has the index 0; {index}, the medium before it, is used, with \
                 which the focal length is nearer to the stated one",
                table[stop].0
            ));
            lens = inside;
        }
    }
    Ok(lens)
}

/// Returns for every row whether it is marked as the stop: of the rows of radius 0 those that do not
/// refract, or all of them.
fn stops(table: &[(usize, [f64; 4], Option<TransverseAxis>)]) -> Vec<bool> {
    let medium = |i: usize| if table[i].1[2] == 0.0 { 1.0 } else { table[i].1[2] };
    let before = |i: usize| i.checked_sub(1).map_or(1.0, medium);
    let planes: Vec<bool> = table.iter().map(|(_, row, _)| row[0] == 0.0).collect();
    let idle: Vec<bool> = (0..table.len()).map(|i| planes[i] && medium(i) == before(i)).collect();
    let count = |marks: &[bool]| marks.iter().filter(|mark| **mark).count();
    if count(&planes) > 1 && count(&idle) == 1 { idle } else { planes }
}

/// Returns the axis that a word behind the numbers gives the surface, if it is such a word.
fn axis_of(word: &str) -> Option<Option<TransverseAxis>> {
    match word.to_ascii_uppercase().as_str() {
        "SPHERICAL" | "PLANAR" => Some(None),
        "CYLINDER_X" => Some(Some(TransverseAxis::X)),
        "CYLINDER_Y" => Some(Some(TransverseAxis::Y)),
        _ => None,
    }
}
