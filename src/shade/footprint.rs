//! Footprint of a pixel on a surface: the distance between its samples, over which textures and
//! bump maps are filtered.

use glam::Vec3;

use crate::lens::{Camera, LensModel};
use crate::rays::{Ray, RayDifferential};
use crate::scene::{SurfaceDerivatives, SurfacePoint};

/// Distance between samples (pixels). It is that of 64 samples in a pixel, pbrt-v4's smallest,
/// whatever the number of samples: a picture must not depend on how its samples are divided among
/// renders.
const SPACING: f64 = 0.125;

/// Footprint of a pixel as the camera sees it: a beam from one point, that of the pixel in the
/// middle of the picture.
///
/// Ray differentials carry it through specular reflection and refraction
/// (`NeighbourRay::after_bounce`). As in pbrt-v4, surfaces that a path meets after scattering
/// have the footprint that the camera would see.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PixelFootprint {
    /// Origin of the beam, world space.
    origin: Vec3,
    /// Axis of the camera, with the length of a camera unit, world space.
    forward: Vec3,
    /// Steps from sample to sample along x and y of the picture, at a depth of one camera unit,
    /// world space.
    steps: [Vec3; 2],
}

impl PixelFootprint {
    /// The footprint of a pixel in a picture of this resolution.
    pub fn new(camera: &Camera, resolution: [u32; 2]) -> Self {
        let (front, distance) = match &camera.model {
            LensModel::Real(lens) => (lens.front_depth, lens.paraxial.focal_length.abs()),
            LensModel::Thin(_) => (0.0, 1.0),
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

    /// Returns the rays of the two neighbouring samples, given the point that a sample's ray hits.
    pub(super) fn neighbour_rays(&self, point: Vec3) -> [NeighbourRay; 2] {
        let to = point - self.origin;
        let depth = to.dot(self.forward) / self.forward.length_squared();
        self.steps.map(|step| {
            let offset = step * depth;
            NeighbourRay { offset, direction: to + offset, direction_change: offset }
        })
    }
}

/// Ray of a neighbouring sample, at the distance at which a sample's own ray hits a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct NeighbourRay {
    /// Position relative to the own ray's hit point.
    offset: Vec3,
    /// Direction, of any length.
    direction: Vec3,
    /// Direction minus that of the own ray, at the same length.
    direction_change: Vec3,
}

/// Specular reflection or refraction of a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpecularBounce {
    /// Unit shading normal, on either side of the surface.
    pub(super) normal: Vec3,
    /// Unit direction after the surface.
    pub(super) next: Vec3,
    /// Squared refractive index beyond the surface over that before it, for refraction.
    pub(super) eta2: f32,
}

impl NeighbourRay {
    /// Returns the neighbours of a ray that hits a surface at `t`, or `None` if its differential is
    /// unknown.
    pub(super) fn transferred(
        ray: &Ray,
        t: f32,
        differential: &RayDifferential,
    ) -> Option<[Self; 2]> {
        let neighbour = |axis: usize| {
            let direction_change = Vec3::from(differential.direction[axis]);
            let offset = Vec3::from(differential.origin[axis]) + direction_change * t;
            let direction = Vec3::from(ray.direction) + direction_change;
            Self { offset, direction, direction_change }
        };
        (*differential != RayDifferential::UNKNOWN).then(|| [neighbour(0), neighbour(1)])
    }

    /// Returns the intersection with the tangent plane of the surface, relative to the own ray's
    /// hit point; infinite if there is none.
    fn tangent_plane_offset(&self, normal: Vec3) -> Vec3 {
        self.offset - self.direction * (normal.dot(self.offset) / normal.dot(self.direction))
    }

