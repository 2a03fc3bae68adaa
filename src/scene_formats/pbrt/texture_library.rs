//! Library of the textures and images of a scene, and look-up of those that parameters name.

use std::cell::Cell;
use std::collections::HashMap;

use super::colour::ColourRole;
use super::image_files::ImageFiles;
use super::params::Params;
use super::{SceneError, suggestion_or};
use petzval_base::io::{Location, hint};
use petzval_scene::Texture;

/// The types of values that a texture has.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum TextureType {
    Spectrum,
    Float,
}

impl TextureType {
    fn name(self) -> &'static str {
        match self {
            Self::Spectrum => "spectrum",
            Self::Float => "float",
        }
    }

    fn other(self) -> Self {
        match self {
            Self::Spectrum => Self::Float,
            Self::Float => Self::Spectrum,
        }
    }
}

/// The images and textures that a scene has defined so far.
#[derive(Default)]
pub(super) struct TextureLibrary {
    pub(super) image_files: ImageFiles,
    /// Textures by type and name: each type has names of its own.
    pub(super) textures: HashMap<TextureKey, Texture>,
    /// The last texture that was looked up and is not defined yet. Whatever was made with its
    /// placeholder must be made again.
    pub(super) missing: Cell<Option<MissingTexture>>,
}

/// The type and name of a texture.
pub(super) type TextureKey = (TextureType, String);

/// A use of a texture that is not defined yet.
#[derive(Clone)]
pub(super) struct MissingTexture {
    pub(super) name: String,
    pub(super) texture_type: TextureType,
    /// The location of the use.
    pub(super) at: Location,
}

impl TextureLibrary {
    /// Returns a texture of colours or a colour, if it is given.
    pub(super) fn colour_or_texture(
        &self,
        params: &Params,
        name: &str,
        role: ColourRole,
    ) -> Result<Option<Texture>, SceneError> {
        match params.texture(name)? {
            Some(texture) => Ok(Some(self.look_up(params, name, texture, TextureType::Spectrum))),
            None => Ok(params.spectral_colour(name, role)?.map(Texture::from)),
        }
    }

    /// Returns a texture of numbers or a number, if it is given.
    pub(super) fn number_or_texture(
        &self,
        params: &Params,
        name: &str,
    ) -> Result<Option<Texture>, SceneError> {
        match params.texture(name)? {
            Some(texture) => Ok(Some(self.look_up(params, name, texture, TextureType::Float))),
            None => Ok(params.maybe_float(name)?.map(|v| Texture::Constant([v as f32; 3]))),
        }
    }

    /// Returns the texture that a parameter names. If it is not defined yet, sets `missing` and
    /// returns a placeholder.
    fn look_up(
        &self,
        params: &Params,
        name: &str,
        texture: &str,
        texture_type: TextureType,
    ) -> Texture {
        if let Some(texture) = self.textures.get(&(texture_type, texture.to_owned())) {
            return texture.clone();
        }
        let (name, at) = (texture.to_owned(), params.location(name));
        self.missing.set(Some(MissingTexture { name, texture_type, at }));
        Texture::Constant([0.5; 3])
    }

    /// Returns the error for the name of a texture that is never defined.
    pub(super) fn undefined(&self, missing: MissingTexture) -> SceneError {
        let MissingTexture { name, texture_type, at } = missing;
        let (wanted, other) = (texture_type.name(), texture_type.other());
        if self.textures.contains_key(&(other, name.clone())) {
            let found = format!("\"{name}\" is a texture of type {}", other.name());
            return SceneError::at(at, found, format!("expected one of type {wanted}"));
        }
        let names = self.textures.keys().filter(|(defined, _)| *defined == texture_type);
        let hint = hint(&name, names.map(|(_, name)| name.as_str()));
        let expected = format!("expected a name that Texture defines with type {wanted}");
        let behind = suggestion_or(hint, &expected);
        SceneError::at(at, format!("no texture \"{name}\"{behind}"), "")
    }
}
