//! Extensions clearcoat and specular of materials, whose values are checked.

use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;

use super::images::Channels;
use super::materials::MaterialReader;
use super::schema::{MaterialExtensions, TextureInfo};
use crate::pbrt::SceneError;
use petzval_image::Transfer;
use petzval_scene::{Roughness, Texture};

/// An extension of materials.
trait MaterialExtension: for<'a> Deserialize<'a> {
    /// Its name.
    const NAME: &str;
    /// The second half of the error about a wrong value: "expected ...".
    const EXPECTED: &str;

    /// Returns its JSON.
    fn json(extensions: &MaterialExtensions) -> Option<&Value>;

    /// Returns the first value that is not allowed.
    fn wrong_value(&self) -> Option<String>;
}

/// The extension KHR_materials_clearcoat.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Clearcoat {
    pub clearcoat_factor: f32,
    pub clearcoat_texture: Option<TextureInfo>,
    pub clearcoat_roughness_factor: f32,
    pub clearcoat_roughness_texture: Option<TextureInfo>,
    pub clearcoat_normal_texture: Option<IgnoredAny>,
}

/// The extension KHR_materials_specular.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
struct Specular {
    pub specular_factor: f32,
    pub specular_texture: Option<TextureInfo>,
    pub specular_color_factor: [f32; 3],
    pub specular_color_texture: Option<TextureInfo>,
}

impl Default for Specular {
    fn default() -> Self {
        Self {
            specular_factor: 1.0,
            specular_texture: None,
            specular_color_factor: [1.0; 3],
            specular_color_texture: None,
        }
    }
}

impl MaterialExtension for Clearcoat {
    const NAME: &str = "KHR_materials_clearcoat";
    const EXPECTED: &str = "expected an object with factors from 0 to 1";

    fn json(extensions: &MaterialExtensions) -> Option<&Value> {
        extensions.clearcoat.as_ref()
    }

    fn wrong_value(&self) -> Option<String> {
        let factors = [
            ("clearcoatFactor", self.clearcoat_factor),
            ("clearcoatRoughnessFactor", self.clearcoat_roughness_factor),
        ];
        let wrong = factors.into_iter().find(|(_, factor)| !(0.0..=1.0).contains(factor));
        wrong.map(|(name, factor)| format!("a {name} of {factor}"))
    }
}

impl MaterialExtension for Specular {
    const NAME: &str = "KHR_materials_specular";
    const EXPECTED: &str = "expected an object with a specularFactor from 0 to 1 and a \
                            specularColorFactor of 0 or more";

    fn json(extensions: &MaterialExtensions) -> Option<&Value> {
        extensions.specular.as_ref()
    }

    fn wrong_value(&self) -> Option<String> {
        let (strength, [r, g, b]) = (self.specular_factor, self.specular_color_factor);
        if !(0.0..=1.0).contains(&strength) {
            return Some(format!("a specularFactor of {strength}"));
        }
        let is_wrong = [r, g, b].iter().any(|value| !(value.is_finite() && *value >= 0.0));
        is_wrong.then(|| format!("a specularColorFactor of {r}, {g}, {b}"))
    }
}

/// The reflection of a dielectric.
pub(super) struct DielectricReflection {
    pub strength: Texture,
    pub colour: Texture,
}

impl MaterialReader<'_> {
    /// Reads an extension of the material.
    ///
    /// # Errors
    /// Returns an error, with its place, if a value is wrong.
    fn extension<E: MaterialExtension>(&self) -> Result<Option<E>, SceneError> {
        let Some(value) = self.json.extensions.as_ref().and_then(E::json) else { return Ok(None) };
        let read = match value.is_object() {
            true => E::deserialize(value).map_err(|error| error.to_string()),
            false => Err(format!("found {value}")),
        };
        let place = format!("{}/extensions/{}", self.element, E::NAME);
        read.and_then(|extension| extension.wrong_value().map_or(Ok(Some(extension)), Err))
            .map_err(|found| self.document.error(&place, found, E::EXPECTED))
    }

    /// Returns the coverage and the roughness of the clear coat.
    pub fn clearcoat(&mut self) -> Result<(Texture, Roughness), SceneError> {
        let Some(coat) = self.extension::<Clearcoat>()? else {
            return Ok((Texture::Constant([0.0; 3]), Roughness::smooth()));
        };
        let name = Clearcoat::NAME;
        if coat.clearcoat_normal_texture.is_some() {
            let element = format!("{}/extensions/{name}/clearcoatNormalTexture", self.element);
            self.document.warn(&element, "the normal map of a clear coat is not read");
        }
        let coverage = match &coat.clearcoat_texture {
            Some(info) => {
                let at = format!("extensions/{name}/clearcoatTexture");
                let channels = Channels::Single(0, Transfer::Linear);
                self.texture(info, &at, channels, coat.clearcoat_factor)?
            }
            None => Texture::Constant([coat.clearcoat_factor; 3]),
        };
        let roughness = self.roughness(
            coat.clearcoat_roughness_factor,
            coat.clearcoat_roughness_texture.as_ref(),
            &format!("extensions/{name}/clearcoatRoughnessTexture"),
        )?;
        Ok((coverage, roughness))
    }

    /// Returns strength and colour of the reflection of the dielectric.
    pub fn specular(&mut self) -> Result<DielectricReflection, SceneError> {
        let json = self.extension::<Specular>()?.unwrap_or_default();
        let name = Specular::NAME;
        let strength = match &json.specular_texture {
            Some(info) => {
                let at = format!("extensions/{name}/specularTexture");
                self.texture(
                    info,
                    &at,
                    Channels::Single(3, Transfer::Linear),
                    json.specular_factor,
                )?
            }
            None => Texture::Constant([json.specular_factor; 3]),
        };
        let at = format!("extensions/{name}/specularColorTexture");
        let texture = json.specular_color_texture.as_ref();
        Ok(DielectricReflection {
            strength,
            colour: self.colour(json.specular_color_factor, texture, &at)?,
        })
    }
}