    /// Returns the change of (u, v) from the own ray's hit point to this ray's; 0 if it misses the
    /// tangent plane.
    pub(super) fn texture_step(
        &self,
        point: &SurfacePoint,
        patch: &SurfaceDerivatives,
    ) -> [f32; 2] {
        let [du, dv] = patch.dp;
        let offset = self.tangent_plane_offset(point.normal);
        // Least squares in the plane of the surface.
        let (uu, uv, vv) = (du.dot(du), du.dot(dv), dv.dot(dv));
        let determinant = uu * vv - uv * uv;
        let (u, v) = (offset.dot(du), offset.dot(dv));
        [u * vv - v * uv, v * uu - u * uv].map(|slope| {
            let slope = slope / determinant;
            if slope.is_finite() { slope } else { 0.0 }
        })
    }

    /// Returns the origin and direction of this ray after a specular bounce, minus those of the own
    /// ray, whose direction before the bounce is `along` (Igehy 1999, eqs. 14 to 18).
    pub(super) fn after_bounce(
        &self,
        along: Vec3,
        point: &SurfacePoint,
        patch: &SurfaceDerivatives,
        bounce: &SpecularBounce,
    ) -> [Vec3; 2] {
        let SpecularBounce { normal, next, eta2 } = *bounce;
        let [u, v] = self.texture_step(point, patch);
        let normal_change = patch.dn[0] * u + patch.dn[1] * v;
        let cos = along.dot(normal);
        let change = self.direction.normalize_or_zero()
            - (self.direction - self.direction_change).normalize_or_zero();
        let cos_change = change.dot(normal) + along.dot(normal_change);
        // next = ratio * along + share * normal; ratio is constant, all else changes.
        let (ratio, share, share_change) = if cos * next.dot(normal) < 0.0 {
            (1.0, -2.0 * cos, -2.0 * cos_change)
        } else {
            let cos_next = next.dot(normal);
            let ratio = 1.0 / eta2.sqrt();
            let cos_next_change = cos * cos_change / (eta2 * cos_next);
            (ratio, cos_next - ratio * cos, cos_next_change - ratio * cos_change)
        };
        [
            self.tangent_plane_offset(point.normal),
            change * ratio + normal_change * share + normal * share_change,
        ]
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::*;

    fn footprint() -> PixelFootprint {
        PixelFootprint {
            origin: Vec3::ZERO,
            forward: Vec3::Z,
            steps: [Vec3::X * 0.01, Vec3::Y * 0.02],
        }
    }

    fn wall(normal: Vec3, dp: [Vec3; 2]) -> (SurfacePoint, SurfaceDerivatives) {
        let position = Vec3::Z * 5.0;
        let point =
            SurfacePoint { position, normal, shading_normal: normal, ..SurfacePoint::default() };
        (point, SurfaceDerivatives { uv: Vec2::ZERO, dp, dn: [Vec3::ZERO; 2] })
    }

    fn texture_steps(point: &SurfacePoint, patch: &SurfaceDerivatives) -> [[f32; 2]; 2] {
        let neighbours = footprint().neighbour_rays(point.position);
        neighbours.map(|neighbour| neighbour.texture_step(point, patch))
    }

    #[test]
    fn texture_steps_grow_with_depth_and_shrink_with_the_size_of_the_texture() {
        let (point, patch) = wall(-Vec3::Z, [Vec3::X * 2.0, Vec3::Y]);
        let [[a, b], [c, d]] = texture_steps(&point, &patch);
        assert!((a - 0.025).abs() < 1e-7 && b == 0.0 && c == 0.0 && (d - 0.1).abs() < 1e-7);
    }

    #[test]
    fn texture_steps_grow_on_a_tilted_surface() {
        // Tilted by 60 degrees about y: steps across are twice as long, except for perspective.
        let normal = Vec3::new(3f32.sqrt() / 2.0, 0.0, -0.5);
        let across = Vec3::new(0.5, 0.0, 3f32.sqrt() / 2.0);
        // The coordinates are oblique as well.
        let (point, patch) = wall(normal, [across, across + Vec3::Y]);
        let [[a, b], [c, d]] = texture_steps(&point, &patch);
        assert!((a - 0.1).abs() < 0.003 && b.abs() < 1e-6, "{a} {b}");
        assert!((c + 0.1).abs() < 1e-6 && (d - 0.1).abs() < 1e-6, "{c} {d}");
    }

    #[test]
    fn texture_steps_are_zero_edge_on_and_without_extent() {
        let (point, patch) = wall(Vec3::X, [Vec3::ZERO; 2]);
        assert_eq!(texture_steps(&point, &patch), [[0.0; 2]; 2]);
    }

    #[test]
    fn a_flat_pane_and_a_flat_mirror_preserve_the_footprint() {
        // A pane or a mirror, tilted by 50 degrees, at a distance of 4, and a wall across the path
        // 3 behind it.
        let normal = Vec3::new(0.766, 0.0, -0.643).normalize();
        let along = Vec3::Z;
        for next in [along, along.reflect(normal)] {
            let position = Vec3::Z * 4.0;
            let pane = SurfacePoint {
                position,
                normal,
                shading_normal: normal,
                ..SurfacePoint::default()
            };
            let bounce = SpecularBounce { normal, next, eta2: 1.0 };
            let sides = footprint().neighbour_rays(position).map(|neighbour| {
                let [origin, direction] =
                    neighbour.after_bounce(along, &pane, &SurfaceDerivatives::default(), &bounce);
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
            let wall = SurfacePoint {
                position,
                normal: -next,
                shading_normal: -next,
                ..SurfacePoint::default()
            };
            let patch = SurfaceDerivatives {
                uv: Vec2::ZERO,
                dp: [next.cross(dv), dv],
                dn: [Vec3::ZERO; 2],
            };
            let [one, other] = NeighbourRay::transferred(&ray, 3.0, &differential)
                .expect("the differential is known");
            let (one, other) = (one.texture_step(&wall, &patch), other.texture_step(&wall, &patch));
            assert!((one[0].abs() - 0.07).abs() < 1e-3 && one[1].abs() < 1e-3, "{one:?}");
            assert!((other[1] - 0.14).abs() < 1e-3 && other[0].abs() < 1e-3, "{other:?}");
        }
    }

    /// A point of a unit ball, and derivatives by coordinates u and v that are lengths on its
    /// tangent plane.
    fn ball(position: Vec3, centre: Vec3) -> (SurfacePoint, SurfaceDerivatives) {
        let normal = (position - centre).normalize();
        let (du, dv) = normal.any_orthonormal_pair();
        let point =
            SurfacePoint { position, normal, shading_normal: normal, ..SurfacePoint::default() };
        (point, SurfaceDerivatives { uv: Vec2::ZERO, dp: [du, dv], dn: [du, dv] })
    }

    /// Returns the point at which a ray from outside hits a unit ball, and its direction
    /// afterwards: reflected, or refracted into the index `eta`.
    fn bounce_off_ball(origin: Vec3, along: Vec3, centre: Vec3, eta: Option<f32>) -> [Vec3; 2] {
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
    fn differentials_after_a_ball_agree_with_traced_rays() {
        let centre = Vec3::new(0.3, -0.2, 5.0);
        for eta in [None, Some(1.5), Some(0.8)] {
            let along = Vec3::new(0.03, 0.05, 1.0).normalize();
            let [position, next] = bounce_off_ball(Vec3::ZERO, along, centre, eta);
            let (point, patch) = ball(position, centre);
            let steps = [Vec3::X * 2e-4, Vec3::Y * 3e-4];
            let footprint = PixelFootprint { steps, ..footprint() };
            let bounce =
                SpecularBounce { normal: point.normal, next, eta2: eta.map_or(1.0, |n| n * n) };
            for (neighbour, step) in footprint.neighbour_rays(position).into_iter().zip(steps) {
                let beside = along / along.z + step;
                let [p, d] = bounce_off_ball(Vec3::ZERO, beside, centre, eta);
                let [origin, direction] = neighbour.after_bounce(along, &point, &patch, &bounce);
                for (found, expected) in [(origin, p - position), (direction, d - next)] {
                    // The finite difference has an error of second order.
                    let off = (found - expected).length() / expected.length();
                    assert!(off < 0.01, "{eta:?}: {found}, not {expected}");
                }
            }
        }
    }
}
