//! Diameters that a file does not state: that of the stop, and those that its rays need.

use super::SystemAperture;
use super::wide_field::StopRays;
use crate::lens::analysis::paraxial::Paraxial;
use crate::lens::prescription::Prescription;
use crate::lens::prescription::design::FieldKind;
use crate::lens::trace::kernel::LensRay;
use crate::lens::trace::sequence::{Side, sequence};
use crate::lens::trace::trace_one;

/// Room between the outermost ray and the rim.
const MARGIN: f64 = 1.02;

/// Half field of a lens whose file states none (degrees).
const UNKNOWN_FIELD: f64 = 10.0;

/// Widest field that first-order optics aims at (degrees).
const WIDEST_FIELD: f64 = 80.0;

/// Half field from which rays are aimed from the stop (degrees), and the widest that is.
const WIDE_FIELD: [f64; 2] = [60.0, 150.0];

/// Sets the stop by the aperture of the system, and every unknown diameter so wide that no ray of
/// the field points through the open stop is cut.
pub(super) fn complete_diameters(
    lens: &mut Prescription,
    unknown: &[usize],
    aperture: Option<SystemAperture>,
    notes: &mut Vec<String>,
) {
    let stop = lens.stop();
    let object = lens.design.object_distance.unwrap_or(f64::INFINITY);
    if let Some(aperture) = aperture {
        lens.rows[stop].diameter = 1.0;
        let paraxial = Paraxial::new(lens);
        // The pupil of a stop of 1 mm has the diameter 1 / a.
        let diameter =
            aperture.entrance_pupil(&paraxial, object) / paraxial.entrance_pupil.diameter;
        if diameter.is_finite() && diameter > 0.0 {
            lens.rows[stop].diameter = diameter;
        }
    } else if unknown.contains(&stop) {
        let known = |i: &usize| lens.rows[*i].diameter > 0.0;
        let nearest = (0..lens.rows.len()).filter(known).min_by_key(|i| i.abs_diff(stop));
        let diameter = nearest.map_or(10.0, |i| lens.rows[i].diameter);
        lens.rows[stop].diameter = diameter;
        notes.push(format!("the file states no diameter of the stop; {diameter:.4} mm is used"));
    }
    let unknown: Vec<usize> = unknown.iter().copied().filter(|&row| row != stop).collect();
    if unknown.is_empty() {
        return;
    }
    let heights = heights(lens, &unknown, object, notes);
    for &row in &unknown {
        lens.rows[row].diameter = 2.0 * MARGIN * heights[row];
    }
    notes.push(format!(
        "the file states no diameter of {} of {} surfaces; those that its rays need are used",
        unknown.len(),
        lens.rows.len()
    ));
}

/// Returns the greatest height of the rays of the field points at every row (mm).
fn heights(
    lens: &Prescription,
    unknown: &[usize],
    object: f64,
    notes: &mut Vec<String>,
) -> Vec<f64> {
    let paraxial = Paraxial::new(lens);
    let field = half_field(lens, &paraxial, object);
    let mut open = lens.clone();
    let widest = 1e3 * open.rows.iter().map(|row| row.diameter).fold(1.0, f64::max);
    for &row in unknown {
        let row = &mut open.rows[row];
        row.diameter = (0.9995 * row.edge()).min(widest);
        // Beyond its clear diameter an asphere is of no concern: only crossings are wanted.
        if !row.asphere.is_empty() || row.across.is_some() {
            row.diameter = row.diameter.min(20.0 * lens.rows[lens.stop()].diameter);
        }
    }
    if let Some(angle) = wide_field(lens, object) {
        return wide_heights(lens, &open, angle, notes);
    }
    let pupil = paraxial.entrance_pupil;
    let start = (2.0 * pupil.diameter).max(1.0);
    let surfaces = sequence::<f64>(&open, Side::Scene(start));
    let mut heights = paraxial_heights(lens, field, object);
    let mut found = vec![0.0f64; lens.rows.len()];
    for angle in [0.0, 0.7 * field, field] {
        let slope = angle.to_radians().tan();
        for at in [[0.0, 0.0], [0.0, 1.0], [0.0, -1.0], [1.0, 0.0]] {
            let target = at.map(|v| v * pupil.diameter / 2.0);
            // The ray through a point of the entrance pupil, from the field point.
            let slopes = match object.is_finite() {
                false => [0.0, slope],
                true => {
                    let height = -slope * (object + pupil.position);
                    let run = object + pupil.position;
                    [target[0] / run, (target[1] - height) / run]
                }
            };
            let run = start + pupil.position;
            let p = [target[0] - slopes[0] * run, target[1] - slopes[1] * run, 0.0];
            let scale = 1.0 / (1.0 + slopes[0] * slopes[0] + slopes[1] * slopes[1]).sqrt();
            let mut ray = LensRay::<f64>::new(p, [slopes[0] * scale, slopes[1] * scale, scale]);
            for surface in &surfaces {
                match trace_one::<f64>(ray, std::slice::from_ref(surface)) {
                    Ok(next) => ray = next,
                    Err(_) => break,
                }
                found[surface.row] = found[surface.row].max(ray.p[0].hypot(ray.p[1]));
            }
        }
    }
    for (height, found) in heights.iter_mut().zip(found) {
        if found > 0.0 {
            *height = found;
        }
    }
    heights
}

