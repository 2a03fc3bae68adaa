//! Directives in the world: lights, textures and shapes.

use super::blocks::State;
use super::colour::Meaning;
use super::reader::Reader;
use super::textures::{Gives, Request};
use super::{SceneError, shapes};
use crate::scene::{Geometry, Texture};

impl Reader {
    pub(super) fn light_source(&mut self) -> Result<(), SceneError> {
        self.after_world("LightSource")?;
        let (_, name, params, supported) = self.kind("LightSource")?;
        if supported {
            let Self { library, dialect, folder, state, .. } = self;
            let light = library.light(&name, &params, &state.ctm, *dialect, folder)?;
            self.builder.light(light);
        }
        Ok(())
    }

    pub(super) fn area_light(&mut self) -> Result<(), SceneError> {
        self.after_world("AreaLightSource")?;
        let (_, _, params, _) = self.kind("AreaLightSource")?;
        let radiance = params.colour("L", Meaning::Light)?.unwrap_or([1.0; 3]);
        let scale = params.scale()?;
        let two_sided = params.truth("twosided")?.unwrap_or(false);
        self.state.area_light = Some(([0, 1, 2].map(|i| radiance[i] * scale[i]), two_sided));
        Ok(())
    }

    pub(super) fn texture(&mut self) -> Result<(), SceneError> {
        self.after_world("Texture")?;
        let name = self.string()?;
        let kind = self.string()?;
        let gives = match kind.as_str() {
            "float" => Gives::Numbers,
            "color" | "spectrum" | "rgb" => Gives::Colours,
            _ => {
                let found = format!("a texture of type \"{kind}\"");
                return self.refuse(found, "expected float, color or spectrum");
            }
        };
        let (_, class, params, supported) = self.kind("Texture")?;
        let texture = if supported {
            let request = Request {
                class: &class,
                gives,
                params: &params,
                world_from_texture: &self.state.ctm,
                dialect: self.dialect,
            };
            self.library.texture(&request, &mut self.notices)?
        } else {
            Texture::Constant([0.5; 3])
        };
        self.library.textures.insert((gives, name), texture);
        Ok(())
    }

    pub(super) fn shape(&mut self) -> Result<(), SceneError> {
        self.after_world("Shape")?;
        let (_, name, params, supported) = self.kind("Shape")?;
        if !supported {
            return Ok(());
        }
        let State { ctm, reversed, material, area_light, .. } = self.state;
        let Some(geometry) = shapes::make(&name, &params, &ctm, reversed, &self.folder)? else {
            self.warn_here(&format!("a {name} that its transform flattens"), "it is left out");
            return Ok(());
        };
        self.add_shape(geometry, material, area_light);
        Ok(())
    }

    pub(super) fn add_shape(
        &mut self,
        geometry: Geometry,
        material: u32,
        area_light: Option<([f32; 3], bool)>,
    ) {
        let object = self.object.as_ref().and_then(|name| self.objects.get(name));
        let object = object.map(|object| object.index);
        if object.is_some() && area_light.is_some() {
            self.warn_here("an area light inside an object", "the shape does not shine");
        }
        self.builder.shape(geometry, material, area_light, object);
    }
}
