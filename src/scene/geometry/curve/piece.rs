//! Pieces of a segment: the primitives of a hierarchy, short enough for tight boxes.

use glam::{DVec3, Vec3};

use super::set::{CubicPoints, CurveSet};

/// Largest angle through which the control polygon of a piece turns, approximately (rad). The
/// search for the nearest point of a piece then converges in a few steps.
const MAX_TURN: f64 = 0.4;
/// Least length of a piece over its width, unless it turns too far.
const LEAST_SLENDERNESS: f64 = 8.0;
/// Most pieces of a segment for the sake of tight boxes. On a head of 100,000 hairs of three segments,
/// 4, 6 and 8 take 430, 620 and 800 MB, and rays 2400, 1700 and 1450 ns.
const MAX_STRAIGHT: f64 = 6.0;
/// Most pieces of a segment.
const MAX_PIECES: f64 = 64.0;

/// A piece of a segment, whose parameter u runs from `part / parts` to `(part + 1) / parts`.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CurvePiece {
    /// Index of the segment.
    pub segment: u32,
    /// Number of the piece in its segment.
    pub part: u8,
    /// Number of pieces of the segment.
    pub parts: u8,
}

/// Bounds of a piece.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PieceBounds {
    /// Ends of the piece's chord.
    pub ends: [DVec3; 2],
    /// The piece and its width are within this distance of the chord.
    pub radius: f64,
    /// Lowest and highest corner of a box around the piece and its width.
    pub corners: [DVec3; 2],
}

/// Returns the number of pieces of a segment.
pub(super) fn count(points: CubicPoints) -> u32 {
    let [a, b, c, d] = points.control.map(|p| Vec3::from(p).as_dvec3());
    let (mut turn, mut length) = (0.0, 0.0);
    let mut last: Option<DVec3> = None;
    for side in [b - a, c - b, d - c] {
        length += side.length();
        if let Some(along) = side.try_normalize() {
            turn += last.map_or(0.0, |last| last.angle_between(along));
            last = Some(along);
        }
    }
    let width = f64::from(points.width[0].max(points.width[1]));
    // A length over a width of 0 is infinite, which is clamped.
    let slender = match length > 0.0 {
        true => (length / (LEAST_SLENDERNESS * width)).floor().clamp(1.0, MAX_STRAIGHT),
        false => 1.0,
    };
    (turn / MAX_TURN).ceil().max(slender).min(MAX_PIECES) as u32
}

impl CurveSet {
    /// Returns a piece by its number among those of all segments.
    pub fn piece(&self, number: u32) -> CurvePiece {
        let [segment, part, parts] = self.locate(number);
        CurvePiece { segment, part: part as u8, parts: parts as u8 }
    }

    /// Returns all pieces.
    pub fn pieces(&self) -> impl Iterator<Item = CurvePiece> + use<'_> {
        let all = 0..self.segments().len() as u32;
        all.flat_map(move |segment| {
            let parts = count(self.segments()[segment as usize]) as u8;
            (0..parts).map(move |part| CurvePiece { segment, part, parts })
        })
    }

    /// Returns the bounds of a piece.
    pub fn piece_bounds(&self, piece: CurvePiece) -> PieceBounds {
        let CubicPoints { control, width } = self.segments()[piece.segment as usize];
        let range = piece.range();
        let points = restricted(control.map(|p| Vec3::from(p).as_dvec3()), range);
        let width = range.map(|u| f64::from(width[0]) * (1.0 - u) + f64::from(width[1]) * u);
        let half = width[0].max(width[1]) / 2.0;
        let [a, b, c, d] = points;
        let off = distance(b, [a, d]).max(distance(c, [a, d]));
        let low = points.iter().fold(DVec3::INFINITY, |low, p| low.min(*p));
        let high = points.iter().fold(DVec3::NEG_INFINITY, |high, p| high.max(*p));
        PieceBounds { ends: [a, d], radius: half + off, corners: [low - half, high + half] }
    }
}