/// Returns the largest angle of a field that is too wide for first-order optics (degrees).
fn wide_field(lens: &Prescription, object: f64) -> Option<f64> {
    let fields = lens.design.fields.as_ref()?;
    if fields.kind != FieldKind::Angle || object.is_finite() || lens.is_misaligned() {
        return None;
    }
    let most = fields.points.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
    (most > WIDE_FIELD[0]).then(|| most.min(WIDE_FIELD[1]))
}

/// Returns the greatest height of the rays of a wide field at every row (mm). `open` is the lens
/// with all unknown rims open.
fn wide_heights(
    lens: &Prescription,
    open: &Prescription,
    field: f64,
    notes: &mut Vec<String>,
) -> Vec<f64> {
    let rays = StopRays::new(open);
    let mut heights = vec![0.0; lens.rows.len()];
    let reached = (0..=20)
        .map(|i| field * f64::from(i) / 20.0)
        .filter(|&angle| rays.raise(angle, &mut heights))
        .fold(0.0, f64::max);
    if reached < field {
        notes.push(format!(
            "no ray of the field reaches the stop beyond {reached:.1} of {field:.1} degrees; \
             diameters are those of the narrower field"
        ));
    }
    let paraxial = paraxial_heights(lens, WIDE_FIELD[0], f64::INFINITY);
    for (height, paraxial) in heights.iter_mut().zip(paraxial) {
        if *height == 0.0 {
            *height = paraxial;
        }
    }
    heights
}

/// Returns the sum of the heights of the marginal and the chief ray by first-order optics (mm).
fn paraxial_heights(lens: &Prescription, field: f64, object: f64) -> Vec<f64> {
    use crate::lens::analysis::paraxial::RayTransferMatrix;
    use crate::lens::prescription::TransverseAxis::X;
    let pupil = Paraxial::new(lens).entrance_pupil;
    let slope = field.to_radians().tan();
    let marginal = match object.is_finite() {
        true => [pupil.diameter / 2.0 * object / (object + pupil.position), {
            pupil.diameter / 2.0 / (object + pupil.position)
        }],
        false => [pupil.diameter / 2.0, 0.0],
    };
    let chief = [-slope * pupil.position, slope];
    let mut matrix = RayTransferMatrix::IDENTITY;
    let mut heights = Vec::with_capacity(lens.rows.len());
    for i in 0..lens.rows.len() {
        let at = |[y, u]: [f64; 2]| (matrix.a * y + matrix.b * u).abs();
        let height = at(marginal) + at(chief);
        heights.push(if height.is_finite() { height.max(1e-3) } else { 1.0 });
        matrix = matrix.through_rows(lens, i..i + 1, X);
    }
    heights
}

/// Returns the largest field angle (degrees).
fn half_field(lens: &Prescription, paraxial: &Paraxial, object: f64) -> f64 {
    let Some(fields) = &lens.design.fields else { return UNKNOWN_FIELD };
    let most = fields.points.iter().map(|[x, y]| x.hypot(*y)).fold(0.0, f64::max);
    let angle = match fields.kind {
        FieldKind::Angle => most,
        FieldKind::ImageHeight => (most / paraxial.focal_length.abs()).atan().to_degrees(),
        FieldKind::ObjectHeight if object.is_finite() => {
            (most / (object + paraxial.entrance_pupil.position)).atan().to_degrees()
        }
        FieldKind::ObjectHeight => 0.0,
    };
    if angle.is_finite() { angle.min(WIDEST_FIELD) } else { UNKNOWN_FIELD }
}
