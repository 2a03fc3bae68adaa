//! Curves with a width, such as hairs and blades of grass, as triangles.
//!
//! A round or flat curve becomes a tube of six sides whose circumference is that of a round
//! one: seen from all sides its mean width is right as well (Cauchy 1832). A ribbon becomes a
//! strip about its normals.

use std::f64::consts::{PI, TAU};

use glam::DVec3;

use super::mesh::Mesh;

/// Sides of a tube.
const SIDES: u32 = 6;
/// How far a chord may be from its curve, in widths.
const TOLERANCE: f64 = 0.05;
/// Most chords of a segment.
const MOST_CHORDS: u32 = 16;

/// One cubic piece of a curve.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CurveSegment {
    /// Control points of Bezier and Bernstein.
    pub control: [DVec3; 4],
    /// Widths at its ends.
    pub width: [f64; 2],
    /// For a ribbon the directions that it faces at its ends.
    pub facing: Option<[DVec3; 2]>,
}

impl CurveSegment {
    fn point(&self, u: f64) -> DVec3 {
        let [a, b, c, d] = self.control;
        let (ab, bc, cd) = (a.lerp(b, u), b.lerp(c, u), c.lerp(d, u));
        ab.lerp(bc, u).lerp(bc.lerp(cd, u), u)
    }

    /// The direction of the curve. Where the derivative is zero, that of the chord.
    fn tangent(&self, u: f64) -> DVec3 {
        let [a, b, c, d] = self.control;
        let slope = (b - a).lerp(c - b, u).lerp((c - b).lerp(d - c, u), u);
        slope.try_normalize().or((d - a).try_normalize()).unwrap_or(DVec3::Z)
    }

    /// How many chords follow it closely enough (Wang 1984).
    fn chords(&self) -> u32 {
        let [a, b, c, d] = self.control;
        let bend = (a - 2.0 * b + c).length().max((b - 2.0 * c + d).length());
        let allowed = TOLERANCE * self.width[0].max(self.width[1]);
        ((0.75 * bend / allowed).sqrt().ceil() as u32).clamp(1, MOST_CHORDS)
    }
}

impl CurveSegment {
    /// Vertices at one point of the curve.
    fn corners(&self) -> u32 {
        if self.facing.is_some() { 2 } else { SIDES + 1 }
    }

    /// How many vertices and triangles it becomes.
    pub fn counts(&self) -> [u64; 2] {
        let [chords, corners] = [self.chords(), self.corners()].map(u64::from);
        [(chords + 1) * corners, 2 * chords * (corners - 1)]
    }
}

/// The segments of a curve as one mesh. u runs along each segment and v across it, or around.
pub fn tessellate(segments: &[CurveSegment]) -> Mesh {
    let mut mesh = Mesh::default();
    let mut side = None;
    for segment in segments {
        let (chords, corners) = (segment.chords(), segment.corners());
        let first = mesh.positions.len() as u32;
        for i in 0..=chords {
            let u = f64::from(i) / f64::from(chords);
            let tangent = segment.tangent(u);
            // Carried along with as little turning as can be.
            let carried: Option<DVec3> = side;
            let across = carried
                .and_then(|side| (side - tangent * side.dot(tangent)).try_normalize())
                .unwrap_or_else(|| tangent.any_orthonormal_vector());
            side = Some(across);
            segment.row(u, tangent, across, &mut mesh);
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
    /// Adds the vertices at one point of the curve.
    fn row(&self, u: f64, tangent: DVec3, across: DVec3, mesh: &mut Mesh) {
        let point = self.point(u);
        let width = self.width[0] + u * (self.width[1] - self.width[0]);
        let mut add = |offset: DVec3, normal: DVec3, v: f64| {
            mesh.positions.push((point + offset).as_vec3().to_array());
            mesh.normals.push(normal.as_vec3().to_array());
            mesh.uvs.push([u as f32, v as f32]);
        };
        if let Some([from, to]) = self.facing {
            let facing = turned(from, to, u);
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

/// A direction a share of the way from one to another, at an even rate of turn (Shoemake 1985).
fn turned(from: DVec3, to: DVec3, share: f64) -> DVec3 {
    let angle = from.angle_between(to);
    let sin = angle.sin();
    if sin < 1e-6 {
        return from.lerp(to, share);
    }
    (from * ((1.0 - share) * angle).sin() + to * (share * angle).sin()) / sin
}
