//! The footprint of a pixel: how far apart its samples meet a surface, over which textures and
//! bumps are averaged.

use glam::Vec3;

use crate::lens::{Camera, Model};
use crate::rays::{Ray, RayDifferential};
use crate::scene::{Patch, SurfacePoint};

/// Samples are taken to be as far apart as 64 in a pixel, which is pbrt-v4's least distance: so
/// a picture does not depend on how its samples are shared out.
const SPACING: f64 = 0.125;

/// The footprint of a pixel as the camera sees it, as a beam from one point: that of the pixel in
/// the middle of the picture. Paths follow it through mirrors and glass (`Side::bounced`). As in
/// pbrt-v4, what they meet after they were scattered is taken to be seen by the camera itself.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Beam {
    /// Where it begins, world space.
    origin: Vec3,
    /// The camera's axis, as long as the camera's unit.
    forward: Vec3,
    /// How the point that a ray comes to moves from sample to sample, at a depth of one camera
    /// unit.
    steps: [Vec3; 2],
}

impl Beam {
    /// The beam of a pixel that is one of `resolution`.
    pub fn new(camera: &Camera, resolution: [u32; 2]) -> Self {
        let (front, distance) = match &camera.model {
            Model::Real(lens) => (lens.front, lens.paraxial.focal_length.abs()),
            Model::Thin(_) => (0.0, 1.0),
        };
        let axes = camera.world_from_camera.matrix3;
        let step = |axis: usize| {
            let pitch = camera.film[axis] / f64::from(resolution[axis]);
            (axes.col(axis) * (pitch / distance * SPACING)).as_vec3()
        };
        Self {
            origin: (camera.world_from_camera.translation + axes.z_axis * front).as_vec3(),
            forward: axes.z_axis.as_vec3(),
            steps: [step(0), step(1)],
        }
    }

    /// The two rays beside that of a sample, where they come to a point.
    pub(super) fn sides(&self, point: Vec3) -> [Side; 2] {
        let to = point - self.origin;
        let depth = to.dot(self.forward) / self.forward.length_squared();
        self.steps.map(|step| {
            let apart = step * depth;
            Side { apart, ahead: to + apart, turned: apart }
        })
    }
}

/// The ray of a sample beside another one, as far along as the point that the other comes to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Side {
    /// Its place relative to that point.
    apart: Vec3,
    /// Its direction, of any length.
    ahead: Vec3,
    /// Its direction less that of the other, which is as long.
    turned: Vec3,
}

/// A smooth surface that a ray leaves.
#[derive(Clone, Copy, Debug)]
pub(super) struct Bounce {
    /// Unit shading normal, on either side.
    pub(super) normal: Vec3,
    /// The direction that it is left in, of unit length.
    pub(super) next: Vec3,
    /// Square of the index beyond the surface over that before it, where the ray goes through.
    pub(super) eta2: f32,
}

impl Side {
    /// The two rays beside one that comes to a surface at `t`; none if they are not known.
    pub(super) fn of(ray: &Ray, t: f32, differential: &RayDifferential) -> Option<[Self; 2]> {
        let side = |axis: usize| {
            let turned = Vec3::from(differential.direction[axis]);
            let apart = Vec3::from(differential.origin[axis]) + turned * t;
            Self { apart, ahead: Vec3::from(ray.direction) + turned, turned }
        };
        (*differential != RayDifferential::UNKNOWN).then(|| [side(0), side(1)])
    }

    /// Its intersection with the tangent plane of the surface, relative to the point; infinite if
    /// there is none.
    fn met(&self, normal: Vec3) -> Vec3 {
        self.apart - self.ahead * (normal.dot(self.apart) / normal.dot(self.ahead))
    }

