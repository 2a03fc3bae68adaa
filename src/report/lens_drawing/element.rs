//! Outlines of glass elements.

use glam::{DAffine3, DVec3};

use petzval_lens::{Prescription, Row};

use crate::svg::Position;

/// Refractive index up to which a medium counts as air: files give its index with varying digits.
const AIR: f64 = 1.01;

/// Steps along half a surface. With 24, the polygon deviates from the arc by a tenth of a pixel.
const STEPS: i32 = 24;

/// A glass element.
#[derive(Debug)]
pub(super) struct Element {
    /// Refractive index.
    pub index: f64,
    /// Section with the y-z plane, closed (mm).
    pub outline: Vec<Position>,
}

/// One side of an element: its curve up to the clear diameter, flat beyond.
#[derive(Clone, Copy)]
struct Face<'a> {
    row: &'a Row,
    /// z of the vertex without tilt and decentre (mm).
    vertex: f64,
    /// Direction of travel of the light before it: -1 after an odd number of mirrors.
    travel: f64,
    placed: DAffine3,
    half: f64,
}

impl Face<'_> {
    fn at(&self, h: f64) -> f64 {
        self.vertex + self.row.sag_at(0.0, h.min(self.half))
    }

    /// Returns the curve from the lower rim to the upper.
    fn curve(&self) -> Vec<Position> {
        arc(self.row, &self.placed, self.half)
    }

    /// Returns a point of the face, level beyond the clear diameter.
    fn point(&self, h: f64) -> Position {
        drawn(&self.placed, [0.0, h, self.row.sag_at(0.0, h.abs().min(self.half))])
    }
}

/// Projects a point in the frame of a surface to the drawing.
pub(super) fn drawn(placed: &DAffine3, point: [f64; 3]) -> Position {
    let point = placed.transform_point3(DVec3::from_array(point));
    [point.z, point.y]
}

/// Returns the section of a surface through its vertex from `-half` to `half` (mm).
pub(super) fn arc(row: &Row, placed: &DAffine3, half: f64) -> Vec<Position> {
    // Equal steps of the angle on a hemisphere: curves are steepest at the rim.
    let height =
        |i: i32| half * (f64::from(i) / f64::from(STEPS) * std::f64::consts::FRAC_PI_2).sin();
    let point = |h: f64| drawn(placed, [0.0, h, row.sag_at(0.0, h)]);
    let plane = row.asphere.is_empty() && row.sag_at(0.0, half) == 0.0;
    let step = if plane { STEPS as usize * 2 } else { 1 };
    (-STEPS..=STEPS).step_by(step).map(|i| point(height(i))).collect()
}

/// Returns the section of a surface through its vertex between two heights (mm).
pub(super) fn arc_between(row: &Row, placed: &DAffine3, [low, high]: [f64; 2]) -> Vec<Position> {
    let height = |i: i32| low + (high - low) * f64::from(i) / f64::from(2 * STEPS);
    let point = |h: f64| drawn(placed, [0.0, h, row.sag_at(0.0, h)]);
    (0..=2 * STEPS).map(|i| point(height(i))).collect()
}

/// Returns the lowest and the highest point of the open part of a surface (mm).
pub(super) fn opening(row: &Row) -> [f64; 2] {
    let half = row.diameter / 2.0;
    row.apertures.iter().filter(|aperture| !aperture.obscures).fold(
        [-half, half],
        |[low, high], aperture| {
            let [bottom, top] = aperture.range_along_y();
            [low.max(bottom), high.min(top)]
        },
    )
}

/// Returns the glass elements of a lens, from the scene to the film; cemented ones share a curve.
pub(super) fn elements(lens: &Prescription, placed: &[DAffine3]) -> Vec<Element> {
    let vertices = lens.vertex_positions();
    let travels = lens.travels();
    let face = |i: usize| {
        let (row, travel) = (&lens.rows[i], travels[i]);
        Face { row, vertex: vertices[i], travel, placed: placed[i], half: row.diameter / 2.0 }
    };
    // A stop inside an element does not divide it.
    let faces: Vec<Face> = (0..lens.rows.len())
        .filter(|&i| {
            let glass = lens.rows[i].index;
            lens.index_before(i) != glass || (lens.rows[i].mirror && glass > AIR)
        })
        .map(face)
        .collect();
    let glass = |k: usize| k + 1 < faces.len() && faces[k].row.index > AIR;
    let reach = |k: usize| faces[k].half.max(faces[k + 1].half);
    let mut elements = Vec::new();
    for k in (0..faces.len()).filter(|&k| glass(k)) {
        let (front, back) = (faces[k], faces[k + 1]);
        let rim = reach(k);
        // Neighbours across the air, which limit how far out the edge may reach.
        let before = k.checked_sub(2).filter(|&j| glass(j) && !glass(j + 1));
        let behind = Some(k + 2).filter(|&j| !glass(j - 1) && glass(j));
        let clear = before.is_none_or(|j| apart(&faces[j + 1], &front, rim.min(reach(j))))
            && behind.is_none_or(|j| apart(&back, &faces[j], rim.min(reach(j))));
        let edge = (clear && apart(&front, &back, rim)).then_some(rim);
        elements.push(Element { index: front.row.index, outline: outline(&front, &back, edge) });
    }
    elements
}

/// Returns whether two faces do not cross below a height.
fn apart(front: &Face, back: &Face, rim: f64) -> bool {
    (0..=STEPS).all(|i| {
        let h = rim * f64::from(i) / f64::from(STEPS);
        // A face at which light turns back is the end of the element before it.
        let way = if front.row.mirror { -front.travel } else { front.travel };
        way * front.at(h) <= way * back.at(h)
    })
}

/// Returns two curves with a cylindrical edge of this radius, or with straight lines from rim to
/// rim if there is no room for one.
fn outline(front: &Face, back: &Face, edge: Option<f64>) -> Vec<Position> {
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
