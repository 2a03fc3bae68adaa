//! Materials, named and in place: the directives. What a kind of material reads is in
//! [`super::surfaces`].

use super::SceneError;
use super::colour::Meaning;
use super::params::Params;
use super::reader::Reader;
use super::surfaces::Recipe;
use crate::scene::{ImageMap, Mapping, Material, Scatters, Wrap};
use crate::source::{Location, hint};

/// A material that has a name, or that something has asked for by name.
pub(super) struct Named {
    pub(super) index: u32,
    /// Where it was asked for, while it has not been made.
    pub(super) promised: Option<Location>,
}

impl Reader {
    pub(super) fn material(&mut self) -> Result<(), SceneError> {
        self.after_world("Material")?;
        let name = self.string()?;
        let params = self.params()?;
        let material = self.surface(name, params)?;
        self.state.material = self.builder.material(material);
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
        let index = match self.materials.get(&name) {
            Some(Named { index, promised: Some(_) }) => {
                self.builder.change_material(*index, material);
                *index
            }
            _ => self.builder.material(material),
        };
        self.materials.insert(name, Named { index, promised: None });
        Ok(())
    }

    /// Names may be used before they are made: pbrt-v4 looks them up when the file has ended.
    pub(super) fn named_material(&mut self) -> Result<(), SceneError> {
        self.after_world("NamedMaterial")?;
        let name = self.string()?;
        let Self { materials, builder, at, .. } = self;
        let named = materials.entry(name).or_insert_with(|| Named {
            index: builder.material(Material::diffuse([0.5; 3])),
            promised: Some(at.clone()),
        });
        self.state.material = named.index;
        Ok(())
    }

    /// An error where a material was asked for that was never made.
    pub(super) fn promises(&self) -> Result<(), SceneError> {
        let broken = self.materials.iter().filter_map(|(name, named)| {
            let at = named.promised.as_ref()?;
            Some((at, name))
        });
        let Some((at, name)) = broken.min() else { return Ok(()) };
        let made = self.materials.iter().filter(|(_, named)| named.promised.is_none());
        let hint = hint(name, made.map(|(name, _)| name.as_str()));
        Err(SceneError::at(at.clone(), format!("no material named \"{name}\"{hint}"), ""))
    }

    fn surface(&mut self, name: String, params: Params) -> Result<Material, SceneError> {
        let (_, name, params, supported) = self.check("Material", name, params)?;
        let normal_map = match supported {
            true => self.normal_map(&params)?,
            false => None,
        };
        let materials = match name.as_str() {
            "mix" => Some(self.mixed(&params)?),
            _ => None,
        };
        let Self { library, notices, .. } = self;
        let mut recipe = Recipe { params: &params, library, notices };
        if !supported {
            return Ok(Material::new(recipe.stand_in()));
        }
        let scatters = match materials {
            Some(materials) => Scatters::Mix { materials, amount: recipe.number("amount", 0.5)? },
            None => recipe.scatters(&name)?,
        };
        let bump = match recipe.maybe_number("displacement")? {
            Some(bump) => Some(bump),
            None => recipe.maybe_number("bumpmap")?,
        };
        Ok(Material { scatters, bump, normal_map })
    }

    /// The two materials of a mix; both must have been made, so that none contains itself.
    fn mixed(&mut self, params: &Params) -> Result<[u32; 2], SceneError> {
        let names = match params.texts("materials")? {
            Some([one, other]) => [one, other],
            Some(names) => {
                let found = format!("a mix of {} materials", names.len());
                return Err(params.refuse("materials", found, "expected the names of two"));
            }
            None => {
                let found = "a mix without \"string materials\"";
                return Err(params.refuse("materials", found, "expected the names of two"));
            }
        };
        let mut mixed = [0; 2];
        for (place, name) in mixed.iter_mut().zip(names) {
            *place = match (self.materials.get(name), name.as_str()) {
                (Some(Named { index, promised: None }), _) => *index,
                (_, "interface") => self.builder.material(Material::new(Scatters::Interface)),
                _ => {
                    let made = self.materials.iter().filter(|(_, named)| named.promised.is_none());
                    let hint = hint(name, made.map(|(name, _)| name.as_str()));
                    let found = format!("no material named \"{name}\"{hint}");
                    return Err(params.refuse("materials", found, "a mix needs them made before"));
                }
            };
        }
        Ok(mixed)
    }

    fn normal_map(&mut self, params: &Params) -> Result<Option<ImageMap>, SceneError> {
        // Only a PNG can be linear: pbrt-v4 takes other pictures of 8 bits for sRGB even here.
        let linear = |name: &str| name.to_lowercase().ends_with(".png");
        let srgb = params.text("normalmap")?.is_some_and(|name| !linear(name));
        let picture = self.library.picture(params, "normalmap", &self.folder, srgb)?;
        Ok(picture.map(|picture| ImageMap {
            picture,
            mapping: Mapping::default(),
            wrap: Wrap::Repeat,
            top_down: false,
            scale: 1.0,
            invert: false,
        }))
    }
}

impl Recipe<'_> {
    /// What stands in for a surface that is not supported. Its parameters are not checked: it
    /// may call another thing by the same name.
    fn stand_in(&mut self) -> Scatters {
        let mut found = None;
        for name in ["Kd", "reflectance", "color"] {
            let colour = self.library.colour_or_texture(self.params, name, Meaning::Albedo);
            found = found.or(colour.unwrap_or(None));
        }
        Scatters::Diffuse { reflectance: found.unwrap_or_else(|| super::surfaces::grey(0.5)) }
    }
}
