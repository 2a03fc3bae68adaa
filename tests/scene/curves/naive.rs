//! Naive twin of curves: a segment is a thousand sampled points. It shares no formula with the
//! program.

use glam::DVec3;
use petzval_scene::{CurveKind, CurveSegment};

use crate::support::Random;

/// Sampled points of a segment.
const STEPS: usize = 1000;

/// A hit on a segment.
#[derive(Clone, Copy, Debug)]
pub struct NaiveHit {
    pub t: f64,
    pub u: f64,
    /// Signed distance from the axis over half the width, to the right of the curve as the ray sees
    /// it.
    pub h: f64,
}

/// Evaluates a segment by Bernstein polynomials.
pub fn point(segment: &CurveSegment, u: f64) -> DVec3 {
    let w = 1.0 - u;
    let [a, b, c, d] = segment.control;
    a * (w * w * w) + b * (3.0 * w * w * u) + c * (3.0 * w * u * u) + d * (u * u * u)
}

/// Returns the derivative of a segment by differences.
pub fn slope(segment: &CurveSegment, u: f64) -> DVec3 {
    (point(segment, u + 1e-5) - point(segment, u - 1e-5)) / 2e-5
}

/// Returns the unit normal of a ribbon at `u`, turned from its start.
fn ribbon_normal([from, to]: [DVec3; 2], u: f64) -> DVec3 {
    let axis = from.cross(to);
    match axis.try_normalize() {
        None => from,
        Some(axis) => {
            let angle = axis.dot(from.cross(to)).atan2(from.dot(to)) * u;
            from * angle.cos() + axis.cross(from) * angle.sin()
        }
    }
}

/// Returns the hits of a ray of unit direction with a segment.
pub fn hits(kind: CurveKind, segment: &CurveSegment, origin: DVec3, along: DVec3) -> Vec<NaiveHit> {
    hits_between(kind, segment, [0.0, 1.0], STEPS, origin, along)
}

/// Returns the hits of a ray of unit direction with a part of a segment, by `steps` points.
pub fn hits_between(
    kind: CurveKind,
    segment: &CurveSegment,
    [low, high]: [f64; 2],
    steps: usize,
    origin: DVec3,
    along: DVec3,
) -> Vec<NaiveHit> {
    // The distance of the sampled point from the ray, before and beyond its perpendicular.
    let ahead = |u: f64| {
        let offset = point(segment, u) - origin;
        let across = offset - along * offset.dot(along);
        across.dot(slope(segment, u))
    };
    let mut found = Vec::new();
    let mut last = ahead(low);
    for step in 0..steps {
        let [start, end] = [step, step + 1].map(|i| low + (high - low) * i as f64 / steps as f64);
        let next = ahead(end);
        if last <= 0.0 && next >= 0.0 {
            let u = start + (end - start) * last / (last - next).min(-1e-300);
            let offset = point(segment, u) - origin;
            let across = offset - along * offset.dot(along);
            let [from, to] = segment.width;
            let mut width = from + u * (to - from);
            if kind == CurveKind::Ribbon {
                let normals = segment.normals.expect("a ribbon");
                width *= ribbon_normal(normals, u).dot(along).abs();
            }
            let right = along.cross(slope(segment, u)).dot(-across).signum();
            let h = right * across.length() / (width / 2.0);
            let t = offset.dot(along);
            if h.abs() <= 1.0 && t > 0.0 {
                found.push(NaiveHit { t, u, h });
            }
        }
        last = next;
    }
    found
}

/// Returns a random point in a cube of side 2.
pub fn in_cube(random: &mut Random) -> DVec3 {
    DVec3::from_array([(); 3].map(|()| 2.0 * random.next() - 1.0))
}

/// Returns a random smooth segment. Its bends are wider than its width.
pub fn smooth_segment(kind: CurveKind, random: &mut Random) -> CurveSegment {
    let (start, along) = (in_cube(random), in_cube(random).normalize());
    let mut bend = || in_cube(random) * 0.25;
    let control =
        [start, start + along / 3.0 + bend(), start + along * (2.0 / 3.0) + bend(), start + along];
    let mut unit = || in_cube(random).normalize();
    let normals = (kind == CurveKind::Ribbon).then(|| [unit(), unit()]);
    // As stored.
    let control = control.map(|p| p.as_vec3().as_dvec3());
    let width = [0.02, 0.06].map(|w: f64| f64::from((w * (0.5 + random.next())) as f32));
    let normals = normals.map(|n| n.map(|n| n.as_vec3().as_dvec3()));
    CurveSegment { control, width, normals }
}
