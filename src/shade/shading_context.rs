//! Shading context: the textures and the perturbed shading normal at a point of a surface.

use std::cell::OnceCell;

use glam::Vec3;

use super::footprint::{NeighbourRay, PixelFootprint, SpecularBounce};
use crate::rays::{Hit, Ray, RayDifferential};
use crate::sampler::hash;
use crate::scene::{
    Geometry, Material, Scene, SurfaceDerivatives, SurfacePoint, Texture, TexturePoint,
};

/// A point of a surface that a ray hit. The texture coordinates and their derivatives are computed
/// on first use.
pub(super) struct ShadingContext<'a> {
    pub(super) scene: &'a Scene,
    pub(super) ray: Ray,
    pub(super) hit: Hit,
    pub(super) point: SurfacePoint,
    footprint: &'a PixelFootprint,
    /// Unknown for camera rays, and after paths were scattered.
    differential: RayDifferential,
    patch: OnceCell<SurfaceDerivatives>,
}

/// Step in texture coordinates for the slope of a height map, if the pixel's footprint gives none;
/// the value is pbrt-v4's.
const DEFAULT_STEP: f32 = 0.0005;

impl<'a> ShadingContext<'a> {
    /// The context of a hit, as seen by the camera itself.
    pub(super) fn new(
        scene: &'a Scene,
        footprint: &'a PixelFootprint,
        ray: Ray,
        hit: Hit,
        point: SurfacePoint,
    ) -> Self {
        let differential = RayDifferential::UNKNOWN;
        Self { scene, ray, hit, point, footprint, differential, patch: OnceCell::new() }
    }

    /// The same context, seen by a ray with this differential.
    pub(super) fn with_differential(self, differential: RayDifferential) -> Self {
        Self { differential, ..self }
    }

    /// Returns the texture coordinates and the derivatives of position and normal by them.
    pub(super) fn patch(&self) -> &SurfaceDerivatives {
        self.patch.get_or_init(|| self.scene.surface_derivatives(&self.ray, &self.hit))
    }

    fn texture_point(&self) -> TexturePoint {
        TexturePoint {
            uv: self.patch().uv,
            position: self.point.position,
            normal: self.point.normal,
            footprint: self.texture_steps().as_flattened().iter().fold(0.0, |a, b| a.max(b.abs())),
        }
    }

    /// Returns the change of the texture coordinates (u, v) to each of the neighbouring samples.
    fn texture_steps(&self) -> [[f32; 2]; 2] {
        self.neighbour_rays().map(|ray| ray.texture_step(&self.point, self.patch()))
    }

    /// Returns the rays of the neighbouring samples.
    fn neighbour_rays(&self) -> [NeighbourRay; 2] {
        NeighbourRay::transferred(&self.ray, self.hit.t, &self.differential)
            .unwrap_or_else(|| self.footprint.neighbour_rays(self.point.position))
    }

    /// Returns the differential of the ray that leaves a smooth surface at this point.
    pub(super) fn differential_after_bounce(&self, bounce: &SpecularBounce) -> RayDifferential {
        let mut next = RayDifferential::UNKNOWN;
        for (axis, neighbour) in self.neighbour_rays().into_iter().enumerate() {
            let along = self.ray.direction.into();
            let [origin, direction] =
                neighbour.after_bounce(along, &self.point, self.patch(), bounce);
            if !(origin.is_finite() && direction.is_finite()) {
                return RayDifferential::UNKNOWN;
            }
            (next.origin[axis], next.direction[axis]) = (origin.into(), direction.into());
        }
        next
    }

    /// Returns the colour of a texture at this point.
    pub(super) fn colour(&self, texture: &Texture) -> [f32; 3] {
        match texture {
            Texture::Constant(colour) => *colour,
            _ => texture.colour(&self.texture_point()),
        }
    }

    /// Returns the value of a scalar texture at this point.
    pub(super) fn number(&self, texture: &Texture) -> f32 {
        match texture {
            Texture::Constant([value, ..]) => *value,
            _ => texture.scalar(&self.texture_point()),
        }
    }

    /// Returns a random number in [0, 1) that depends only on the point, the ray's direction and
    /// `salt`.
    pub(super) fn hashed_number(&self, salt: u32) -> f32 {
        let bits = self.point.position.to_array().into_iter().chain(self.ray.direction);
        let mixed = bits.fold(salt, |h, value| hash(h ^ value.to_bits()));
        (mixed >> 8) as f32 / 16_777_216.0
    }

    /// Returns the unit shading normal, perturbed by the material's normal map or bump map, and the
    /// tangent along u.
    pub(super) fn perturbed_normal(&self, material: &Material) -> (Vec3, Vec3) {
        let (normal, patch) = (self.point.shading_normal, self.patch());
        if let Some(map) = &material.normal_map {
            // The map is relative to the frame whose x axis is along u.
            let [x, y, z] = map.colour(patch.uv).map(|c| 2.0 * c - 1.0);
            let tangent = (patch.dp[0] - normal * normal.dot(patch.dp[0])).normalize_or_zero();
            let across = normal.cross(tangent);
            let perturbed = (tangent * x + across * y + normal * z).try_normalize();
            return (self.face_outward(perturbed.unwrap_or(normal)), patch.dp[0]);
        }
        let Some(bump) = &material.bump else { return (normal, patch.dp[0]) };
        let (at, steps) = (self.texture_point(), self.texture_steps());
        let tangents = self.displacement_tangents();
        let height = bump.scalar(&at);
        let [u, v] = [0, 1].map(|axis| {
            let wide = 0.5 * (steps[0][axis].abs() + steps[1][axis].abs());
            let step = if wide > 0.0 { wide } else { DEFAULT_STEP };
            let mut moved = at;
            moved.uv[axis] += step;
            moved.position += tangents[axis] * step;
            let slope = (bump.scalar(&moved) - height) / step;
            tangents[axis] + normal * slope + patch.dn[axis] * height
        });
        let perturbed = u.cross(v).try_normalize().unwrap_or(normal);
        (self.face_outward(perturbed), u)
    }

    /// Flips a normal to the side of the geometric normal.
    fn face_outward(&self, normal: Vec3) -> Vec3 {
        normal * normal.dot(self.point.normal).signum()
    }

    /// Returns the tangents that a bump map displaces, as pbrt-v4 does. They are the derivatives of
    /// the position by u and v, except on meshes with vertex normals. There both are orthogonal to
    /// the shading normal: the first is as close to u as possible, the second has the same length.
    fn displacement_tangents(&self) -> [Vec3; 2] {
        let (normal, patch) = (self.point.shading_normal, self.patch());
        let smooth = match &self.scene.shapes[self.hit.shape as usize].geometry {
            Geometry::Mesh(mesh) => !mesh.normals.is_empty() && mesh.patch_starts.is_empty(),
            Geometry::Quadric(_) => false,
        };
        if !smooth {
            return patch.dp;
        }
        let across = normal.cross(patch.dp[0]);
        match across.length_squared() > 0.0 {
            true => [across.cross(normal), across],
            false => normal.any_orthonormal_pair().into(),
        }
    }
}
