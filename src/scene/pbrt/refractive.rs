//! Refractive indices of metals and glasses, by name, spectrum or number.

use super::SceneError;
use super::colour::Meaning;
use super::surfaces::Recipe;
use crate::scene::{Metal, Texture};
use crate::spectrum::ChannelMetal;

impl Recipe<'_> {
    /// The metal that these parameters describe; copper where nothing is given.
    pub(super) fn metal(&mut self, eta: &str, k: &str) -> Result<Metal, SceneError> {
        let indices = self.params.find(eta).or(self.params.find(k));
        let reflectance =
            self.library.colour_or_texture(self.params, "reflectance", Meaning::Albedo)?;
        if let Some(reflectance) = reflectance {
            if indices.is_some() {
                let found = format!("a metal with reflectance and with {eta} or {k}");
                return Err(self.params.refuse("reflectance", found, "expected one or the other"));
            }
            return Ok(Metal::Reflectance(reflectance));
        }
        let textured = |name: &str| {
            Ok::<_, SceneError>(match self.params.texture(name)? {
                Some(_) => self.library.colour_or_texture(self.params, name, Meaning::Unbounded)?,
                None => None,
            })
        };
        let (of_eta, of_k) = (textured(eta)?, textured(k)?);
        if of_eta.is_none() && of_k.is_none() {
            let ChannelMetal { eta, k, tint } = self.params.metal(eta, k)?;
            let [eta, k] = [eta, k].map(Texture::Constant);
            return Ok(Metal::Index { eta, k, tint });
        }
        // What stands beside a texture is looked at by channel as well.
        let plain = self.params.metal(eta, k)?;
        Ok(Metal::Index {
            eta: of_eta.unwrap_or(Texture::Constant(plain.eta)),
            k: of_k.unwrap_or(Texture::Constant(plain.k)),
            tint: [1.0; 3],
        })
    }

    /// The index of a dielectric: the first of these parameters that is given, or 1.5.
    pub(super) fn index(&mut self, names: &[&str]) -> Result<f32, SceneError> {
        let Some(param) = names.iter().find_map(|name| self.params.find(name)) else {
            return Ok(1.5);
        };
        if param.kind == "texture" {
            let what = format!("a texture for \"{}\"", param.name);
            self.notices.instead(&param.at, &what, "1.5 is used");
            return Ok(1.5);
        }
        Ok(self.params.index(&param.name, 1.5, self.notices)? as f32)
    }
}
