//! Parameters of solid textures.

use std::sync::Arc;

use super::SceneError;
use super::texture_library::TextureType;
use super::textures::TextureDirective;
use petzval_scene::{Octaves, SolidPattern, SolidTexture, Texture};

impl TextureDirective {
    /// Returns a solid texture in the space of the directive.
    pub(super) fn solid(&self, pattern: SolidPattern) -> Result<Texture, SceneError> {
        let texture_from_world = self.texture_from_world()?;
        Ok(Texture::Solid(Arc::new(SolidTexture { texture_from_world, pattern })))
    }

    pub(super) fn octaves(&self) -> Result<Octaves, SceneError> {
        let params = &self.params;
        let (count, most) = (params.float("octaves", 8.0)?, f64::from(Octaves::MAX));
        if count.fract() != 0.0 || !(0.0..=most).contains(&count) {
            let expected = format!("expected a whole number from 0 to {most}");
            return Err(params.refuse("octaves", format!("\"octaves\" is {count}"), expected));
        }
        let roughness = params.float("roughness", 0.5)? as f32;
        Ok(Octaves { count: count as u32, roughness })
    }

    pub(super) fn marble(&self) -> Result<Texture, SceneError> {
        let params = &self.params;
        if self.texture_type == TextureType::Float {
            let (found, expected) = ("marble of type float", "expected type spectrum");
            return Err(SceneError::at(params.at.clone(), found, expected));
        }
        self.solid(SolidPattern::Marble {
            octaves: self.octaves()?,
            scale: params.float("scale", 1.0)? as f32,
            variation: params.float("variation", 0.2)? as f32,
        })
    }
}