    /// How texture coordinates change to where it meets the surface: u and v. 0 where it does not.
    pub(super) fn slopes(&self, point: &SurfacePoint, patch: &Patch) -> [f32; 2] {
        let [du, dv] = patch.dp;
        let met = self.met(point.normal);
        // Steps in the plane of the surface by least squares.
        let (uu, uv, vv) = (du.dot(du), du.dot(dv), dv.dot(dv));
        let determinant = uu * vv - uv * uv;
        let (u, v) = (met.dot(du), met.dot(dv));
        [u * vv - v * uv, v * uu - u * uv].map(|slope| {
            let slope = slope / determinant;
            if slope.is_finite() { slope } else { 0.0 }
        })
    }

    /// It leaves the surface as the ray `along` does that it is beside: its origin and its direction
    /// less those of that ray (Igehy 1999, eqs. 14 to 18).
    pub(super) fn bounced(
        &self,
        along: Vec3,
        point: &SurfacePoint,
        patch: &Patch,
        bounce: &Bounce,
    ) -> [Vec3; 2] {
        let Bounce { normal, next, eta2 } = *bounce;
        let [u, v] = self.slopes(point, patch);
        let bent = patch.dn[0] * u + patch.dn[1] * v;
        let cos = along.dot(normal);
        let turned =
            self.ahead.normalize_or_zero() - (self.ahead - self.turned).normalize_or_zero();
        let turned_cos = turned.dot(normal) + along.dot(bent);
        // next = ratio along + normal * share: both of its parts change.
        let (ratio, share, turned_share) = if cos * next.dot(normal) < 0.0 {
            (1.0, -2.0 * cos, -2.0 * turned_cos)
        } else {
            let beyond = next.dot(normal);
            let ratio = 1.0 / eta2.sqrt();
            let turned_beyond = cos * turned_cos / (eta2 * beyond);
            (ratio, beyond - ratio * cos, turned_beyond - ratio * turned_cos)
        };
        [self.met(point.normal), turned * ratio + bent * share + normal * turned_share]
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::*;

    fn beam() -> Beam {
        Beam { origin: Vec3::ZERO, forward: Vec3::Z, steps: [Vec3::X * 0.01, Vec3::Y * 0.02] }
    }

    fn wall(normal: Vec3, dp: [Vec3; 2]) -> (SurfacePoint, Patch) {
        let position = Vec3::Z * 5.0;
        let point = SurfacePoint { position, normal, shading: normal, ..SurfacePoint::default() };
        (point, Patch { uv: Vec2::ZERO, dp, dn: [Vec3::ZERO; 2] })
    }

    fn slopes(point: &SurfacePoint, patch: &Patch) -> [[f32; 2]; 2] {
        beam().sides(point.position).map(|side| side.slopes(point, patch))
    }

    #[test]
    fn steps_grow_with_depth_and_shrink_with_the_size_of_the_texture() {
        let (point, patch) = wall(-Vec3::Z, [Vec3::X * 2.0, Vec3::Y]);
        let [[a, b], [c, d]] = slopes(&point, &patch);
        assert!((a - 0.025).abs() < 1e-7 && b == 0.0 && c == 0.0 && (d - 0.1).abs() < 1e-7);
    }

    #[test]
    fn a_tilted_surface_is_stepped_over_faster() {
        // By 60 degrees about y: twice as fast across, but for perspective.
        let normal = Vec3::new(3f32.sqrt() / 2.0, 0.0, -0.5);
        let across = Vec3::new(0.5, 0.0, 3f32.sqrt() / 2.0);
        // Oblique coordinates, too.
        let (point, patch) = wall(normal, [across, across + Vec3::Y]);
        let [[a, b], [c, d]] = slopes(&point, &patch);
        assert!((a - 0.1).abs() < 0.003 && b.abs() < 1e-6, "{a} {b}");
        assert!((c + 0.1).abs() < 1e-6 && (d - 0.1).abs() < 1e-6, "{c} {d}");
    }

    #[test]
    fn edge_on_and_without_extent_nothing_is_known() {
        let (point, patch) = wall(Vec3::X, [Vec3::ZERO; 2]);
        assert_eq!(slopes(&point, &patch), [[0.0; 2]; 2]);
    }

    #[test]
    fn a_pane_and_a_mirror_leave_the_footprint_as_it_is() {
        // A pane, or a mirror, at 50 degrees at 4, and a wall across the path 3 behind it.
        let normal = Vec3::new(0.766, 0.0, -0.643).normalize();
        let along = Vec3::Z;
        for next in [along, along.reflect(normal)] {
            let position = Vec3::Z * 4.0;
            let pane =
                SurfacePoint { position, normal, shading: normal, ..SurfacePoint::default() };
            let bounce = Bounce { normal, next, eta2: 1.0 };
            let sides = beam().sides(position).map(|side| {
                let [origin, direction] = side.bounced(along, &pane, &Patch::default(), &bounce);
                (origin.to_array(), direction.to_array())
            });
            let differential = RayDifferential {
                origin: sides.map(|(origin, _)| origin),
                direction: sides.map(|(_, direction)| direction),
            };
            let ray = Ray {
                origin: position.to_array(),
                direction: next.to_array(),
                t_max: f32::INFINITY,
            };
            let (dv, position) = (Vec3::Y, position + next * 3.0);
            let wall =
                SurfacePoint { position, normal: -next, shading: -next, ..SurfacePoint::default() };
            let patch = Patch { uv: Vec2::ZERO, dp: [next.cross(dv), dv], dn: [Vec3::ZERO; 2] };
            let [one, other] = Side::of(&ray, 3.0, &differential).expect("it is known");
            let (one, other) = (one.slopes(&wall, &patch), other.slopes(&wall, &patch));
            assert!((one[0].abs() - 0.07).abs() < 1e-3 && one[1].abs() < 1e-3, "{one:?}");
            assert!((other[1] - 0.14).abs() < 1e-3 && other[0].abs() < 1e-3, "{other:?}");
        }
    }

    /// A unit ball that is laid out by position about a point of it: u along x, v along y.
    fn ball(position: Vec3, centre: Vec3) -> (SurfacePoint, Patch) {
        let normal = (position - centre).normalize();
        let (du, dv) = normal.any_orthonormal_pair();
        let point = SurfacePoint { position, normal, shading: normal, ..SurfacePoint::default() };
        (point, Patch { uv: Vec2::ZERO, dp: [du, dv], dn: [du, dv] })
    }

    /// Where a ray leaves a unit ball that it meets from outside, and its direction then: mirrored,
    /// or refracted into an index.
    fn leave(origin: Vec3, along: Vec3, centre: Vec3, eta: Option<f32>) -> [Vec3; 2] {
        let (away, along) = (origin - centre, along.normalize());
        let half = away.dot(along);
        let t = -half - (half * half - away.length_squared() + 1.0).sqrt();
        let position = origin + along * t;
        let normal = (position - centre).normalize();
        let next = match eta {
            None => along.reflect(normal),
            Some(eta) => along.refract(normal, 1.0 / eta),
        };
        [position, next]
    }

    #[test]
    fn rays_beside_one_leave_a_ball_as_they_are_traced() {
        let centre = Vec3::new(0.3, -0.2, 5.0);
        for eta in [None, Some(1.5), Some(0.8)] {
            let along = Vec3::new(0.03, 0.05, 1.0).normalize();
            let [position, next] = leave(Vec3::ZERO, along, centre, eta);
            let (point, patch) = ball(position, centre);
            let beam = Beam { steps: [Vec3::X * 2e-4, Vec3::Y * 3e-4], ..beam() };
            let bounce = Bounce { normal: point.normal, next, eta2: eta.map_or(1.0, |n| n * n) };
            for (side, step) in beam.sides(position).into_iter().zip(beam.steps) {
                let beside = along / along.z + step;
                let [p, d] = leave(Vec3::ZERO, beside, centre, eta);
                let [origin, direction] = side.bounced(along, &point, &patch, &bounce);
                for (found, expected) in [(origin, p - position), (direction, d - next)] {
                    // Differences of differentials are of second order.
                    let off = (found - expected).length() / expected.length();
                    assert!(off < 0.01, "{eta:?}: {found}, not {expected}");
                }
            }
        }
    }
}
