//! Looking at a point of a surface: its textures and its bent normals.

use std::cell::OnceCell;

use glam::Vec3;

use super::footprint::{Beam, Bounce, Side};
use crate::rays::{Hit, Ray, RayDifferential};
use crate::sampler::hash;
use crate::scene::{Geometry, Material, Patch, Scene, SurfacePoint, Texture, TexturePoint};

/// A point of a surface. Its texture coordinates are worked out once somebody asks.
pub(super) struct Look<'a> {
    pub(super) scene: &'a Scene,
    pub(super) ray: Ray,
    pub(super) hit: Hit,
    pub(super) point: SurfacePoint,
    beam: &'a Beam,
    /// Unknown for what the camera sees itself, and after paths were scattered.
    differential: RayDifferential,
    patch: OnceCell<Patch>,
}

/// How far apart, in texture coordinates, heights are compared for their slope where the pixel
/// does not say it, as in pbrt-v4.
const STEP: f32 = 0.0005;

impl<'a> Look<'a> {
    pub(super) fn at(
        scene: &'a Scene,
        beam: &'a Beam,
        ray: Ray,
        hit: Hit,
        point: SurfacePoint,
    ) -> Self {
        let differential = RayDifferential::UNKNOWN;
        Self { scene, ray, hit, point, beam, differential, patch: OnceCell::new() }
    }

    /// The same, seen by a ray of this differential.
    pub(super) fn seen_by(self, differential: RayDifferential) -> Self {
        Self { differential, ..self }
    }

    pub(super) fn patch(&self) -> &Patch {
        self.patch.get_or_init(|| self.scene.patch(&self.ray, &self.hit))
    }

    fn place(&self) -> TexturePoint {
        TexturePoint {
            uv: self.patch().uv,
            position: self.point.position,
            normal: self.point.normal,
            footprint: self.steps().as_flattened().iter().fold(0.0, |a, b| a.max(b.abs())),
        }
    }

    /// How texture coordinates change from sample to sample of the pixel.
    fn steps(&self) -> [[f32; 2]; 2] {
        self.sides().map(|side| side.slopes(&self.point, self.patch()))
    }

    /// The rays of the samples beside this one.
    fn sides(&self) -> [Side; 2] {
        Side::of(&self.ray, self.hit.t, &self.differential)
            .unwrap_or_else(|| self.beam.sides(self.point.position))
    }

    /// The differential of the ray that leaves a smooth surface here.
    pub(super) fn bounced(&self, bounce: &Bounce) -> RayDifferential {
        let mut next = RayDifferential::UNKNOWN;
        for (axis, side) in self.sides().into_iter().enumerate() {
            let along = self.ray.direction.into();
            let [origin, direction] = side.bounced(along, &self.point, self.patch(), bounce);
            if !(origin.is_finite() && direction.is_finite()) {
                return RayDifferential::UNKNOWN;
            }
            (next.origin[axis], next.direction[axis]) = (origin.into(), direction.into());
        }
        next
    }

    /// The colour of a texture here.
    pub(super) fn colour(&self, texture: &Texture) -> [f32; 3] {
        match texture {
            Texture::Constant(colour) => *colour,
            _ => texture.at(&self.place()),
        }
    }

    /// The number of a texture here.
    pub(super) fn number(&self, texture: &Texture) -> f32 {
        match texture {
            Texture::Constant([value, ..]) => *value,
            _ => texture.number(&self.place()),
        }
    }

    /// A random number in [0, 1) that depends on the place and the ray, and on nothing else.
    pub(super) fn chance(&self, salt: u32) -> f32 {
        let bits = self.point.position.to_array().into_iter().chain(self.ray.direction);
        let mixed = bits.fold(salt, |h, value| hash(h ^ value.to_bits()));
        (mixed >> 8) as f32 / 16_777_216.0
    }

    /// The shading normal as the material bends it, and the tangent along u there.
    pub(super) fn bent(&self, material: &Material) -> (Vec3, Vec3) {
        let (normal, patch) = (self.point.shading, self.patch());
        if let Some(map) = &material.normal_map {
            // About the frame whose x is along u.
            let [x, y, z] = map.at(patch.uv).map(|c| 2.0 * c - 1.0);
            let tangent = (patch.dp[0] - normal * normal.dot(patch.dp[0])).normalize_or_zero();
            let across = normal.cross(tangent);
            let bent = (tangent * x + across * y + normal * z).try_normalize();
            return (self.outward(bent.unwrap_or(normal)), patch.dp[0]);
        }
        let Some(bump) = &material.bump else { return (normal, patch.dp[0]) };
        let (at, steps, tangents) = (self.place(), self.steps(), self.tangents());
        let height = bump.number(&at);
        let [u, v] = [0, 1].map(|axis| {
            let wide = 0.5 * (steps[0][axis].abs() + steps[1][axis].abs());
            let step = if wide > 0.0 { wide } else { STEP };
            let mut moved = at;
            moved.uv[axis] += step;
            moved.position += tangents[axis] * step;
            let slope = (bump.number(&moved) - height) / step;
            tangents[axis] + normal * slope + patch.dn[axis] * height
        });
        let bent = u.cross(v).try_normalize().unwrap_or(normal);
        (self.outward(bent), u)
    }

    /// A normal on the side of the surface's own.
    fn outward(&self, normal: Vec3) -> Vec3 {
        normal * normal.dot(self.point.normal).signum()
    }

    /// The tangents that textures bend. As in pbrt-v4 they are those of u and v, but where the
    /// vertices of triangles have normals: there they lie across the shading normal, the first as
    /// nearly along u as it can be, and the second as long as the first.
    fn tangents(&self) -> [Vec3; 2] {
        let (normal, patch) = (self.point.shading, self.patch());
        let smooth = match &self.scene.shapes[self.hit.shape as usize].geometry {
            Geometry::Mesh(mesh) => !mesh.normals.is_empty() && mesh.patches.is_empty(),
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
