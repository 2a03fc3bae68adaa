//! Intersection of a ray with a piece of a curve.
//!
//! A ray hits a curve where it passes the nearest point of the curve, as seen along the ray, within
//! half the width. In the plane perpendicular to the ray, the nearest point c(u) of a piece is a
//! zero of c . c', which a safeguarded Newton iteration finds (Nakamaru & Ohno 2002, "Ray tracing
//! for curves primitive", approximate it by chords, and pbrt-v4 does, too).
//!
//! The computation is in f64 and for single rays: tests of eight capsules at once come before it
//! and leave few rays ([`CurvePacket`](crate::bvh)). Adjacent pieces compute the same bits
//! where they meet, so that no ray passes between them.

use glam::{DVec2, DVec3, Vec3};

use super::piece::CurvePiece;
use super::set::{CubicPoints, CurveSet};

/// Slack of the angle at the ends of a segment (rad), so that no ray passes between the segments
/// of a smooth curve, whose tangents are equal to rounding.
const END_ANGLE: f64 = 1e-5;
/// The same slack for the rounding of control points to f32: of two points, and the next segment's.
const END_ROUNDING: f64 = 4.0 * f32::EPSILON as f64;
/// Change of u that ends the search: below the rounding of u to f32.
const PRECISION: f64 = 1e-9;
/// Least cosine between the projected tangents at the ends of a piece that is searched at once.
const LEAST_ALIGNMENT: f64 = 0.5;
/// Parts of any other piece.
const PARTS_ALONG: u32 = 16;
/// Most steps of the search; five are enough but for rays along the curve.
const MAX_STEPS: u32 = 24;

/// A ray with a frame whose z axis is its direction.
#[derive(Clone, Copy, Debug)]
pub struct CurveRay {
    origin: DVec3,
    x: DVec3,
    y: DVec3,
    z: DVec3,
    /// Length of the direction.
    length: f64,
}

/// A hit on a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveCrossing {
    /// Distance, in lengths of the ray's direction.
    pub t: f64,
    /// Parameter along the segment, 0 to 1.
    pub u: f64,
    /// Parameter across the curve, 0 to 1.
    pub v: f64,
}

impl CurveRay {
    /// Prepares a ray, whose direction may have any length but 0.
    pub fn new(origin: [f32; 3], direction: [f32; 3]) -> Self {
        let direction = Vec3::from(direction).as_dvec3();
        let length = direction.length();
        let z = direction / length;
        let (x, y) = z.any_orthonormal_pair();
        Self { origin: Vec3::from(origin).as_dvec3(), x, y, z, length }
    }

    /// Projects a point along the ray. The origin becomes 0.
    fn project(&self, point: [f32; 3]) -> DVec2 {
        let offset = Vec3::from(point).as_dvec3() - self.origin;
        DVec2::new(offset.dot(self.x), offset.dot(self.y))
    }
}

/// Point of a projected segment with its first and second derivative.
struct ProjectedPoint {
    at: DVec2,
    slope: DVec2,
    bend: DVec2,
}

impl ProjectedPoint {
    /// Evaluates a segment by de Casteljau's algorithm.
    #[inline(always)]
    fn new([a, b, c, d]: &[DVec2; 4], u: f64) -> Self {
        let (ab, bc, cd) = (a.lerp(*b, u), b.lerp(*c, u), c.lerp(*d, u));
        let (p, q) = (ab.lerp(bc, u), bc.lerp(cd, u));
        Self { at: p.lerp(q, u), slope: 3.0 * (q - p), bend: 6.0 * ((cd - bc) - (bc - ab)) }
    }

    /// Returns half the derivative of the squared distance from the ray.
    #[inline(always)]
    fn recession(&self) -> f64 {
        self.at.dot(self.slope)
    }
}

/// Returns the parameter of a nearest point between two parameters, or `None` if the ray passes
/// beyond one of the points there. `slack` is the slack at both ends.
#[inline(always)]
fn nearest(
    points: &[DVec2; 4],
    [mut low, mut high]: [f64; 2],
    [start, end]: [&ProjectedPoint; 2],
    slack: [f64; 2],
) -> Option<f64> {
    if start.recession() > slack[0] || end.recession() < -slack[1] {
        return None;
    }
    let chord = end.at - start.at;
    let share = -start.at.dot(chord) / chord.length_squared();
    // The middle of a chord of length 0, where the share is not a number.
    let share = if (0.0..=1.0).contains(&share) { share } else { 0.5 };
    let mut u = low + (high - low) * share;
    for _ in 0..MAX_STEPS {
        let point = ProjectedPoint::new(points, u);
        let recession = point.recession();
        if recession < 0.0 {
            low = u;
        } else {
            high = u;
        }
        let next = u - recession / (point.slope.length_squared() + point.at.dot(point.bend));
        // Bisects where Newton's step leaves the bracket, or is not a number.
        let inside = low <= next && next <= high;
        let next = if inside { next } else { 0.5 * (low + high) };
        let step = (next - u).abs();
        u = next;
        if step < PRECISION {
            break;
        }
    }
    Some(u)
}

