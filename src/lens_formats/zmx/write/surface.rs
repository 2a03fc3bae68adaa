//! Surfaces of a Zemax file: type, shape, medium, aperture.

use std::fmt::Write as _;
use std::path::Path;

use super::glass::GlassWriter;
use super::{Body, inverse};
use petzval_lens::Iris;
use petzval_lens::LensError;
use petzval_lens::{ApertureForm, SurfaceAperture};
use petzval_lens::{CrossSection, Prescription, Row, TransverseAxis};

/// A surface type with its curvature (1/mm), conic constant, parameters and extra data.
struct Shape {
    kind: &'static str,
    curvature: f64,
    conic: f64,
    parameters: Vec<f64>,
    extra: Vec<f64>,
}

/// Writes row `i` with the space behind it (mm), and returns its number in the file.
///
/// # Errors
/// Returns an error if no surface type has the shape of the row.
pub(super) fn write(
    path: &Path,
    lens: &Prescription,
    i: usize,
    thickness: f64,
    glasses: &mut GlassWriter,
    body: &mut Body,
) -> Result<usize, LensError> {
    let row = &lens.rows[i];
    let shape = Shape::of(row).ok_or_else(|| LensError::Unwritable {
        path: path.to_owned(),
        found: format!("a .zmx file has no surface of the shape of surface {}", i + 1),
        expected: "write a .toml file".to_owned(),
    })?;
    let number = body.start(shape.kind);
    let text = &mut body.text;
    let _ = writeln!(text, "  CURV {:?} 0 0 0 0 \"\"", shape.curvature);
    if shape.conic != 0.0 {
        let _ = writeln!(text, "  CONI {:?}", shape.conic);
    }
    for (number, value) in (1..).zip(&shape.parameters) {
        let _ = writeln!(text, "  PARM {number} {value:?}");
    }
    for (number, value) in (1..).zip(&shape.extra) {
        let _ = writeln!(text, "  XDAT {number} {value:?} 0 0 1.0 0 0");
    }
    let _ = writeln!(text, "  DISZ {thickness:?}");
    text.push_str(&glasses.line(i + 1, row));
    let (inner, outer) = (row.obstruction / 2.0, row.diameter / 2.0);
    if outer > 0.0 {
        let _ = writeln!(text, "  DIAM {outer:?} 1 0 0 1 \"\"");
        match written_aperture(row) {
            Some(aperture) => write_aperture(aperture, text),
            None => {
                let _ = writeln!(text, "  CLAP {inner:?} {outer:?} 0");
            }
        }
    }
    if row.stop {
        text.push_str("  STOP\n");
    }
    Ok(number)
}

/// Returns the aperture that stands in the file in place of the clear diameter and an obstruction: a
/// surface of the format has one aperture.
fn written_aperture(row: &Row) -> Option<&SurfaceAperture> {
    row.apertures.iter().find(|aperture| !aperture.obscures).or(row.apertures.first())
}

/// Returns whether the one aperture of the file is not all that clips a row.
fn loses_apertures(row: &Row) -> bool {
    let outside = |aperture: &SurfaceAperture| {
        !aperture.obscures && row.diameter / 2.0 < aperture.reach() * (1.0 - 1e-9)
    };
    row.apertures.len() > 1
        || row.apertures.iter().any(|aperture| aperture.rotation != 0.0)
        || !row.apertures.is_empty() && row.obstruction > 0.0
        || row.apertures.iter().any(outside)
}

fn write_aperture(aperture: &SurfaceAperture, text: &mut String) {
    let keyword = match (aperture.form, aperture.obscures) {
        (ApertureForm::Rectangle, false) => "SQAP",
        (ApertureForm::Rectangle, true) => "SQOB",
        (ApertureForm::Ellipse, false) => "ELAP",
        (ApertureForm::Ellipse, true) => "ELOB",
    };
    let ([x, y], [w, h]) = (aperture.centre, aperture.half_widths);
    let _ = writeln!(text, "  {keyword} {w:?} {h:?} 0");
    if [x, y] != [0.0; 2] {
        let _ = writeln!(text, "  OBDC {x:?} {y:?}");
    }
}

