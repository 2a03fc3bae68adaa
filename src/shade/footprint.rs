//! How far the samples of a pixel lie apart on a surface: what textures and bumps are averaged
//! over.

use glam::Vec3;

use crate::lens::{Camera, Model};
use crate::scene::{Patch, SurfacePoint};

/// Samples are taken to be as far apart as 64 in a pixel, which is pbrt-v4's least distance: so
/// a picture does not depend on how its samples are shared out.
const SPACING: f64 = 0.125;

/// What a pixel sees in the middle of the picture, as a beam from one point. Other pixels and
/// surfaces that are seen in mirrors are treated alike, as in pbrt-v4.
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

    /// How texture coordinates change from sample to sample: u and v, for a step to the side and
    /// one up. 0 where a step leaves the surface.
    pub(super) fn on(&self, point: &SurfacePoint, patch: &Patch) -> [[f32; 2]; 2] {
        let [du, dv] = patch.dp;
        // Steps in the plane of the surface by least squares.
        let (uu, uv, vv) = (du.dot(du), du.dot(dv), dv.dot(dv));
        let determinant = uu * vv - uv * uv;
        let to = point.position - self.origin;
        let depth = to.dot(self.forward) / self.forward.length_squared();
        self.steps.map(|step| {
            let other = to + step * depth;
            let moved = other * (point.normal.dot(to) / point.normal.dot(other)) - to;
            let (u, v) = (moved.dot(du), moved.dot(dv));
            [u * vv - v * uv, v * uu - u * uv].map(|slope| {
                let slope = slope / determinant;
                if slope.is_finite() { slope } else { 0.0 }
            })
        })
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

    #[test]
    fn steps_grow_with_depth_and_shrink_with_the_size_of_the_texture() {
        let (point, patch) = wall(-Vec3::Z, [Vec3::X * 2.0, Vec3::Y]);
        let [[a, b], [c, d]] = beam().on(&point, &patch);
        assert!((a - 0.025).abs() < 1e-7 && b == 0.0 && c == 0.0 && (d - 0.1).abs() < 1e-7);
    }

    #[test]
    fn a_tilted_surface_is_stepped_over_faster() {
        // By 60 degrees about y: twice as fast across, but for perspective.
        let normal = Vec3::new(3f32.sqrt() / 2.0, 0.0, -0.5);
        let across = Vec3::new(0.5, 0.0, 3f32.sqrt() / 2.0);
        // Oblique coordinates, too.
        let (point, patch) = wall(normal, [across, across + Vec3::Y]);
        let [[a, b], [c, d]] = beam().on(&point, &patch);
        assert!((a - 0.1).abs() < 0.003 && b.abs() < 1e-6, "{a} {b}");
        assert!((c + 0.1).abs() < 1e-6 && (d - 0.1).abs() < 1e-6, "{c} {d}");
    }

    #[test]
    fn edge_on_and_without_extent_nothing_is_known() {
        let (point, patch) = wall(Vec3::X, [Vec3::ZERO; 2]);
        assert_eq!(beam().on(&point, &patch), [[0.0; 2]; 2]);
    }
}
