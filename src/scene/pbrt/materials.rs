//! Materials, named and in place, from their parameters.

use super::SceneError;
use super::colour::Meaning;
use super::params::Params;
use super::reader::Reader;
use crate::scene::{Material, Scatters, Texture};
use crate::source::hint;

impl Reader {
    pub(super) fn material(&mut self) -> Result<(), SceneError> {
        self.after_world("Material")?;
        let name = self.string()?;
        let params = self.params()?;
        self.state.material = self.surface(name, params)?;
        Ok(())
    }

    pub(super) fn make_named_material(&mut self) -> Result<(), SceneError> {
        self.after_world("MakeNamedMaterial")?;
        let name = self.string()?;
        let mut params = self.params()?;
        let Some(kind) = params.text("type")?.map(str::to_owned) else {
            return self.refuse("a named material without \"string type\"", "");
        };
        params.all.retain(|param| param.name != "type");
        let material = self.surface(kind, params)?;
        self.materials.insert(name, material);
        Ok(())
    }

    pub(super) fn named_material(&mut self) -> Result<(), SceneError> {
        self.after_world("NamedMaterial")?;
        let name = self.string()?;
        match self.materials.get(&name) {
            Some(material) => {
                self.state.material = *material;
                Ok(())
            }
            None => {
                let hint = hint(&name, self.materials.keys().map(String::as_str));
                self.refuse(format!("no material named \"{name}\"{hint}"), "")
            }
        }
    }

    pub(super) fn surface(&mut self, name: String, params: Params) -> Result<u32, SceneError> {
        let (_, _, params, supported) = self.check("Material", name, params)?;
        let mut reflectance = None;
        for name in ["Kd", "reflectance"] {
            let found = self.library.colour_or_texture(&params, name, Meaning::Albedo);
            // What is not supported is not checked either: it may call another thing Kd.
            reflectance = reflectance.or(if supported { found? } else { found.unwrap_or(None) });
        }
        let reflectance = reflectance.unwrap_or(Texture::Constant([0.5; 3]));
        Ok(self.builder.material(Material::new(Scatters::Diffuse { reflectance })))
    }
}