impl CurvePiece {
    /// Returns the least and the greatest u. Adjacent pieces share the same number.
    #[inline(always)]
    pub fn range(self) -> [f64; 2] {
        let parts = f64::from(self.parts);
        [f64::from(self.part) / parts, (f64::from(self.part) + 1.0) / parts]
    }
}

/// Returns the control points of the part of a Bezier curve between two parameters, by its polar
/// form (Ramshaw 1989, "Blossoms are polar forms").
fn restricted([a, b, c, d]: [DVec3; 4], [from, to]: [f64; 2]) -> [DVec3; 4] {
    let polar = |r: f64, s: f64, t: f64| {
        let (ab, bc, cd) = (a.lerp(b, r), b.lerp(c, r), c.lerp(d, r));
        ab.lerp(bc, s).lerp(bc.lerp(cd, s), t)
    };
    [polar(from, from, from), polar(from, from, to), polar(from, to, to), polar(to, to, to)]
}

/// Returns the distance of a point from a line segment.
fn distance(point: DVec3, [from, to]: [DVec3; 2]) -> f64 {
    let (along, offset) = (to - from, point - from);
    let share = offset.dot(along) / along.length_squared();
    // A segment of length 0 has no share.
    let share = if share.is_finite() { share.clamp(0.0, 1.0) } else { 0.0 };
    offset.distance(along * share)
}

#[cfg(test)]
mod tests {
    use glam::DAffine3;

    use super::*;
    use crate::geometry::{CurveKind, CurveSegment};

    /// Returns a set of a bent, a straight and a degenerate segment.
    fn curves() -> CurveSet {
        let mut set = CurveSet::new(CurveKind::Flat, false);
        let bent = [[0.0, 0.0, 0.0], [1.0, 2.0, 0.0], [2.0, -2.0, 1.0], [3.0, 0.0, 0.5]];
        let straight = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [2.0, 0.0, 0.0], [3.0, 0.0, 0.0]];
        for control in [bent, straight, [[1.0; 3]; 4]] {
            let control = control.map(DVec3::from_array);
            let segment = CurveSegment { control, width: [0.1, 0.2], normals: None };
            assert!(set.push(&segment, &DAffine3::IDENTITY));
        }
        set
    }

    #[test]
    fn pieces_are_those_that_are_found_by_number() {
        let set = curves();
        let pieces: Vec<CurvePiece> = set.pieces().collect();
        assert_eq!(pieces.len(), set.piece_count() as usize);
        assert!(pieces[0].parts > 8, "the bent segment has {} pieces", pieces[0].parts);
        let mut many = set.clone();
        for _ in 0..100 {
            many.append(set.clone()).unwrap();
        }
        let mut marked = many.clone();
        marked.finish();
        for set in [set, many, marked] {
            assert_eq!(set.pieces().count(), set.piece_count() as usize);
            for (number, piece) in set.pieces().enumerate() {
                assert_eq!(set.piece(number as u32), piece);
            }
        }
        assert_eq!(pieces.last().map(|piece| piece.parts), Some(1));
    }

    #[test]
    fn bounds_contain_the_piece_and_its_width() {
        let set = curves();
        for piece in set.pieces() {
            let PieceBounds { ends, radius, corners: [low, high] } = set.piece_bounds(piece);
            let CubicPoints { control, width } = set.segments()[piece.segment as usize];
            let [from, to] = piece.range();
            for step in 0..=20 {
                let u = from + (to - from) * f64::from(step) / 20.0;
                let point = restricted(control.map(|p| Vec3::from(p).as_dvec3()), [u, u])[0];
                let half = f64::from(width[0]).mul_add(1.0 - u, f64::from(width[1]) * u) / 2.0;
                let slack = 1e-9;
                assert!((point - half).cmpge(low - slack).all(), "{piece:?} {u}");
                assert!((point + half).cmple(high + slack).all(), "{piece:?} {u}");
                assert!(distance(point, ends) + half <= radius + slack, "{piece:?} {u}");
            }
            assert!(radius < 0.25, "{piece:?}: {radius}");
        }
    }
}
