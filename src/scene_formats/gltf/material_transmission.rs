//! Light through a material: the extensions ior, transmission and volume.

use super::images::Channels;
use super::materials::MaterialReader;
use super::schema::{Ior, Volume};
use crate::pbrt::SceneError;
use petzval_image::Transfer;
use petzval_scene::{
    Homogeneous, MaterialModel, Medium, MediumInterface, MetallicRoughnessSurface, Texture, VACUUM,
};

impl MaterialReader<'_> {
    /// Returns the glass of a surface that transmits light: a sheet unless it has a thickness.
    /// Its base colour tints what passes through each of its faces.
    pub fn glass(&self, eta: f32, surface: &MetallicRoughnessSurface) -> MaterialModel {
        let MetallicRoughnessSurface { roughness, base_colour: tint, .. } = surface;
        if self.volume().is_some() {
            let roughness = roughness.clone();
            return match tint {
                Texture::Constant([1.0, 1.0, 1.0]) => {
                    MaterialModel::Dielectric { eta, dispersion: None, roughness }
                }
                tint => MaterialModel::TintedDielectric { eta, roughness, tint: tint.clone() },
            };
        }
        if !matches!(roughness.uv[0], Texture::Constant([0.0, ..])) {
            let message = "a rough sheet without thickness is clear: give it KHR_materials_volume";
            self.document.warn(&self.element, message);
        }
        MaterialModel::thin_sheet(eta, tint.clone())
    }

    /// Returns the extension volume if it gives a thickness.
    fn volume(&self) -> Option<&Volume> {
        let volume = self.json.extensions.as_ref()?.volume.as_ref()?;
        (volume.thickness_factor > 0.0).then_some(volume)
    }

    /// Returns the medium inside, if the surface bounds a volume.
    pub fn interior(&mut self) -> Option<MediumInterface> {
        let volume = self.volume()?;
        let distance = volume.attenuation_distance;
        let colour = volume.attenuation_color;
        let absorption =
            colour.map(|c| (-c.clamp(1e-6, 1.0).ln() / distance.max(f32::MIN_POSITIVE)).max(0.0));
        if absorption.iter().all(|&a| a == 0.0 || !a.is_finite()) {
            return None;
        }
        let medium = Homogeneous { absorption, scattering: [0.0; 3], emission: [0.0; 3] };
        let inside = self.builder.add_medium(Medium::homogeneous(medium, 0.0));
        Some(MediumInterface { inside, outside: VACUUM })
    }

    /// Returns the share of the light that the dielectric transmits, if any.
    pub fn transmission(&mut self) -> Result<Option<Texture>, SceneError> {
        let extensions = self.json.extensions.as_ref();
        let Some(transmission) = extensions.and_then(|all| all.transmission.as_ref()) else {
            return Ok(None);
        };
        let factor = transmission.transmission_factor;
        if factor <= 0.0 {
            return Ok(None);
        }
        if extensions.is_some_and(|all| all.specular.is_some()) {
            let message = "KHR_materials_specular does not change the reflection of what transmits \
                           light";
            self.document.warn(&self.element, message);
        }
        let Some(info) = &transmission.transmission_texture else {
            return Ok(Some(Texture::Constant([factor; 3])));
        };
        let at = "extensions/KHR_materials_transmission/transmissionTexture";
        self.texture(info, at, Channels::Single(0, Transfer::Linear), factor).map(Some)
    }

    /// Returns the refractive index.
    pub fn ior(&self) -> Result<f32, SceneError> {
        let extension = self.json.extensions.as_ref().and_then(|all| all.ior.as_ref());
        let ior = extension.map_or(Ior::default().ior, |extension| extension.ior);
        match ior {
            // A surface of index 0 reflects everything, by the extension.
            0.0 => Ok(1e4),
            1.0..=1e4 => Ok(ior),
            _ => {
                let element = format!("{}/extensions/KHR_materials_ior/ior", self.element);
                let found = format!("an index of {ior}");
                Err(self.document.error(&element, found, "expected 1 or more, or 0"))
            }
        }
    }
}
