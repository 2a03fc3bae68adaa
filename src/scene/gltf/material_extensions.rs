//! Extensions of materials that gltf-json does not define, or whose definition there refuses what it
//! does not know.

use gltf_json::material::Material;
use gltf_json::texture::Info;
use serde::Deserialize;

use super::document::Document;
use crate::scene::pbrt::SceneError;

/// An extension of materials.
pub(super) trait MaterialExtension: for<'a> Deserialize<'a> {
    /// Its name.
    const NAME: &str;
    /// The second half of the error about a wrong value: "expected ...".
    const EXPECTED: &str;

    /// Returns the first value that is not allowed.
    fn wrong_value(&self) -> Option<String>;
}

/// The extension KHR_materials_clearcoat.
#[derive(Default, Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Clearcoat {
    pub clearcoat_factor: f32,
    pub clearcoat_texture: Option<Info>,
    pub clearcoat_roughness_factor: f32,
    pub clearcoat_roughness_texture: Option<Info>,
    pub clearcoat_normal_texture: Option<serde_json::Value>,
}

/// The extension KHR_materials_specular.
#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub(super) struct Specular {
    pub specular_factor: f32,
    pub specular_texture: Option<Info>,
    pub specular_color_factor: [f32; 3],
    pub specular_color_texture: Option<Info>,
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

    fn wrong_value(&self) -> Option<String> {
        let (strength, [r, g, b]) = (self.specular_factor, self.specular_color_factor);
        if !(0.0..=1.0).contains(&strength) {
            return Some(format!("a specularFactor of {strength}"));
        }
        let is_wrong = [r, g, b].iter().any(|value| !(value.is_finite() && *value >= 0.0));
        is_wrong.then(|| format!("a specularColorFactor of {r}, {g}, {b}"))
    }
}

/// Reads an extension of a material; `element` is the place of the material.
///
/// # Errors
/// Returns an error, with its place, if a value is wrong.
pub(super) fn read<E: MaterialExtension>(
    document: &Document,
    material: &Material,
    element: &str,
) -> Result<Option<E>, SceneError> {
    let extensions = material.extensions.as_ref();
    let Some(value) = extensions.and_then(|all| all.others.get(E::NAME)) else { return Ok(None) };
    let read = match value.is_object() {
        true => E::deserialize(value).map_err(|error| error.to_string()),
        false => Err(format!("found {value}")),
    };
    let place = format!("{element}/extensions/{}", E::NAME);
    read.and_then(|extension| extension.wrong_value().map_or(Ok(Some(extension)), Err))
        .map_err(|found| document.error(&place, found, E::EXPECTED))
}
