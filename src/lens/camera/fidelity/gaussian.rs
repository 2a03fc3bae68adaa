//! First-order optics in place of a real lens: surface by surface, or one group on each side of the
//! stop.

use std::ops::Range;

use super::thin::{in_focus, pupil_position};
use crate::camera::RealLens;
use crate::focus::paraxial::{Paraxial, RayTransferMatrix};
use crate::prescription::pose::{FilmPlane, Pose};
use crate::prescription::{Prescription, Row, Rows, TransverseAxis};
use crate::trace::kernel::LensRay;
use crate::trace::sequence::{Side, sequence};
use crate::trace::surface::Surface;
use crate::trace::trace_one;

const AXES: [TransverseAxis; 2] = [TransverseAxis::X, TransverseAxis::Y];

/// Factor by which rims that must not block are larger than the light.
const MARGIN: f64 = 1.05;
/// Largest diameter of such rims (mm).
const MAX_DIAMETER: f64 = 1e6;

/// Returns a row that refracts by first-order optics.
fn ideal(row: &Row, planes: [RayTransferMatrix; 2]) -> Row {
    Row {
        radius: f64::INFINITY,
        conic: 0.0,
        asphere: Vec::new(),
        across: None,
        axis: None,
        ideal: Some(planes),
        ..row.clone()
    }
}

/// Returns the matrices of the refraction at one row.
fn row_matrices(lens: &Prescription, row: usize) -> [RayTransferMatrix; 2] {
    AXES.map(|axis| RayTransferMatrix::IDENTITY.through_row(lens, row, axis))
}

/// Returns the lens with every surface replaced by a plane that refracts by first-order optics.
/// Rims and openings stay. Mirrors are unfolded, see [`unfolded`].
pub(super) fn paraxial(lens: &Prescription) -> Prescription {
    let media = lens.all_signed_indices();
    let matrices = |i: usize| {
        AXES.map(|axis| RayTransferMatrix::IDENTITY.through(&lens.rows[i], media[i], axis))
    };
    let row = |i: usize| ideal(&lens.rows[i], matrices(i));
    let ideal = Prescription { rows: lens.rows.map(row), ..lens.clone() };
    if lens.has_mirrors() { unfolded(lens, ideal) } else { ideal }
}

/// Unfolds the ideal rows of a lens with mirrors: all light travels along +z, through planes that
/// refract as the mirrors reflect. A row's matrix holds for heights and index times slope along the
/// way of the light, which are the same on the folded way. Folds and tilts are left out.
fn unfolded(folded: &Prescription, mut ideal: Prescription) -> Prescription {
    for (row, travel) in ideal.rows.iter_mut().zip(&folded.travels()[1..]) {
        row.thickness *= travel;
        row.mirror = false;
    }
    ideal.centre();
    ideal
}

/// Returns the centred lens as its stop, with one ideal lens for the group before it and one for
/// the group behind it. Only the rim of the stop blocks light that reaches the film.
///
/// This is equivalent to the exit pupil and the collineation of the principal planes. Because the
/// opening has its shape in the plane of the stop, a pupil at infinity needs no special case.
pub(super) fn thick(lens: &Prescription, film: &FilmPlane) -> Prescription {
    if lens.has_mirrors() {
        return thick(&paraxial(lens), film);
    }
    let (stop, last) = (lens.stop(), lens.rows.len() - 1);
    let length = |rows: Range<usize>| lens.rows[rows].iter().map(|row| row.thickness).sum::<f64>();
    let [front, rear] = [length(0..stop), length(stop..last)];
    let group = |ideal: [RayTransferMatrix; 2]| Row { ideal: Some(ideal), ..Row::default() };
    let before = (stop > 0).then(|| {
        let index = lens.index_before(stop);
        let ideal = AXES.map(|axis| {
            // The distance to the stop is a thickness of the new lens; the matrix excludes it.
            RayTransferMatrix::IDENTITY.through_rows(lens, 0..stop, axis).transfer(-front, index)
        });
        Row { thickness: front, index, ..group(ideal) }
    });
    let own = Row { thickness: rear, ..ideal(&lens.rows[stop], row_matrices(lens, stop)) };
    let behind = (stop < last).then(|| {
        let Row { thickness, index, .. } = lens.rows[stop];
        let ideal = AXES.map(|axis| {
            let back = RayTransferMatrix::IDENTITY.transfer(thickness - rear, index);
            back.through_rows(lens, stop + 1..last, axis).through_row(lens, last, axis)
        });
        Row { index: lens.rear().index, ..group(ideal) }
    });
    let rows = Rows::around_stop(before, own, behind);
    let mut thick = Prescription { rows, ..lens.clone() };
    thick.centre();
    open_rims(&mut thick, film);
    thick
}

