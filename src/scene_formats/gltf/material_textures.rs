//! Textures of a material: colours, roughness and normals, each times its factor.

use std::sync::Arc;

use super::images::Channels;
use super::materials::MaterialReader;
use super::schema::TextureInfo;
use super::textures::{TextureUse, image_map, image_texture};
use crate::pbrt::SceneError;
use petzval_image::Transfer;
use petzval_scene::{ImageMap, Roughness, Texture};

/// Returns the product of two textures; a factor of 1 is left out.
pub(super) fn product(one: Texture, other: Texture) -> Texture {
    match one {
        Texture::Constant([1.0, 1.0, 1.0]) => other,
        one => Texture::Scale(Arc::new(one), Arc::new(other)),
    }
}

impl MaterialReader<'_> {
    /// Returns the roughness of microfacets: alpha is the square of glTF's roughness. The texture
    /// holds it in its green channel.
    pub fn roughness(
        &mut self,
        factor: f32,
        texture: Option<&TextureInfo>,
        at: &str,
    ) -> Result<Roughness, SceneError> {
        let scale = factor * factor;
        let alpha = match texture {
            Some(info) => {
                self.texture(info, at, Channels::Single(1, Transfer::Gamma(2.0)), scale)?
            }
            None => Texture::Constant([scale; 3]),
        };
        Ok(Roughness { uv: [alpha.clone(), alpha], remap: false })
    }

    /// Returns the base colour: its texture times its factor and the colour of the vertices.
    pub fn base_colour(&mut self, factor: [f32; 3]) -> Result<Texture, SceneError> {
        let info = self.json.pbr_metallic_roughness.base_color_texture.as_ref();
        let colour = self.colour(factor, info, "pbrMetallicRoughness/baseColorTexture")?;
        Ok(match self.variant.coloured {
            true => product(colour, Texture::VertexColour),
            false => colour,
        })
    }

    /// Returns a colour: its texture, if there is one, times its factor.
    pub fn colour(
        &mut self,
        factor: [f32; 3],
        texture: Option<&TextureInfo>,
        at: &str,
    ) -> Result<Texture, SceneError> {
        let Some(info) = texture else { return Ok(Texture::Constant(factor)) };
        Ok(product(Texture::Constant(factor), self.texture(info, at, Channels::Colour, 1.0)?))
    }

    /// Returns a texture of some channels of an image, times a factor.
    pub fn texture(
        &mut self,
        info: &TextureInfo,
        at: &str,
        channels: Channels,
        scale: f32,
    ) -> Result<Texture, SceneError> {
        let texture = TextureUse::new(info, format!("{}/{at}", self.element));
        self.uv_sets.push(texture.set());
        image_texture(self.document, self.images, &texture, channels, scale)
    }

    /// Returns the normal map, turned as the variant needs.
    pub fn normal_map(&mut self, texture: &TextureInfo) -> Result<ImageMap, SceneError> {
        let used = TextureUse::new(texture, format!("{}/normalTexture", self.element));
        self.uv_sets.push(used.set());
        let scale = texture.scale.unwrap_or(1.0);
        let along = [scale, if self.variant.mirrored { -scale } else { scale }, 1.0];
        let change = |signal: [f32; 3]| {
            let tilted: [f32; 3] = std::array::from_fn(|i| (2.0 * signal[i] - 1.0) * along[i]);
            let length = tilted.iter().map(|x| x * x).sum::<f32>().sqrt().max(1e-6);
            tilted.map(|x| (x / length + 1.0) / 2.0)
        };
        image_map(self.document, self.images, &used, true, change)
    }

    /// Returns the set of texture coordinates of the base colour, or else of the first texture.
    pub fn uv_set(&self) -> u32 {
        let base = self.json.pbr_metallic_roughness.base_color_texture.as_ref();
        let base = base.map(|info| TextureUse::new(info, String::new()).set());
        let first = base.or(self.uv_sets.first().copied()).unwrap_or(0);
        if self.uv_sets.iter().any(|&set| set != first) {
            let message = format!(
                "a material reads one set of texture coordinates: all its textures use set {first}"
            );
            self.document.warn(&self.element, &message);
        }
        first
    }
}