impl Shape {
    fn of(row: &Row) -> Option<Self> {
        let with = |kind, parameters| Self {
            kind,
            curvature: row.curvature(),
            conic: row.conic,
            parameters,
            extra: Vec::new(),
        };
        if let Some([x, y]) = row.ideal {
            let thin = |m: petzval_lens::RayTransferMatrix| (m.a, m.b, m.d) == (1.0, 0.0, 1.0);
            if !thin(x) || !thin(y) {
                return None;
            }
            let power = |c: f64| inverse(c, -c, |power: f64| -power.recip().recip());
            let length = |c: f64| inverse(c, -c.recip(), |length: f64| -length.recip());
            let plane =
                |kind, parameters| Self { curvature: 0.0, conic: 0.0, ..with(kind, parameters) };
            return Some(match x.c == y.c {
                true if x.c == 0.0 => plane("PARAXIAL", vec![0.0, 1.0]),
                true => plane("PARAXIAL", vec![length(x.c), 1.0]),
                false => plane("PARAX_XY", vec![power(x.c), power(y.c)]),
            });
        }
        // A radius of 0 stands for none.
        let radius = |radius: f64| if radius.is_finite() { radius } else { 0.0 };
        match (row.axis, row.across) {
            (_, Some(CrossSection::Biconic { radius: across, conic })) => {
                let parameters = vec![radius(across), conic];
                row.asphere.is_empty().then(|| with("BICONICX", parameters))
            }
            (_, Some(CrossSection::Toroid { radius: across })) => toroid(row, radius(across)),
            (Some(TransverseAxis::X), None) => toroid(row, 0.0),
            (Some(TransverseAxis::Y), None) => {
                let parameters = vec![radius(row.radius), row.conic];
                let flat = Self { curvature: 0.0, conic: 0.0, ..with("BICONICX", parameters) };
                row.asphere.is_empty().then_some(flat)
            }
            (None, None) => {
                let highest = row.asphere.iter().map(|(power, _)| *power).max().unwrap_or(0);
                let even = row.asphere.iter().all(|(power, _)| power % 2 == 0);
                Some(match (even, highest) {
                    (_, 0) => with("STANDARD", Vec::new()),
                    (true, ..=16) => with("EVENASPH", terms(row, 2, highest)),
                    (false, ..=8) => with("ODDASPHE", terms(row, 1, highest)),
                    (true, _) => extended(with("XASPHERE", Vec::new()), terms(row, 2, highest)),
                    (false, _) => extended(with("XOSPHERE", Vec::new()), terms(row, 1, highest)),
                })
            }
        }
    }
}

/// Returns a toroid of a radius along x, 0 for a cylinder; none if it has other terms than y^2 to
/// y^14.
fn toroid(row: &Row, radius: f64) -> Option<Shape> {
    let fits = row.asphere.iter().all(|(power, _)| power % 2 == 0 && *power <= 14);
    let highest = row.asphere.iter().map(|(power, _)| *power).max().unwrap_or(0);
    let parameters = std::iter::once(radius).chain(terms(row, 2, highest)).collect();
    fits.then(|| Shape {
        kind: "TOROIDAL",
        curvature: row.curvature(),
        conic: row.conic,
        parameters,
        extra: Vec::new(),
    })
}

/// Returns the coefficients of the powers `step`, 2 `step` and so on.
fn terms(row: &Row, step: u32, highest: u32) -> Vec<f64> {
    let coefficient = |power: u32| {
        let found = row.asphere.iter().find(|(other, _)| *other == power);
        found.map_or(0.0, |(_, coefficient)| *coefficient)
    };
    (1..=highest / step).map(|k| coefficient(k * step)).collect()
}

/// Adds number of terms, normalisation radius and coefficients.
fn extended(shape: Shape, terms: Vec<f64>) -> Shape {
    let extra = [terms.len() as f64, 1.0].into_iter().chain(terms).collect();
    Shape { extra, ..shape }
}

/// Notes what the surfaces have that the file has not.
pub(super) fn note_losses(lens: &Prescription, notes: &mut Vec<String>) {
    let mut note = |what: &str, lost: fn(&Row) -> bool| {
        let numbers: Vec<String> = (1..)
            .zip(&lens.rows)
            .filter(|(_, row)| lost(row))
            .map(|(number, _): (usize, _)| number.to_string())
            .collect();
        if !numbers.is_empty() {
            let plural = if numbers.len() == 1 { "" } else { "s" };
            notes.push(format!(
                "a .zmx file does not hold {what} (surface{plural} {})",
                numbers.join(", ")
            ));
        }
    };
    note("the shape of an iris; the opening is round", |row| row.iris != Iris::Round);
    note("more than one aperture of a surface", loses_apertures);
    note("our coatings", |row| row.coating.is_some());
}
