//! Directives in the world: lights, textures and shapes.

use super::blocks::State;
use super::forward::Waiting;
use super::reader::Reader;
use super::textures::{Gives, Request};
use super::{SceneError, shapes};
use crate::scene::{Geometry, ShapeSpec, Texture};

/// Triangles that the bilinear patches of a scene may become, unless there are more uncut. Each mesh may
/// take half of what is left: then the tolerance gives way.
const MOST_OF_PATCHES: u64 = 1 << 21;

impl Reader {
    pub(super) fn light_source(&mut self) -> Result<(), SceneError> {
        self.after_world("LightSource")?;
        let (_, name, params, supported) = self.kind("LightSource")?;
        if supported {
            let ctm = self.fixed_place(&format!("a {name} light"));
            let Self { library, dialect, folder, .. } = self;
            let light = library.light(&name, &params, &ctm, *dialect, folder)?;
            self.builder.light(light);
        }
        Ok(())
    }

    pub(super) fn area_light(&mut self) -> Result<(), SceneError> {
        self.after_world("AreaLightSource")?;
        let (_, _, params, _) = self.kind("AreaLightSource")?;
        let Self { library, folder, .. } = self;
        self.state.area_light = Some(library.emission(&params, folder)?);
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
        if !supported {
            self.library.textures.insert((gives, name), Texture::Constant([0.5; 3]));
            return Ok(());
        }
        let world_from_texture = self.state.ctm[0];
        self.now_or_later(Waiting::Texture(Box::new(Request {
            name,
            class,
            gives,
            params,
            world_from_texture,
            dialect: self.dialect,
        })))
    }

    pub(super) fn shape(&mut self) -> Result<(), SceneError> {
        self.after_world("Shape")?;
        let (_, name, mut params, supported) = self.kind("Shape")?;
        if !supported {
            return Ok(());
        }
        let Some((object, ctm)) = self.shape_place(&name) else { return Ok(()) };
        let State { reversed, material, area_light, .. } = self.state.clone();
        let Self { notices, folder, of_patches, .. } = self;
        let parts = {
            let left = MOST_OF_PATCHES.saturating_sub(*of_patches);
            shapes::make(&name, &params, &ctm, reversed, folder, left / 2, notices)?
        };
        let mut shapes = Vec::new();
        for geometry in parts {
            if let Geometry::Mesh(mesh) = &geometry {
                self.of_patches += mesh.patches.len() as u64;
            }
            self.claim_shape(&name, object.or(self.open_object()), &geometry)?;
            shapes.push(self.add_shape(ShapeSpec {
                emission: area_light.clone(),
                object,
                ..ShapeSpec::new(geometry, material)
            }));
        }
        // A mesh need not wait with its vertices.
        params.all.retain(|param| param.name == "alpha");
        match params.all.is_empty() {
            true => Ok(()),
            false => self.now_or_later(Waiting::Alpha { shapes, params }),
        }
    }

    /// The object that is open.
    fn open_object(&self) -> Option<u32> {
        let open = self.object.as_ref().and_then(|name| self.objects.get(name));
        open.map(|open| open.index)
    }

    fn add_shape(&mut self, spec: ShapeSpec) -> u32 {
        let object = spec.object.or(self.open_object());
        if object.is_some() && spec.emission.is_some() {
            self.warn_here("an area light inside an object", "the shape does not shine");
        }
        let shines = spec.emission.is_some();
        let shape = self.builder.shape(ShapeSpec { object, ..spec });
        if shines {
            self.emitters.push((shape, self.at.clone()));
        }
        shape
    }
}
