//! Sampling of points on area lights, and its density.

use glam::{Vec2, Vec3};

use super::spherical_triangle::SphericalTriangle;
use super::visible_cap::{SpherePacket, VisibleCap};
use super::{AreaLight, LightSample};
use crate::geometry::{DiskPacket, ShadingTriangle};
use crate::{Geometry, Quadric, Shape, SurfacePacket, SurfacePoint};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{cross, dot, sub};
use petzval_base::rays::Hit;

/// Sampled points of emitters, and the densities with which they are sampled.
pub(super) struct EmitterPoints<R: Real> {
    point: SurfacePacket<R>,
    density: R,
    /// Lanes whose density is by solid angle; the others' is by area.
    by_solid_angle: R::Mask,
    /// Lanes that have a sample.
    pub(super) valid: R::Mask,
}

/// Directions to sampled points of emitters.
pub(super) struct AreaSamples<R: Real> {
    /// Vector from the origin of the shadow ray to the point.
    pub(super) direction: [R; 3],
    /// Density (1/sr), without the probability of the emitter.
    pub(super) density: R,
    /// Lanes that can contribute.
    pub(super) usable: R::Mask,
}

impl<R: Real<Scalar = f32>> EmitterPoints<R> {
    /// Samples points of triangles. Returns also their barycentric weights.
    #[inline(always)]
    pub(super) fn on_triangle(
        triangle: &ShadingTriangle<R>,
        from: [R; 3],
        u: [R; 2],
    ) -> (Self, [R; 2]) {
        let seen = SphericalTriangle::new(&triangle.positions, from);
        let (by_angle, by_area) = (seen.sample(u), by_area(u));
        let mask = seen.by_solid_angle;
        let [b, c] =
            [R::select(mask, by_angle[0], by_area[0]), R::select(mask, by_angle[1], by_area[1])];
        let point = triangle.point(b, c);
        let density = triangle_density(triangle, &seen);
        (Self { point, density, by_solid_angle: mask, valid: b.equals(b) & c.equals(c) }, [b, c])
    }

    /// Samples points of disks.
    #[inline(always)]
    pub(super) fn on_disk(disk: &DiskPacket<R>, u: [R; 2]) -> Self {
        let zero = R::splat(0.0);
        Self {
            point: disk.sample(u),
            density: disk.density,
            by_solid_angle: zero.lt(zero),
            valid: zero.le(zero),
        }
    }

    /// Samples points of spheres. Lanes inside of the sphere have no sample.
    #[inline(always)]
    pub(super) fn on_sphere(sphere: &SpherePacket<R>, from: [R; 3], u: [R; 2]) -> Self {
        let cap = VisibleCap::new(sphere, from);
        let zero = R::splat(0.0);
        Self {
            point: cap.sample(u),
            density: cap.density(),
            by_solid_angle: zero.le(zero),
            valid: cap.outside,
        }
    }

    /// Connects points of surfaces to the samples.
    #[inline(always)]
    pub(super) fn connect(&self, from: &SurfacePacket<R>, two_sided: R::Mask) -> AreaSamples<R> {
        let zero = R::splat(0.0);
        let start = from.offset_origin(sub(self.point.position, from.position));
        let end = self.point.offset_origin(sub(start, self.point.position));
        let direction = sub(end, start);
        let d2 = dot(direction, direction);
        let cos = -dot(self.point.normal, direction) / d2.sqrt();
        let cos = R::select(two_sided, cos.abs(), cos);
        let density = R::select(self.by_solid_angle, self.density, self.density * d2 / cos);
        let infinity = R::splat(f32::INFINITY);
        let usable =
            self.valid & zero.lt(cos) & zero.lt(d2) & zero.lt(density) & density.lt(infinity);
        AreaSamples { direction, density, usable }
    }
}

/// Samples triangles uniformly by area. Returns the barycentric weights of the second and the third
/// vertex (Heitz 2019, "A low-distortion map between triangle and square").
#[inline(always)]
fn by_area<R: Real<Scalar = f32>>(u: [R; 2]) -> [R; 2] {
    let (zero, half) = (R::splat(0.0), R::splat(0.5));
    let (b, c) = (u[0] * half, u[1] * half);
    let offset = c - b;
    let upper = zero.lt(offset);
    [R::select(upper, b, b - offset), R::select(upper, c + offset, c)]
}

