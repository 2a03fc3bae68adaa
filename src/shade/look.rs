//! Looking at a point of a surface: its textures and its bent normals.

use std::cell::OnceCell;

use glam::{Vec2, Vec3};

use crate::rays::{Hit, Ray};
use crate::sampler::hash;
use crate::scene::{Material, Patch, Scene, SurfacePoint, Texture, TexturePoint};

/// A point of a surface. Its texture coordinates are worked out once somebody asks.
pub(super) struct Look<'a> {
    pub(super) scene: &'a Scene,
    pub(super) ray: Ray,
    pub(super) hit: Hit,
    pub(super) point: SurfacePoint,
    patch: OnceCell<Patch>,
}

/// How far apart, in texture coordinates, heights are compared for their slope, as in pbrt-v4.
const STEP: f32 = 0.0005;

impl<'a> Look<'a> {
    pub(super) fn at(scene: &'a Scene, ray: Ray, hit: Hit, point: SurfacePoint) -> Self {
        Self { scene, ray, hit, point, patch: OnceCell::new() }
    }

    pub(super) fn patch(&self) -> &Patch {
        self.patch.get_or_init(|| self.scene.patch(&self.ray, &self.hit))
    }

    fn place(&self) -> TexturePoint {
        TexturePoint {
            uv: self.patch().uv,
            position: self.point.position,
            normal: self.point.normal,
            footprint: 0.0,
        }
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
            return (bent.unwrap_or(normal), patch.dp[0]);
        }
        let Some(bump) = &material.bump else { return (normal, patch.dp[0]) };
        let at = self.place();
        let height = bump.number(&at);
        let [u, v] = [0, 1].map(|axis| {
            let mut moved = at;
            moved.uv += if axis == 0 { Vec2::new(STEP, 0.0) } else { Vec2::new(0.0, STEP) };
            moved.position += patch.tangents[axis] * STEP;
            let slope = (bump.number(&moved) - height) / STEP;
            patch.tangents[axis] + normal * slope + patch.dn[axis] * height
        });
        let bent = u.cross(v).try_normalize().unwrap_or(normal);
        // On the side of the surface's own normal.
        (bent * bent.dot(self.point.normal).signum(), u)
    }
}
