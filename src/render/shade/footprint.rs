//! Footprint of a pixel on a surface: the distance between its samples, over which textures and
//! bump maps are filtered.

use glam::{Mat3, UVec2, Vec2, Vec3};

use super::neighbour_ray::NeighbourRay;
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{add, dot, scale, splat, sub};
use petzval_lens::{Camera, LensModel, SphericalMapping};

/// Distance between samples (pixels). It is that of 64 samples in a pixel, pbrt-v4's smallest,
/// whatever the number of samples: a picture must not depend on how its samples are divided among
/// renders.
const SPACING: f64 = 0.125;

/// Footprint of a pixel as the camera sees it. For a lens it is a beam from one point, that of the
/// pixel in the middle of the picture.
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
    /// world space; at any depth if rays are parallel.
    steps: [Vec3; 2],
    projection: BeamProjection,
}

/// Beams of the pixels of a camera.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum BeamProjection {
    /// Beams from one point, as wide as that in the middle of the picture.
    #[default]
    Central,
    /// Parallel beams.
    Parallel,
    /// Beams from one point, whose widths depend on the direction.
    Sphere {
        mapping: SphericalMapping,
        /// Distance between samples, as a share of the picture.
        spacing: Vec2,
        world_from_camera: Mat3,
        camera_from_world: Mat3,
    },
}

impl PixelFootprint {
    /// The footprint of a pixel in a picture of this resolution.
    pub fn new(camera: &Camera, resolution: [u32; 2]) -> Self {
        let (front, distance) = match &camera.model {
            LensModel::Real(lens) => (lens.front_depth, lens.paraxial.focal_length.abs()),
            _ => (0.0, 1.0),
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
            projection: match &camera.model {
                LensModel::Real(_) | LensModel::Thin(_) => BeamProjection::Central,
                LensModel::Orthographic(_) => BeamProjection::Parallel,
                LensModel::Spherical(mapping) => BeamProjection::Sphere {
                    mapping: *mapping,
                    spacing: SPACING as f32 / UVec2::from(resolution).as_vec2(),
                    world_from_camera: axes.as_mat3(),
                    camera_from_world: axes.inverse().as_mat3(),
                },
            },
        }
    }

    /// Returns the rays of the two neighbouring samples, given the points that rays hit.
    #[inline(always)]
    pub(super) fn neighbour_rays<R: Real<Scalar = f32>>(
        &self,
        points: [R; 3],
    ) -> [NeighbourRay<R>; 2] {
        let forward = splat(self.forward.to_array());
        let to = sub(points, splat(self.origin.to_array()));
        let depth = dot(to, forward) / R::splat(self.forward.length_squared());
        match &self.projection {
            BeamProjection::Central => self.steps.map(|step| {
                let offset = scale(splat(step.to_array()), depth);
                NeighbourRay { offset, direction: add(to, offset), direction_change: offset }
            }),
            BeamProjection::Parallel => self.steps.map(|step| NeighbourRay {
                offset: splat(step.to_array()),
                direction: forward,
                direction_change: [R::splat(0.0); 3],
            }),
            BeamProjection::Sphere { .. } => self.sphere_offsets(to).map(|offset| NeighbourRay {
                offset,
                direction: add(to, offset),
                direction_change: offset,
            }),
        }
    }

    /// Returns the offsets to the rays of the two neighbouring samples of a spherical camera, given
    /// the vectors from the camera to the points that rays hit. Lanes are computed one by one.
    #[inline(never)]
    fn sphere_offsets<R: Real<Scalar = f32>>(&self, to: [R; 3]) -> [[R; 3]; 2] {
        let (mut vectors, mut offsets) = ([[0.0; 8]; 3], [[[0.0; 8]; 3]; 2]);
        for axis in 0..3 {
            to[axis].store(&mut vectors[axis]);
        }
        if let BeamProjection::Sphere { mapping, spacing, world_from_camera, camera_from_world } =
            self.projection
        {
            for lane in 0..R::LANES {
                let local = camera_from_world * Vec3::from(vectors.map(|axis| axis[lane]));
                let distance = local.length();
                let changes = mapping.neighbours(local.normalize_or(Vec3::Z), spacing);
                for (offset, change) in offsets.iter_mut().zip(changes) {
                    let change = world_from_camera * (change * distance);
                    for axis in 0..3 {
                        offset[axis][lane] = change[axis];
                    }
                }
            }
        }
        offsets.map(|offset| offset.map(|axis| R::load(&axis)))
    }
}

#[cfg(test)]
mod tests {
    use glam::{Vec2, Vec3};

    use super::super::neighbour_ray::SpecularBounce;
    use super::*;
    use petzval_base::rays::{Ray, RayDifferential};
    use petzval_scene::{
        SurfaceDerivatives, SurfaceDerivativesPacket, SurfacePacket, SurfacePoint,
    };