/// Returns a lens whose rims and openings block nothing.
fn unclipped(mut lens: Prescription) -> Prescription {
    for row in &mut lens.rows {
        row.diameter = MAX_DIAMETER;
        row.open_all();
    }
    lens
}

/// Widens the rims before and behind the stop to the light from the film.
fn open_rims(thick: &mut Prescription, film: &FilmPlane) {
    let (stop, last) = (thick.stop(), thick.rows.len() - 1);
    let [x, y] = film.pose.decentre;
    let reach = film.radius + x.hypot(y);
    // Distance of the point of the film nearest to the lens.
    let tilted = film.pose.tilt.iter().map(|degrees| degrees.to_radians().sin().abs());
    let ahead = (film.distance - film.radius * tilted.sum::<f64>()).max(0.1 * film.distance);
    let half = thick.rows[stop].diameter / 2.0;
    let [mut front, mut rear] = [half; 2];
    for axis in AXES {
        let index = thick.rear().index;
        let reduced = index / ahead;
        let through = |i: usize| RayTransferMatrix::IDENTITY.through_row(thick, i, axis);
        let Row { thickness, index, .. } = thick.rows[stop];
        let behind = if stop < last { thickness / index } else { 0.0 };
        let to_rear = match stop < last {
            true => RayTransferMatrix::IDENTITY.transfer(thickness, index).then(through(last)),
            false => RayTransferMatrix::IDENTITY,
        };
        for sign in [1.0, -1.0] {
            // The ray from the film point through the rim of the stop.
            let RayTransferMatrix { a, b, c, d } = to_rear;
            let u = (sign * half + b * reduced * reach) / (d + b * reduced);
            let slope_behind = c * u + a * reduced * (u - reach);
            let RayTransferMatrix { a, b, c, d } = through(stop);
            let (height, slope) =
                (d * sign * half + b * slope_behind, c * sign * half + a * slope_behind);
            // An ideal lens is not thin: rays leave it at another height than that at which they
            // meet it.
            rear = rear.max(u.abs()).max((sign * half - behind * slope_behind).abs());
            if stop > 0 {
                let Row { thickness, index, .. } = thick.rows[0];
                let RayTransferMatrix { b, d, .. } = through(0).transfer(thickness, index);
                let met = height + thickness / index * slope;
                front = front.max(met.abs()).max((d * height + b * slope).abs());
            }
        }
    }
    let rim = |half: f64| {
        if half.is_finite() { (2.0 * MARGIN * half).min(MAX_DIAMETER) } else { MAX_DIAMETER }
    };
    if stop < last {
        thick.rows[last].diameter = rim(rear);
    }
    if stop > 0 {
        thick.rows[0].diameter = rim(front);
    }
}

/// Returns the film on which first-order optics has the same objects in focus as real rays have on
/// the film of the lens, and the factors along x and y by which it is larger to cover the same
/// field near the axis.
pub(super) fn refocused(lens: &RealLens) -> (FilmPlane, [f64; 2]) {
    let planes = AXES.map(|axis| Paraxial::in_plane(&lens.prescription, axis));
    let distance = planes[0].image_distance(in_focus(lens));
    let usable = distance > 0.0 && (distance - lens.film_distance).abs() < 0.1 * lens.film_distance;
    if !usable {
        return (lens.film, [1.0; 2]);
    }
    let scale = planes.map(|plane| {
        let slope = |distance| plane.chief_slope(pupil_position(&plane), distance);
        slope(lens.film_distance) / slope(distance)
    });
    let FilmPlane { pose: Pose { decentre, tilt }, radius, half, .. } = lens.film;
    let scaled = |v: [f64; 2]| [0, 1].map(|i| v[i] * scale[i]);
    let film = FilmPlane {
        distance,
        pose: Pose { decentre: scaled(decentre), tilt },
        radius: radius * scale[0].max(scale[1]),
        half: scaled(half),
    };
    (film, scale)
}

/// Tracer of rays to the entrance pupil of a lens.
pub struct PupilPoint(Vec<Surface<f64>>);

impl PupilPoint {
    /// Returns the tracer of a lens, by its cardinal points.
    pub fn new(lens: &RealLens) -> Self {
        let ideal = unclipped(thick(&lens.monochromatic(), &lens.film));
        Self(sequence::<f64>(&ideal, Side::Film(lens.film_distance)))
    }

    /// Returns the point at which a ray from the film crosses the plane `z` before the front vertex
    /// (mm); `None` if it does not.
    pub fn trace(&self, ray: LensRay<f64>, z: f64) -> Option<[f64; 2]> {
        let LensRay { p, t, .. } = trace_one::<f64>(ray, &self.0).ok()?;
        let s = (z - p[2]) / t[2];
        let point = [p[0] + s * t[0], p[1] + s * t[1]];
        point.iter().all(|v| v.is_finite()).then_some(point)
    }
}
