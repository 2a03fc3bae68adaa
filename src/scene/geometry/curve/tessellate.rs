//! Tessellation of curves that emit light.
//!
//! A round or flat curve becomes a tube of six sides with the circumference of a round tube, so
//! that its mean width over all directions is right (Cauchy 1832). A ribbon becomes a strip
//! perpendicular to its normals.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::slerp;
use crate::geometry::Mesh;

/// Number of sides of a tube.
const SIDES: u32 = 6;
/// Largest distance between a chord and the curve, relative to the width.
const TOLERANCE: f64 = 0.05;
/// Most chords of a segment.
const MAX_CHORDS: u32 = 16;

/// One cubic segment of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveSegment {
    /// Bezier control points.
    pub control: [DVec3; 4],
    /// Widths at its ends.
    pub width: [f64; 2],
    /// Unit normals at the ends of a ribbon; `None` for a round or flat curve.
    pub normals: Option<[DVec3; 2]>,
}

impl CurveSegment {
    fn point(&self, u: f64) -> DVec3 {
        let [a, b, c, d] = self.control;
        let (ab, bc, cd) = (a.lerp(b, u), b.lerp(c, u), c.lerp(d, u));
        ab.lerp(bc, u).lerp(bc.lerp(cd, u), u)
    }

    /// Returns the unit tangent, or the direction of the chord if the derivative is 0.
    fn tangent(&self, u: f64) -> DVec3 {
        let [a, b, c, d] = self.control;
        let slope = (b - a).lerp(c - b, u).lerp((c - b).lerp(d - c, u), u);
        slope.try_normalize().or((d - a).try_normalize()).unwrap_or(DVec3::Z)
    }

    /// Returns the number of chords that keeps the distance to the curve within the tolerance (Wang
    /// 1984).
    fn chords(&self) -> u32 {
        let [a, b, c, d] = self.control;
        let bend = (a - 2.0 * b + c).length().max((b - 2.0 * c + d).length());
        let allowed = TOLERANCE * self.width[0].max(self.width[1]);
        ((0.75 * bend / allowed).sqrt().ceil() as u32).clamp(1, MAX_CHORDS)
    }

    /// Returns the number of vertices around one point of the curve.
    fn ring_vertices(&self) -> u32 {
        if self.normals.is_some() { 2 } else { SIDES + 1 }
    }

    /// Returns whether its points and widths are finite numbers.
    pub fn is_finite(&self) -> bool {
        self.control.iter().all(|p| p.is_finite()) && self.width.iter().all(|w| w.is_finite())
    }

    /// Returns the numbers of vertices and triangles of the tessellation.
    pub fn counts(&self) -> [u64; 2] {
        let [chords, corners] = [self.chords(), self.ring_vertices()].map(u64::from);
        [(chords + 1) * corners, 2 * chords * (corners - 1)]
    }
}

/// Tessellates the segments of a curve into one mesh. u runs along each segment, and v across or
/// around it.
pub fn tessellate_curve(segments: &[CurveSegment]) -> Mesh {
    let mut mesh = Mesh::default();
    let mut side = None;
    for segment in segments {
        let (chords, corners) = (segment.chords(), segment.ring_vertices());
        let first = mesh.positions.len() as u32;
        for i in 0..=chords {
            let u = f64::from(i) / f64::from(chords);
            let tangent = segment.tangent(u);
            // The side vector of the last point, with the least rotation.
            let last: Option<DVec3> = side;
            let across = last
                .and_then(|side| (side - tangent * side.dot(tangent)).try_normalize())
                .unwrap_or_else(|| tangent.any_orthonormal_vector());
            side = Some(across);
            segment.add_ring(u, tangent, across, &mut mesh);
        }
        for row in 0..chords {
            for column in 0..corners - 1 {
                let a = first + row * corners + column;
                let c = a + corners;
                mesh.triangles.extend([[a, c, c + 1], [c + 1, a + 1, a]]);
            }
        }
    }
    mesh
}

impl CurveSegment {
    /// Adds the vertices around one point of the curve.
    fn add_ring(&self, u: f64, tangent: DVec3, across: DVec3, mesh: &mut Mesh) {
        let point = self.point(u);
        let width = self.width[0] + u * (self.width[1] - self.width[0]);
        let mut add = |offset: DVec3, normal: DVec3, v: f64| {
            mesh.positions.push((point + offset).as_vec3().to_array());
            mesh.normals.push(normal.as_vec3().to_array());
            mesh.uvs.push([u as f32, v as f32]);
        };
        if let Some([from, to]) = self.normals {
            let facing = slerp(from, to, u);
            let across = facing.cross(tangent).try_normalize().unwrap_or(across);
            let normal = tangent.cross(across);
            add(across * (-width / 2.0), normal, 0.0);
            add(across * (width / 2.0), normal, 1.0);
            return;
        }
        let radius = PI * width / (2.0 * f64::from(SIDES) * (PI / f64::from(SIDES)).sin());
        let up = tangent.cross(across);
        for i in 0..=SIDES {
            let v = f64::from(i) / f64::from(SIDES);
            let (sin, cos) = (-TAU * v).sin_cos();
            let normal = across * cos + up * sin;
            add(normal * radius, normal, v);
        }
    }
}
