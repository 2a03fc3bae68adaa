//! Mappings from surfaces to texture coordinates.

use glam::{Affine3A, Vec2, Vec3};

use super::SceneError;
use super::textures::TextureDirective;
use petzval_scene::Mapping;

impl TextureDirective {
    /// Returns the transform from world space to texture space.
    pub(super) fn texture_from_world(&self) -> Result<Affine3A, SceneError> {
        let texture_from_world = self.world_from_texture.inverse().as_affine3a();
        match texture_from_world.is_finite() {
            true => Ok(texture_from_world),
            false => {
                let found = "a texture in a space that its transform flattens";
                let expected = "expected a transform with an inverse";
                Err(SceneError::at(self.params.at.clone(), found, expected))
            }
        }
    }

    pub(super) fn mapping(&self) -> Result<Mapping, SceneError> {
        let params = &self.params;
        let number = |name: &str, default: f64| params.float(name, default).map(|v| v as f32);
        let offset = Vec2::new(number("udelta", 0.0)?, number("vdelta", 0.0)?);
        let axis = |name: &str, default: [f64; 3]| {
            let axis = params.triple(name)?.unwrap_or(default);
            Ok::<_, SceneError>(Vec3::from_array(axis.map(|v| v as f32)))
        };
        Ok(match params.text("mapping")? {
            None | Some("uv") => {
                let scale = Vec2::new(number("uscale", 1.0)?, number("vscale", 1.0)?);
                Mapping::Uv { scale, offset }
            }
            Some("spherical") => {
                Mapping::Spherical { texture_from_world: self.texture_from_world()? }
            }
            Some("cylindrical") => {
                Mapping::Cylindrical { texture_from_world: self.texture_from_world()? }
            }
            Some("planar") => Mapping::Planar {
                texture_from_world: self.texture_from_world()?,
                axes: [axis("v1", [1.0, 0.0, 0.0])?, axis("v2", [0.0, 1.0, 0.0])?],
                offset,
            },
            Some(other) => {
                let found = format!("the mapping \"{other}\"");
                let expected = "expected uv, spherical, cylindrical or planar";
                return Err(params.refuse("mapping", found, expected));
            }
        })
    }
}
