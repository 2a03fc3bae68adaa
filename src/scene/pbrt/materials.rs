//! Materials, named and in place: the directives. What a kind of material reads is in
//! [`super::surfaces`].

use super::SceneError;
use super::colour::Meaning;
use super::forward::Waiting;
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
    /// Mixes inside each other, itself counted.
    pub(super) mixes: u32,
}

/// A material as far as it is known before its textures are.
pub(super) struct Draft {
    name: String,
    params: Params,
    supported: bool,
    normal_map: Option<ImageMap>,
    materials: Option<[u32; 2]>,
    mixes: u32,
}

/// Mixes of mixes that a surface may be made of: at each one every ray draws a random number.
const MOST_MIXES: u32 = 64;

impl Reader {
    pub(super) fn material(&mut self) -> Result<(), SceneError> {
        self.after_world("Material")?;
        let name = self.string()?;
        let params = self.params()?;
        let draft = self.draft(name, params, false)?;
        let index = self.builder.material(Material::diffuse([0.5; 3]));
        self.state.material = index;
        self.now_or_later(Waiting::Material { index, draft })
    }

    pub(super) fn make_named_material(&mut self) -> Result<(), SceneError> {
        self.after_world("MakeNamedMaterial")?;
        let name = self.string()?;
        let mut params = self.params()?;
        let Some(kind) = params.text("type")?.map(str::to_owned) else {
            return self.refuse("a named material without \"string type\"", "");
        };
        params.all.retain(|param| param.name != "type");
        let draft = self.draft(kind, params, true)?;
        let index = match self.materials.get(&name) {
            Some(Named { index, promised: Some(_), .. }) => *index,
            _ => self.builder.material(Material::diffuse([0.5; 3])),
        };
        let mixes = draft.mixes;
        self.materials.insert(name, Named { index, promised: None, mixes });
        self.now_or_later(Waiting::Material { index, draft })
    }

    /// Names may be used before they are made: pbrt-v4 looks them up when the file has ended.
    pub(super) fn named_material(&mut self) -> Result<(), SceneError> {
        self.after_world("NamedMaterial")?;
        let name = self.string()?;
        let at = self.at.clone();
        self.state.material = self.promised(name, &at);
        Ok(())
    }

    /// The index of a material that is made before or after this.
    fn promised(&mut self, name: String, at: &Location) -> u32 {
        let Self { materials, builder, .. } = self;
        let named = materials.entry(name).or_insert_with(|| Named {
            index: builder.material(Material::diffuse([0.5; 3])),
            promised: Some(at.clone()),
            mixes: 0,
        });
        named.index
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

    /// Checks a material, which is [`named`](Self::make_named_material) or in place.
    fn draft(&mut self, name: String, params: Params, named: bool) -> Result<Draft, SceneError> {
        let (_, name, params, supported) = self.check("Material", name, params)?;
        let normal_map = match supported {
            true => self.normal_map(&params)?,
            false => None,
        };
        let (materials, mixes) = match name.as_str() {
            "mix" => self.mixed(&params, named).map(|(mixed, depth)| (Some(mixed), depth))?,
            _ => (None, 0),
        };
        Ok(Draft { name, params, supported, normal_map, materials, mixes })
    }

    /// Makes a material of what is known of it and of its textures.
    pub(super) fn surface(&mut self, draft: &Draft) -> Result<Material, SceneError> {
        let Draft { name, params, supported, materials, .. } = draft;
        let Self { library, notices, .. } = self;
        let mut recipe = Recipe { params, library, notices };
        if !supported {
            return Ok(Material::new(recipe.stand_in()));
        }
        let scatters = match *materials {
            Some(materials) => Scatters::Mix { materials, amount: recipe.number("amount", 0.5)? },
            None => recipe.scatters(name)?,
        };
        let bump = match recipe.maybe_number("displacement")? {
            Some(bump) => Some(bump),
            None => recipe.maybe_number("bumpmap")?,
        };
        Ok(Material { scatters, bump, normal_map: draft.normal_map.clone() })
    }

    /// The two materials of a mix, and how many mixes that makes inside each other. Those of a named
    /// one must have been made, so that none contains itself: as in pbrt-v4.
    fn mixed(&mut self, params: &Params, named: bool) -> Result<([u32; 2], u32), SceneError> {
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
        let at = params.find("materials").map_or(&params.at, |param| &param.at);
        let (mut mixed, mut depth) = ([0; 2], 1);
        for (place, name) in mixed.iter_mut().zip(names) {
            *place = match (self.materials.get(name), name.as_str()) {
                (Some(Named { index, promised: None, mixes }), _) => {
                    depth = depth.max(mixes + 1);
                    *index
                }
                (_, "interface") => self.builder.material(Material::new(Scatters::Interface)),
                _ if !named => self.promised(name.clone(), at),
                _ => {
                    let made = self.materials.iter().filter(|(_, named)| named.promised.is_none());
                    let hint = hint(name, made.map(|(name, _)| name.as_str()));
                    let found = format!("no material named \"{name}\"{hint}");
                    return Err(params.refuse("materials", found, "a mix needs them made before"));
                }
            };
        }
        if depth > MOST_MIXES {
            let found = format!("a mix of {depth} mixes inside each other");
            return Err(params.refuse("materials", found, "expected at most 64: mix fewer"));
        }
        Ok((mixed, depth))
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