/// Returns the density of points on triangles: by solid angle or, where that is not how they are
/// sampled, by area.
#[inline(always)]
fn triangle_density<R: Real<Scalar = f32>>(
    triangle: &ShadingTriangle<R>,
    seen: &SphericalTriangle<R>,
) -> R {
    let [a, b, c] = triangle.positions;
    let normal = cross(sub(b, a), sub(c, a));
    let area = R::splat(0.5) * dot(normal, normal).sqrt();
    R::splat(1.0) / R::select(seen.by_solid_angle, seen.solid_angle, area)
}

impl AreaLight {
    /// Samples a point of a primitive for a point of a surface. The density (1/sr) does not include
    /// the probability of the primitive. The alpha of the shape scales the radiance, except that a
    /// shape of alpha 0 emits in full although no ray hits it, as in pbrt-v4.
    pub(super) fn sample(
        &self,
        shape: &Shape,
        primitive: u32,
        from: &SurfacePoint,
        u: [f32; 2],
    ) -> Option<LightSample> {
        let textured = self.emission.image.is_some() || !shape.is_opaque();
        let (mut uv, mut vertex_colour) = (Vec2::ZERO, None);
        let points = match &shape.geometry {
            Geometry::Mesh(mesh) => {
                let triangle = mesh.triangle(primitive);
                let (points, [b, c]) =
                    EmitterPoints::on_triangle(&triangle, from.position.to_array(), u);
                if textured && points.valid {
                    let hit = Hit { u: b, v: c, primitive, ..Hit::MISS };
                    uv = mesh.derivatives(&hit).uv;
                    vertex_colour = mesh.colour(&hit);
                }
                points
            }
            Geometry::Patches(_) | Geometry::Curves(_) => return None,
            Geometry::Quadric(quadric) => {
                let points = self.sample_quadric(quadric, from.position, u);
                if textured {
                    let position = Vec3::from(points.point.position).as_dvec3();
                    uv = quadric.derivatives(position).uv;
                }
                points
            }
        };
        let two_sided = self.emission.two_sided;
        let AreaSamples { direction, density, usable } = points.connect(&(*from).into(), two_sided);
        let singular = shape.is_invisible();
        usable.then(|| {
            let alpha = match singular {
                true => 1.0,
                false => shape.alpha_at(uv, &points.point.into(), vertex_colour),
            };
            LightSample {
                direction: direction.into(),
                t_max: 1.0,
                radiance: self.radiance(primitive, uv).map(|l| l * alpha),
                density,
                singular,
            }
        })
    }

    fn sample_quadric(&self, quadric: &Quadric, from: Vec3, u: [f32; 2]) -> EmitterPoints<f32> {
        if let Some(sphere) = &self.sphere {
            let points = EmitterPoints::on_sphere(sphere, from.to_array(), u);
            if points.valid {
                return points;
            }
        }
        if let Some(disk) = &self.disk {
            return EmitterPoints::on_disk(disk, u);
        }
        let (point, density) = quadric.sample(u);
        EmitterPoints { point: point.into(), density, by_solid_angle: false, valid: true }
    }

    /// Returns the density (1/sr) with which [`Self::sample`] samples a point of a primitive.
    pub(super) fn density(
        &self,
        geometry: &Geometry,
        primitive: u32,
        from: Vec3,
        point: &SurfacePoint,
        direction: Vec3,
    ) -> f32 {
        let density = match geometry {
            Geometry::Mesh(mesh) => {
                let triangle = mesh.triangle(primitive);
                let seen = SphericalTriangle::new(&triangle.positions, from.to_array());
                let density = triangle_density(&triangle, &seen);
                if seen.by_solid_angle {
                    return density;
                }
                density
            }
            Geometry::Patches(_) | Geometry::Curves(_) => 0.0,
            Geometry::Quadric(quadric) => {
                if let Some(sphere) = &self.sphere {
                    let cap = VisibleCap::new(sphere, from.to_array());
                    if cap.outside {
                        return cap.density();
                    }
                }
                quadric.density(point.position.as_dvec3())
            }
        };
        let d2 = (point.position - from).length_squared();
        let density = density * d2 / point.normal.dot(direction).abs();
        if density.is_finite() { density } else { 0.0 }
    }
}
