//! The outlines of the glass.

use glam::{DAffine3, DVec3};

use super::super::prescription::{Prescription, Row};
use crate::svg::Point;

/// What bends light less than this is air, however exactly a file gives its index.
const AIR: f64 = 1.01;

/// Steps along half a surface. At 24 the polygon is off the arc by a tenth of a pixel.
const STEPS: i32 = 24;

/// A piece of glass.
#[derive(Debug)]
pub(super) struct Element {
    /// Its refractive index.
    pub index: f64,
    /// Its section with the y-z plane, closed, mm.
    pub outline: Vec<Point>,
}

/// One side of a piece of glass: its curve to the clear diameter, flat beyond.
#[derive(Clone, Copy)]
struct Face<'a> {
    row: &'a Row,
    /// Where it would stand if it stood square.
    vertex: f64,
    placed: DAffine3,
    half: f64,
}

impl Face<'_> {
    fn at(&self, h: f64) -> f64 {
        self.vertex + self.row.sag_at(0.0, h.min(self.half))
    }

    /// The curve from the lower rim to the upper.
    fn curve(&self) -> Vec<Point> {
        arc(self.row, &self.placed, self.half)
    }

    /// A point of the face, level beyond the clear diameter.
    fn point(&self, h: f64) -> Point {
        drawn(&self.placed, [0.0, h, self.row.sag_at(0.0, h.abs().min(self.half))])
    }
}

/// Where a point in the frame of a surface is drawn.
pub(super) fn drawn(placed: &DAffine3, point: [f64; 3]) -> Point {
    let point = placed.transform_point3(DVec3::from_array(point));
    [point.z, point.y]
}

/// The section of a surface through its vertex from `-half` to `half`, mm.
pub(super) fn arc(row: &Row, placed: &DAffine3, half: f64) -> Vec<Point> {
    // Equal steps of the angle on a hemisphere: the rim is where a curve is steep.
    let height =
        |i: i32| half * (f64::from(i) / f64::from(STEPS) * std::f64::consts::FRAC_PI_2).sin();
    let point = |h: f64| drawn(placed, [0.0, h, row.sag_at(0.0, h)]);
    let plane = row.asphere.is_empty() && row.sag_at(0.0, half) == 0.0;
    let step = if plane { STEPS as usize * 2 } else { 1 };
    (-STEPS..=STEPS).step_by(step).map(|i| point(height(i))).collect()
}

/// The pieces of glass of a lens, from the scene to the film; cemented ones share a curve.
pub(super) fn elements(lens: &Prescription, placed: &[DAffine3]) -> Vec<Element> {
    let vertices = lens.vertices();
    let face = |i: usize| {
        let row = &lens.rows[i];
        Face { row, vertex: vertices[i], placed: placed[i], half: row.diameter / 2.0 }
    };
    // A stop in the midst of a piece of glass does not cut it in two.
    let faces: Vec<Face> = (0..lens.rows.len())
        .filter(|&i| lens.index_before(i) != lens.rows[i].index)
        .map(face)
        .collect();
    let glass = |k: usize| k + 1 < faces.len() && faces[k].row.index > AIR;
    let reach = |k: usize| faces[k].half.max(faces[k + 1].half);
    let mut elements = Vec::new();
    for k in (0..faces.len()).filter(|&k| glass(k)) {
        let (front, back) = (faces[k], faces[k + 1]);
        let rim = reach(k);
        // The neighbours across the air, as far out as they have glass.
        let before = k.checked_sub(2).filter(|&j| glass(j) && !glass(j + 1));
        let behind = Some(k + 2).filter(|&j| !glass(j - 1) && glass(j));
        let clear = before.is_none_or(|j| apart(&faces[j + 1], &front, rim.min(reach(j))))
            && behind.is_none_or(|j| apart(&back, &faces[j], rim.min(reach(j))));
        let edge = (clear && apart(&front, &back, rim)).then_some(rim);
        elements.push(Element { index: front.row.index, outline: outline(&front, &back, edge) });
    }
    elements
}

/// Whether two faces do not cross below a height.
fn apart(front: &Face, back: &Face, rim: f64) -> bool {
    (0..=STEPS).all(|i| {
        let h = rim * f64::from(i) / f64::from(STEPS);
        front.at(h) <= back.at(h)
    })
}

/// Two curves and a cylinder of radius `edge` around them, or where there is no room for one a
/// straight line from rim to rim.
fn outline(front: &Face, back: &Face, edge: Option<f64>) -> Vec<Point> {
    let mut points = Vec::new();
    let corner = |face: &Face, side: f64| edge.map(|rim| face.point(side * rim));
    points.extend(corner(front, -1.0));
    points.extend(front.curve());
    points.extend(corner(front, 1.0));
    points.extend(corner(back, 1.0));
    points.extend(back.curve().into_iter().rev());
    points.extend(corner(back, -1.0));
    points
}