impl CurveSet {
    /// Returns the nearest hit of a ray on a piece, if there is one ahead of the origin.
    #[inline(never)]
    pub fn intersect(&self, piece: CurvePiece, ray: &CurveRay) -> Option<CurveCrossing> {
        let control = &self.segments()[piece.segment as usize].control;
        let points = control.map(|p| ray.project(p));
        let [low, high] = piece.range();
        let (first, last) = (ProjectedPoint::new(&points, low), ProjectedPoint::new(&points, high));
        let size = control.iter().flatten().fold(0.0f32, |most, v| most.max(v.abs()));
        let slack = |is_end: bool, p: &ProjectedPoint| match is_end {
            true => {
                let rounding = f64::from(size) * END_ROUNDING;
                p.at.length() * (p.slope.length() * END_ANGLE + rounding)
            }
            false => 0.0,
        };
        let ends = [slack(piece.part == 0, &first), slack(piece.part + 1 == piece.parts, &last)];
        // Seen almost along itself, a piece may turn far and have several nearest points.
        let (a, b) = (first.slope.length_squared(), last.slope.length_squared());
        let aligned = first.slope.dot(last.slope) > LEAST_ALIGNMENT * (a * b).sqrt();
        let bend = first.bend.length_squared().max(last.bend.length_squared()).sqrt();
        if aligned && a.min(b) > 2.0 * self.half_width(piece.segment) * bend {
            let u = nearest(&points, [low, high], [&first, &last], ends)?;
            return self.crossing(piece.segment, &points, u, ray);
        }
        let mut hit: Option<CurveCrossing> = None;
        let mut start = first;
        for part in 0..PARTS_ALONG {
            let range = [part, part + 1]
                .map(|i| low + (high - low) * f64::from(i) / f64::from(PARTS_ALONG));
            let (is_first, is_last) = (part == 0, part + 1 == PARTS_ALONG);
            let end = ProjectedPoint::new(&points, if is_last { high } else { range[1] });
            let slack = [if is_first { ends[0] } else { 0.0 }, if is_last { ends[1] } else { 0.0 }];
            let found = nearest(&points, range, [&start, &end], slack)
                .and_then(|u| self.crossing(piece.segment, &points, u, ray));
            if let Some(found) = found.filter(|found| hit.is_none_or(|hit| found.t < hit.t)) {
                hit = Some(found);
            }
            start = end;
        }
        hit
    }

    /// Returns half the largest width of a segment.
    #[inline(always)]
    fn half_width(&self, segment: u32) -> f64 {
        let [from, to] = self.segments()[segment as usize].width;
        0.5 * f64::from(from.max(to))
    }

    /// Returns the hit of a ray at the nearest point of a segment, if it is within the width and
    /// ahead of the origin.
    #[inline(always)]
    fn crossing(
        &self,
        segment: u32,
        points: &[DVec2; 4],
        u: f64,
        ray: &CurveRay,
    ) -> Option<CurveCrossing> {
        let CubicPoints { control, width } = &self.segments()[segment as usize];
        let width = f64::from(width[0]) * (1.0 - u) + f64::from(width[1]) * u;
        let width = width * self.facing(segment, u, ray.z);
        let point = ProjectedPoint::new(points, u);
        let distance = point.at.length();
        if distance > 0.5 * width {
            return None;
        }
        let along = |p: [f32; 3]| (Vec3::from(p).as_dvec3() - ray.origin).dot(ray.z);
        let [a, b, c, d] = control.map(along);
        let w = 1.0 - u;
        let z = w * w * (w * a + 3.0 * u * b) + u * u * (3.0 * w * c + u * d);
        // v increases to the right of the tangent, as seen along the ray.
        let right = point.slope.perp_dot(-point.at) > 0.0;
        let offset = if width > 0.0 { distance / width } else { 0.0 };
        let v = if right { 0.5 + offset } else { 0.5 - offset };
        (z > 0.0).then_some(CurveCrossing { t: z / ray.length, u, v })
    }

    /// Returns the share of the width of a segment that is seen along a unit direction.
    #[inline(always)]
    pub(super) fn facing(&self, segment: u32, u: f64, direction: DVec3) -> f64 {
        self.ribbon_normal(segment, u).map_or(1.0, |normal| normal.dot(direction).abs())
    }
}
