//! Prescription and first-order data of a lens, as JSON.

use petzval_lens::{Paraxial, Prescription, RealRayFocus, TransverseAxis};
use petzval_report::number::tidy;
use serde_json::{Value, json};

/// Returns a number, or null if it is not finite.
fn number(value: f64) -> Value {
    if value.is_finite() { json!(tidy(value)) } else { Value::Null }
}

/// Describes a lens, with 15 digits: lengths in mm, wavelengths in nm, null for what is infinite or unknown.
pub(super) fn describe(lens: &Prescription) -> String {
    let paraxial = Paraxial::new(lens);
    let focus = RealRayFocus::new(lens);
    let surfaces: Vec<Value> = lens
        .rows
        .iter()
        .map(|row| {
            json!({
                "radius": number(row.radius),
                "conic": number(row.conic),
                "asphere": row.asphere,
                "radius_x": row.across.map(|across| number(across.curvature().recip())),
                "axis": row.axis.map(|axis| if axis == TransverseAxis::X { "x" } else { "y" }),
                "thickness": number(row.thickness),
                "index": number(row.index),
                "glass": row.glass.name(),
                "abbe_number": row.glass.abbe_number().map(number),
                "diameter": number(row.diameter),
                "stop": row.stop,
                "mirror": row.mirror,
            })
        })
        .collect();
    let pupil = |pupil: petzval_lens::Pupil| json!({ "position": number(pupil.position), "diameter": number(pupil.diameter) });
    let value = json!({
        "name": lens.name,
        "source": lens.source,
        "wavelength": number(lens.design.primary_wavelength()),
        "focal_length": number(paraxial.focal_length),
        "rear_focal_length": number(paraxial.rear_focal_length()),
        "film_index": number(paraxial.film_index),
        "back_focal_distance": number(paraxial.back_focal_distance),
        "length": number(paraxial.length),
        "f_number": number(paraxial.f_number()),
        "f_number_marginal": focus.f_number().map(number),
        "film_distance": focus.film_distance(f64::INFINITY).ok().map(number),
        "entrance_pupil": pupil(paraxial.entrance_pupil),
        "exit_pupil": pupil(paraxial.exit_pupil),
        "stated_focal_length": lens.stated_focal_length.map(number),
        "stated_f_number": lens.stated_f_number.map(number),
        "zoom": lens.zoom_range(),
        "aligned": !lens.is_misaligned(),
        "surfaces": surfaces,
    });
    format!("{value:#}\n")
}
