//! Opacity of a material: alpha modes and cutoffs.

use super::images::Channels;
use super::material_textures::product;
use super::materials::MaterialReader;
use crate::pbrt::SceneError;
use petzval_scene::Texture;

/// Opacity from which on a masked surface is there.
const DEFAULT_CUTOFF: f32 = 0.5;

impl MaterialReader<'_> {
    /// Returns the opacity, or `None` for an opaque surface.
    pub fn alpha(&mut self) -> Result<Option<Texture>, SceneError> {
        let pbr = &self.json.pbr_metallic_roughness;
        let factor = pbr.base_color_factor[3];
        let cutoff = self.json.alpha_cutoff.unwrap_or(DEFAULT_CUTOFF);
        let channels = match self.json.alpha_mode.as_deref() {
            Some("OPAQUE") | None => return Ok(None),
            Some("MASK") => Channels::Mask { factor, cutoff },
            Some("BLEND") => Channels::Alpha,
            Some(_) => {
                let element = format!("{}/alphaMode", self.element);
                let expected = "expected OPAQUE, MASK or BLEND";
                return Err(self.document.error(&element, "an unknown alpha mode", expected));
            }
        };
        let masked = matches!(channels, Channels::Mask { .. });
        // A mask is a threshold of the texture's opacity, without that of the vertices.
        let coloured = self.variant.coloured && !masked;
        let alpha = self.opacity(channels, masked, factor, cutoff)?;
        Ok(Some(if coloured { product(alpha, Texture::VertexOpacity) } else { alpha }))
    }

    /// Returns the opacity of the base colour, or where it is at least the cutoff.
    fn opacity(
        &mut self,
        channels: Channels,
        masked: bool,
        factor: f32,
        cutoff: f32,
    ) -> Result<Texture, SceneError> {
        let pbr = &self.json.pbr_metallic_roughness;
        let Some(info) = &pbr.base_color_texture else {
            let alpha = if masked { f32::from(factor >= cutoff) } else { factor };
            return Ok(Texture::Constant([alpha; 3]));
        };
        let scale = if masked { 1.0 } else { factor };
        self.texture(info, "pbrMetallicRoughness/baseColorTexture", channels, scale)
    }
}
