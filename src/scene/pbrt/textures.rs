//! Textures and pictures from their parameters.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::Vec2;

use super::colour::Meaning;
use super::params::Params;
use super::vocabulary::UV_INSTEAD;
use super::{Dialect, Notices, SceneError};
use crate::image::Picture;
use crate::scene::{ImageMap, Mapping, Texture, Wrap};

/// Textures that are looked at for one colour.
const MOST_PARTS: usize = 1000;

/// The pictures and textures that a scene file has named so far.
#[derive(Default)]
pub(super) struct Library {
    pictures: HashMap<(PathBuf, bool), Arc<Picture>>,
    /// Textures by name.
    pub(super) textures: HashMap<String, Texture>,
}

impl Library {
    /// A texture or a colour, if one is given.
    pub(super) fn colour_or_texture(
        &self,
        params: &Params,
        name: &str,
        meaning: Meaning,
    ) -> Result<Option<Texture>, SceneError> {
        let Some(texture) = params.texture(name)? else {
            return Ok(params.colour(name, meaning)?.map(Texture::Constant));
        };
        match self.textures.get(texture) {
            Some(texture) => Ok(Some(texture.clone())),
            None => {
                let names = self.textures.keys().map(String::as_str);
                let hint = crate::source::hint(texture, names);
                Err(params.refuse(name, format!("no texture \"{texture}\"{hint}"), ""))
            }
        }
    }

    /// A picture that a parameter names, read once.
    pub(super) fn picture(
        &mut self,
        params: &Params,
        name: &str,
        folder: &Path,
        srgb: bool,
    ) -> Result<Option<Arc<Picture>>, SceneError> {
        let Some(file) = params.text(name)? else { return Ok(None) };
        let path = folder.join(file);
        if let Some(picture) = self.pictures.get(&(path.clone(), srgb)) {
            return Ok(Some(picture.clone()));
        }
        let picture = Picture::read(&path, srgb).map_err(|source| {
            let at = params.find(name).map_or(&params.at, |param| &param.at);
            SceneError::Image { at: at.clone(), source }
        })?;
        if picture.pixels.is_empty() {
            return Err(params.refuse(name, "a picture without pixels", ""));
        }
        let picture = Arc::new(picture);
        self.pictures.insert((path, srgb), picture.clone());
        Ok(Some(picture))
    }

    /// Makes a texture of a class.
    pub(super) fn texture(
        &mut self,
        class: &str,
        params: &Params,
        dialect: Dialect,
        folder: &Path,
        notices: &mut Notices,
    ) -> Result<Texture, SceneError> {
        let mut parts = 1;
        let mut part = |name: &str, default: f32| {
            let texture = self.colour_or_texture(params, name, Meaning::Albedo)?;
            let texture = texture.unwrap_or(Texture::Constant([default; 3]));
            parts += texture.parts();
            if parts > MOST_PARTS {
                let found = format!("a texture of more than {MOST_PARTS} parts");
                return Err(params.refuse(name, found, "textures inside textures multiply"));
            }
            Ok(texture)
        };
        Ok(match class {
            "constant" => part("value", 1.0)?,
            "scale" => {
                let second = if params.find("scale").is_some() { "scale" } else { "tex2" };
                let first = if params.find("tex").is_some() { "tex" } else { "tex1" };
                Texture::Scale(Arc::new(part(first, 1.0)?), Arc::new(part(second, 1.0)?))
            }
            "checkerboard" => {
                let mapping = mapping(params, notices)?;
                if params.float("dimension", 2.0)? != 2.0 {
                    notices.instead(&params.at, "a checkerboard in space", "it is flat, in uv");
                }
                let squares = [Arc::new(part("tex1", 1.0)?), Arc::new(part("tex2", 0.0)?)];
                Texture::Checkerboard { mapping, squares }
            }
            _ => Texture::Image(self.image_map(params, dialect, folder, notices)?),
        })
    }

    fn image_map(
        &mut self,
        params: &Params,
        dialect: Dialect,
        folder: &Path,
        notices: &mut Notices,
    ) -> Result<ImageMap, SceneError> {
        let gamma = params.float("gamma", 1.0)?;
        let srgb = match params.text("encoding")? {
            Some("linear") => false,
            None if gamma == 1.0 && params.find("gamma").is_some() => false,
            None | Some("sRGB") if gamma == 1.0 => true,
            _ => {
                notices.instead(&params.at, "a picture with a gamma", "sRGB is used");
                true
            }
        };
        let Some(picture) = self.picture(params, "filename", folder, srgb)? else {
            return Err(params.refuse("filename", "an imagemap without \"string filename\"", ""));
        };
        let wrap = match params.text("wrap")? {
            None | Some("repeat") => Wrap::Repeat,
            Some("clamp") => Wrap::Clamp,
            Some("black") => Wrap::Black,
            Some("octahedralsphere") => {
                notices.instead(&params.at, "the wrap mode octahedralsphere", "repeat is used");
                Wrap::Repeat
            }
            Some(other) => {
                let found = format!("the wrap mode \"{other}\"");
                return Err(params.refuse("wrap", found, "expected repeat, clamp or black"));
            }
        };
        Ok(ImageMap {
            picture,
            mapping: mapping(params, notices)?,
            wrap,
            top_down: dialect == Dialect::V2,
            scale: params.float("scale", 1.0)? as f32,
            invert: params.truth("invert")?.unwrap_or(false),
        })
    }
}

fn mapping(params: &Params, notices: &mut Notices) -> Result<Mapping, SceneError> {
    match params.text("mapping")? {
        None | Some("uv") => {}
        Some(kind @ ("spherical" | "cylindrical" | "planar")) => {
            notices.instead(&params.at, &format!("the mapping \"{kind}\""), UV_INSTEAD);
        }
        Some(other) => {
            let found = format!("the mapping \"{other}\"");
            let expected = "expected uv, spherical, cylindrical or planar";
            return Err(params.refuse("mapping", found, expected));
        }
    }
    let number = |name: &str, default: f64| params.float(name, default).map(|v| v as f32);
    Ok(Mapping {
        scale: Vec2::new(number("uscale", 1.0)?, number("vscale", 1.0)?),
        offset: Vec2::new(number("udelta", 0.0)?, number("vdelta", 0.0)?),
    })
}
