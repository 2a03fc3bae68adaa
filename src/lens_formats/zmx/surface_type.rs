//! Types of surfaces in Zemax files.

use super::super::MAX_POWER;
use super::super::axis::tangents_to_angles;
use super::super::report::ReadReport;
use super::surface::ZemaxSurface;
use petzval_base::io::excerpt;
use petzval_lens::LensError;
use petzval_lens::RayTransferMatrix;
use petzval_lens::{CrossSection, Row};

/// Sets the shape of a surface beside its curvature and conic constant.
///
/// # Errors
/// Returns an error that names the surface if the type or a term is not simulated.
pub(super) fn shape(
    draft: &ZemaxSurface,
    number: usize,
    unit: f64,
    row: &mut Row,
    report: &mut ReadReport,
) -> Result<(), LensError> {
    let (_, kind) = draft.kind;
    let parameter = |i: usize| draft.parameters.get(&i).copied().unwrap_or(0.0);
    let even =
        |first: usize| (0..8).map(|i| (2 + 2 * i as u32, parameter(first + i))).collect::<Vec<_>>();
    let effective = |from: usize| draft.extra.range(from..).any(|(_, value)| *value != 0.0);
    let any = |from: usize| draft.parameters.range(from..).any(|(_, value)| *value != 0.0);
    let (terms, missing) = match kind {
        "STANDARD" | "CONIC" => (Vec::new(), false),
        "EVENASPH" => (even(1), false),
        "ODDASPHE" => ((1..=8).map(|p| (p as u32, parameter(p))).collect(), false),
        "XASPHERE" => (extended(draft, 2), false),
        "XOSPHERE" => (extended(draft, 1), false),
        "PARAXIAL" => {
            row.ideal = Some([thin_lens(parameter(1) * unit); 2]);
            (Vec::new(), false)
        }
        "PARAX_XY" => {
            let power = |i: usize| parameter(i) / unit;
            row.ideal = Some([power(1), power(2)].map(|power| thin_lens(power.recip())));
            (Vec::new(), false)
        }
        "BICONICX" => {
            // A radius of 0 stands for none.
            let radius = if parameter(1) == 0.0 { f64::INFINITY } else { parameter(1) * unit };
            row.across = Some(CrossSection::Biconic { radius, conic: parameter(2) });
            (Vec::new(), any(3))
        }
        "TOROIDAL" => {
            let radius = if parameter(1) == 0.0 { f64::INFINITY } else { parameter(1) * unit };
            row.across = Some(CrossSection::Toroid { radius });
            (even(2), effective(3))
        }
        "DGRATING" => (Vec::new(), parameter(1) * parameter(2) != 0.0),
        "TILTSURF" => {
            // A plane: its curvature is not used.
            row.radius = f64::INFINITY;
            row.pose.tilt = tangents_to_angles([1, 2].map(parameter));
            (Vec::new(), false)
        }
        "IRREGULA" => (Vec::new(), any(1)),
        "BINARY_1" | "BINARY_2" | "FZERNSAG" | "FZERNPHA" => (even(1), effective(3)),
        "XPOLYNOM" | "QED_TYPE" => (Vec::new(), effective(3)),
        _ => (Vec::new(), true),
    };
    if missing {
        let (line, kind) = draft.kind;
        let what = format!("surface {number} of the type {}", excerpt(kind));
        report.unsimulated(&line, kind, what, "with its conic and even terms alone")?;
    }
    for (power, coefficient) in terms.into_iter().filter(|(_, coefficient)| *coefficient != 0.0) {
        if !(2..=MAX_POWER).contains(&power) {
            let (line, kind) = draft.kind;
            let what = format!("the term r^{power} of surface {number}");
            report.unsimulated(&line, kind, what, "without it")?;
            continue;
        }
        row.asphere.push((power, coefficient * unit.powi(1 - power as i32)));
    }
    Ok(())
}

/// Returns the terms of an extended asphere: number of terms, normalisation radius, and coefficients
/// of (r / radius)^step and its powers.
fn extended(draft: &ZemaxSurface, step: u32) -> Vec<(u32, f64)> {
    let extra = |i: usize| draft.extra.get(&i).copied();
    let radius = extra(2).filter(|&radius| radius > 0.0).unwrap_or(1.0);
    let count = extra(1).map_or(usize::MAX, |count| count.max(0.0) as usize);
    let terms = draft.extra.range(3..).take_while(|(i, _)| **i - 3 < count);
    terms
        .map(|(i, coefficient)| {
            let power = step * (*i as u32 - 2).min(1000);
            (power, coefficient / radius.powi(power as i32))
        })
        .collect()
}

/// Returns the matrix of a thin lens of a focal length (mm); that of 0 or infinity has no power.
fn thin_lens(focal_length: f64) -> RayTransferMatrix {
    let power = if focal_length == 0.0 { 0.0 } else { focal_length.recip() };
    RayTransferMatrix { a: 1.0, b: 0.0, c: -power, d: 1.0 }
}
