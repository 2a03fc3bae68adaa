//! Diameters that a file does not state: that of the stop, and those that its rays need.

use petzval_base::bisection::bisect;

use super::SystemAperture;
use super::wide_field::StopRays;
use crate::focus::paraxial::Paraxial;
use crate::prescription::Prescription;
use crate::prescription::design::FieldKind;
use crate::trace::kernel::LensRay;
use crate::trace::sequence::{Side, sequence};
use crate::trace::surface::Surface;
use crate::trace::trace_one;

/// Room between the outermost ray and the rim.
const MARGIN: f64 = 1.02;

/// Half field of a lens whose file states none (degrees).
const UNKNOWN_FIELD: f64 = 10.0;

/// Field points, in shares of the half field.
const FIELD_SHARES: [f64; 5] = [0.0, 0.35, 0.7, 0.85, 1.0];

/// Steepest slope of an asphere at its rim: 72 degrees. The steepest of the lenses of phones have 70.
const STEEPEST: f64 = 3.0;

/// Heights at which the slope of an asphere is tested.
const VALIDITY_STEPS: u32 = 1000;

/// Steps of the search for the ends of a pupil, by radius of the pupil, and halvings of its last step.
const PUPIL_STEPS: i32 = 20;
const PUPIL_HALVINGS: u32 = 30;

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
        lens.rows[row].diameter = (2.0 * MARGIN * heights[row]).min(widest(lens, row));
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
    for &row in unknown {
        open.rows[row].diameter = widest(lens, row);
    }
    if let Some(angle) = wide_field(lens, object) {
        return wide_heights(lens, &open, angle, notes);
    }
    let fields = FieldRays::new(&open, &paraxial, object);
    let mut heights = paraxial_heights(lens, field, object);
    let mut found = vec![0.0f64; lens.rows.len()];
    for share in FIELD_SHARES {
        fields.raise((share * field).to_radians().tan(), &mut found);
    }
    for (height, found) in heights.iter_mut().zip(found) {
        if found > 0.0 {
            *height = found;
        }
    }
    heights
}

/// Returns the diameter of an open rim (mm), within which the surface is one that can be made: a
/// polynomial beyond its last valid height falls or rises steeply, and rays find a second crossing there.
fn widest(lens: &Prescription, row: usize) -> f64 {
    let size = 1e3 * lens.rows.iter().map(|row| row.diameter).fold(1.0, f64::max);
    let row = &lens.rows[row];
    let open = (0.9995 * row.edge()).min(size);
    if row.asphere.is_empty() && row.across.is_none() {
        return open;
    }
    let open = open.min(20.0 * lens.rows[lens.stop()].diameter);
    let height = |i: u32| open / 2.0 * f64::from(i) / f64::from(VALIDITY_STEPS);
    let steep = |i: &u32| row.slope(height(*i)).is_nan() || row.slope(height(*i)).abs() > STEEPEST;
    match (1..=VALIDITY_STEPS).find(steep) {
        Some(i) => 2.0 * height(i - 1).max(1e-3),
        None => open,
    }
}

/// Rays from a field point through a lens whose unknown rims are open.
struct FieldRays {
    surfaces: Vec<Surface<f64>>,
    rows: usize,
    object: f64,
    /// Position (mm) and radius (mm) of the entrance pupil of first-order optics.
    pupil: [f64; 2],
    /// Distance of the first plane before the front vertex (mm).
    start: f64,
}

impl FieldRays {
    fn new(open: &Prescription, paraxial: &Paraxial, object: f64) -> Self {
        let pupil = paraxial.entrance_pupil;
        let start = (2.0 * pupil.diameter).max(1.0);
        let surfaces = sequence::<f64>(open, Side::Scene(start));
        let rows = open.rows.len();
        Self { surfaces, rows, object, pupil: [pupil.position, pupil.diameter / 2.0], start }
    }

    /// Returns the heights at all rows (mm) of the ray from a field point to a point of the pupil's plane,
    /// in radii of the pupil; `None` if it does not leave the lens.
    fn trace(&self, slope: f64, at: [f64; 2]) -> Option<Vec<f64>> {
        let [position, radius] = self.pupil;
        let target = at.map(|v| v * radius);
        let slopes = match self.object.is_finite() {
            false => [0.0, slope],
            true => {
                let run = self.object + position;
                let height = -slope * run;
                [target[0] / run, (target[1] - height) / run]
            }
        };
        let run = self.start + position;
        let p = [target[0] - slopes[0] * run, target[1] - slopes[1] * run, 0.0];
        let scale = 1.0 / (1.0 + slopes[0] * slopes[0] + slopes[1] * slopes[1]).sqrt();
        let mut ray = LensRay::<f64>::new(p, [slopes[0] * scale, slopes[1] * scale, scale]);
        let mut heights = vec![0.0f64; self.rows];
        for surface in &self.surfaces {
            ray = trace_one::<f64>(ray, std::slice::from_ref(surface)).ok()?;
            heights[surface.row] = heights[surface.row].max(ray.p[0].hypot(ray.p[1]));
        }
        Some(heights)
    }

    /// Raises the heights to those of the rays of a field point that the stop and the known rims let
    /// through. The pupil of real rays may be larger than that of first-order optics, and elsewhere: its
    /// ends are searched along y, and then along x through its middle.
    fn raise(&self, slope: f64, heights: &mut [f64]) {
        let mut raise = |found: Vec<f64>| {
            for (height, found) in heights.iter_mut().zip(found) {
                *height = height.max(found);
            }
        };
        let along_y = |y: f64| self.trace(slope, [0.0, y]);
        let Some([low, high]) = passing(&along_y) else { return };
        [low, high].into_iter().filter_map(along_y).for_each(&mut raise);
        let middle = (low + high) / 2.0;
        let along_x = |x: f64| self.trace(slope, [x, middle]);
        let ends = passing(&along_x);
        ends.into_iter().flatten().filter_map(along_x).for_each(raise);
    }
}

/// Returns the ends of the interval of pupil coordinates, from -2 to 2, in which rays pass: that about the
/// passing coordinate nearest to 0.
fn passing(trace: &dyn Fn(f64) -> Option<Vec<f64>>) -> Option<[f64; 2]> {
    let at = |i: i32| f64::from(i) / f64::from(PUPIL_STEPS);
    let passes = |i: &i32| trace(at(*i)).is_some();
    let middle = (0..=2 * PUPIL_STEPS).flat_map(|i| [i, -i]).find(passes)?;
    let end = |sign: i32| {
        let steps = 2 * PUPIL_STEPS - sign * middle;
        let outside = (1..=steps).map(|i| middle + sign * i).find(|i| !passes(i));
        let Some(outside) = outside else { return 2.0 * f64::from(sign) };
        let ends = [at(outside - sign), at(outside)];
        bisect(ends, PUPIL_HALVINGS, |between| trace(between).is_some())[0]
    };
    Some([end(-1), end(1)])
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
    use crate::focus::paraxial::RayTransferMatrix;
    use crate::prescription::TransverseAxis::X;
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
