//! First-order optics in place of a real lens: surface by surface, or before and behind the stop.

use std::ops::Range;

use crate::lens::iris::Iris;
use crate::lens::paraxial::Matrix;
use crate::lens::pose::FilmPlane;
use crate::lens::prescription::{Axis, Prescription, Row};

const AXES: [Axis; 2] = [Axis::X, Axis::Y];

/// By how much rims that are to stop nothing are opened beyond the light.
const SPARE: f64 = 1.05;
/// The widest of them, mm.
const WIDEST: f64 = 1e6;

/// What a row becomes where it refracts by first-order optics.
fn ideal(row: &Row, planes: [Matrix; 2]) -> Row {
    Row {
        radius: f64::INFINITY,
        conic: 0.0,
        asphere: Vec::new(),
        axis: None,
        ideal: Some(planes),
        ..row.clone()
    }
}

/// The matrices of one row alone.
fn alone(lens: &Prescription, row: usize) -> [Matrix; 2] {
    AXES.map(|axis| Matrix::IDENTITY.cross(lens, row, axis))
}

/// The lens with every surface a plane that refracts by first-order optics, and all rims and
/// openings as they are.
pub(super) fn paraxial(lens: &Prescription) -> Prescription {
    let row = |i: usize| ideal(&lens.rows[i], alone(lens, i));
    Prescription { rows: (0..lens.rows.len()).map(row).collect(), ..lens.clone() }
}

/// The lens as its stop, and all that stands before it and behind it as one ideal lens each. No rim
/// but the stop's is met by light that comes to the film. Elements stand square.
///
/// From the film that is the exit pupil and the collineation of the principal planes; in the plane
/// of the stop itself the opening has its shape, and a pupil at infinity is nothing special.
pub(super) fn thick(lens: &Prescription, film: &FilmPlane) -> Prescription {
    let (stop, last) = (lens.stop(), lens.rows.len() - 1);
    let way = |rows: Range<usize>| lens.rows[rows].iter().map(|row| row.thickness).sum::<f64>();
    let [front, rear] = [way(0..stop), way(stop..last)];
    let group = |ideal: [Matrix; 2]| Row { ideal: Some(ideal), ..Row::default() };
    let mut rows = Vec::with_capacity(3);
    if stop > 0 {
        let index = lens.index_before(stop);
        let ideal = AXES.map(|axis| {
            // The way that light goes straight from here to the stop comes after it.
            Matrix::IDENTITY.through(lens, 0..stop, axis).transfer(-front, index)
        });
        rows.push(Row { thickness: front, index, ..group(ideal) });
    }
    rows.push(Row { thickness: rear, ..ideal(&lens.rows[stop], alone(lens, stop)) });
    if stop < last {
        let Row { thickness, index, .. } = lens.rows[stop];
        let ideal = AXES.map(|axis| {
            let back = Matrix::IDENTITY.transfer(thickness - rear, index);
            back.through(lens, stop + 1..last, axis).cross(lens, last, axis)
        });
        rows.push(Row { index: lens.rear().index, ..group(ideal) });
    }
    let mut thick = Prescription { rows, ..lens.clone() };
    thick.centre();
    open(&mut thick, film);
    thick
}

/// The same with nothing in the way of a ray.
pub(super) fn unclipped(mut lens: Prescription) -> Prescription {
    for row in &mut lens.rows {
        (row.diameter, row.iris, row.obstruction) = (WIDEST, Iris::Round, 0.0);
    }
    lens
}

/// Opens the rims before and behind the stop as far as light from the film goes.
fn open(thick: &mut Prescription, film: &FilmPlane) {
    let (stop, last) = (thick.stop(), thick.rows.len() - 1);
    let [x, y] = film.pose.decentre;
    let reach = film.radius + x.hypot(y);
    // What of the film stands nearest to the lens.
    let tilted = film.pose.tilt.iter().map(|degrees| degrees.to_radians().sin().abs());
    let ahead = (film.distance - film.radius * tilted.sum::<f64>()).max(0.1 * film.distance);
    let half = thick.rows[stop].diameter / 2.0;
    let [mut front, mut rear] = [half; 2];
    for axis in AXES {
        let index = thick.rear().index;
        let reduced = index / ahead;
        let through = |i: usize| Matrix::IDENTITY.cross(thick, i, axis);
        let Row { thickness, index, .. } = thick.rows[stop];
        let behind = if stop < last { thickness / index } else { 0.0 };
        let to_rear = match stop < last {
            true => Matrix::IDENTITY.transfer(thickness, index).then(through(last)),
            false => Matrix::IDENTITY,
        };
        for sign in [1.0, -1.0] {
            // From the film point to the rim of the stop, and on.
            let Matrix { a, b, c, d } = to_rear;
            let u = (sign * half + b * reduced * reach) / (d + b * reduced);
            let slope_behind = c * u + a * reduced * (u - reach);
            let Matrix { a, b, c, d } = through(stop);
            let (height, slope) =
                (d * sign * half + b * slope_behind, c * sign * half + a * slope_behind);
            // A lens is met where the light comes straight from the stop, and left elsewhere.
            rear = rear.max(u.abs()).max((sign * half - behind * slope_behind).abs());
            if stop > 0 {
                let Row { thickness, index, .. } = thick.rows[0];
                let Matrix { b, d, .. } = through(0).transfer(thickness, index);
                let met = height + thickness / index * slope;
                front = front.max(met.abs()).max((d * height + b * slope).abs());
            }
        }
    }
    let rim = |half: f64| if half.is_finite() { (2.0 * SPARE * half).min(WIDEST) } else { WIDEST };
    if stop < last {
        thick.rows[last].diameter = rim(rear);
    }
    if stop > 0 {
        thick.rows[0].diameter = rim(front);
    }
}