    type Point = SurfacePacket<f32>;
    type Derivatives = SurfaceDerivativesPacket<f32>;

    fn footprint() -> PixelFootprint {
        PixelFootprint {
            origin: Vec3::ZERO,
            forward: Vec3::Z,
            steps: [Vec3::X * 0.01, Vec3::Y * 0.02],
            ..PixelFootprint::default()
        }
    }

    fn wall(normal: Vec3, dp: [Vec3; 2]) -> (Point, Derivatives) {
        let position = Vec3::Z * 5.0;
        let point =
            SurfacePoint { position, normal, shading_normal: normal, ..SurfacePoint::default() };
        (point.into(), SurfaceDerivatives { uv: Vec2::ZERO, dp, dn: [Vec3::ZERO; 2] }.into())
    }

    fn texture_steps(point: &Point, patch: &Derivatives) -> [[f32; 2]; 2] {
        let neighbours = footprint().neighbour_rays(point.position);
        neighbours.map(|neighbour| neighbour.texture_step(point.normal, &patch.dp))
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
    fn the_footprint_of_parallel_rays_is_the_same_at_every_depth() {
        let parallel = PixelFootprint { projection: BeamProjection::Parallel, ..footprint() };
        for depth in [1.0f32, 50.0] {
            let [one, other] = parallel.neighbour_rays([3.0, 2.0, depth]);
            let dp = [[2.0f32, 0.0, 0.0], [0.0, 1.0, 0.0]];
            assert_eq!(one.texture_step([0.0, 0.0, -1.0], &dp), [0.005, 0.0]);
            assert_eq!(other.texture_step([0.0, 0.0, -1.0], &dp), [0.0, 0.02]);
        }
    }

    #[test]
    fn the_footprint_of_a_spherical_camera_is_that_of_its_angles() {
        let turn = Mat3::from_rotation_z(std::f32::consts::FRAC_PI_2);
        let sphere = PixelFootprint {
            projection: BeamProjection::Sphere {
                mapping: SphericalMapping::Equirectangular,
                spacing: Vec2::new(1e-3, 3e-3),
                world_from_camera: turn,
                camera_from_world: turn.transpose(),
            },
            ..footprint()
        };
        // Straight ahead, the steps along the camera's x and y axes are 5 times the angles.
        let (point, patch) = wall(-Vec3::Z, [Vec3::X, Vec3::Y]);
        let [one, other] = sphere.neighbour_rays(point.position);
        let [one, other] =
            [one, other].map(|neighbour| neighbour.texture_step(point.normal, &patch.dp));
        let pi = std::f32::consts::PI;
        assert!(one[0].abs() < 1e-6 && (one[1].abs() - 0.01 * pi).abs() < 1e-6, "{one:?}");
        assert!((other[0].abs() - 0.015 * pi).abs() < 1e-6 && other[1].abs() < 1e-6, "{other:?}");
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
            let (pane, flat) = (pane.into(), SurfaceDerivatives::default().into());
            let bounce = SpecularBounce { normal, next, eta2: 1.0 };
            let sides = footprint().neighbour_rays(position.to_array()).map(|neighbour| {
                let [origin, direction] = neighbour.after_bounce(along, &pane, &flat, &bounce);
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
            let dp = [next.cross(Vec3::Y).to_array(), Vec3::Y.to_array()];
            let [one, other] = NeighbourRay::transferred(&ray, 3.0, &differential)
                .expect("the differential is known");
            let (one, other) =
                (one.texture_step((-next).into(), &dp), other.texture_step((-next).into(), &dp));
            assert!((one[0].abs() - 0.07).abs() < 1e-3 && one[1].abs() < 1e-3, "{one:?}");
            assert!((other[1] - 0.14).abs() < 1e-3 && other[0].abs() < 1e-3, "{other:?}");
        }
    }

    /// A point of a unit ball, and derivatives by coordinates u and v that are lengths on its
    /// tangent plane.
    fn ball(position: Vec3, centre: Vec3) -> (Point, Derivatives) {
        let normal = (position - centre).normalize();
        let (du, dv) = normal.any_orthonormal_pair();
        let point =
            SurfacePoint { position, normal, shading_normal: normal, ..SurfacePoint::default() };
        (point.into(), SurfaceDerivatives { uv: Vec2::ZERO, dp: [du, dv], dn: [du, dv] }.into())
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
            let bounce = SpecularBounce {
                normal: point.normal.into(),
                next,
                eta2: eta.map_or(1.0, |n| n * n),
            };
            for (neighbour, step) in
                footprint.neighbour_rays(position.to_array()).into_iter().zip(steps)
            {
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
