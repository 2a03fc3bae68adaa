//! Textures, materials and lights from their parameters.

use std::collections::HashMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DAffine3, DVec3, Mat3, Vec2};

use super::params::{Params, Values};
use super::vocabulary::UV_INSTEAD;
use super::{Notices, SceneError};
use crate::image::Picture;
use crate::scene::{ImageMap, Light, Mapping, Sky, SkyImage, SkyLayout, Texture, Wrap};

/// Textures that are looked at for one colour.
const MOST_PARTS: usize = 1000;

/// The pictures and textures that a scene file has named so far.
#[derive(Default)]
pub(super) struct Library {
    pictures: HashMap<(PathBuf, bool), Arc<Picture>>,
    /// Textures by name.
    pub(super) textures: HashMap<String, Texture>,
}

/// The dialect of a scene file, where the two read the same words differently.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Dialect {
    /// pbrt-v2.
    V2,
    /// pbrt-v4.
    #[default]
    V4,
}

impl Params {
    /// A colour, if one is given: linear RGB. Spectra are not supported yet: they count as
    /// their mean.
    pub(super) fn colour(
        &self,
        name: &str,
        notices: &mut Notices,
    ) -> Result<Option<[f32; 3]>, SceneError> {
        let Some(param) = self.find(name) else { return Ok(None) };
        let kind = param.kind.as_str();
        let what = format!("a spectrum for \"{name}\"");
        let colour = match (&param.values, kind) {
            (Values::Numbers(v), "rgb") if v.len() == 3 => [v[0], v[1], v[2]],
            (Values::Numbers(v), "float") if v.len() == 1 => [v[0]; 3],
            (Values::Numbers(v), "xyz") if v.len() == 3 => {
                // ITU-R BT.709 primaries, D65.
                [
                    3.240_97 * v[0] - 1.537_383_2 * v[1] - 0.498_610_8 * v[2],
                    -0.969_243_6 * v[0] + 1.875_967_5 * v[1] + 0.041_555 * v[2],
                    0.055_630_1 * v[0] - 0.203_977 * v[1] + 1.056_971_5 * v[2],
                ]
            }
            (Values::Numbers(v), "spectrum") if !v.is_empty() && v.len() % 2 == 0 => {
                notices.instead(&param.at, &what, "it counts as grey of its mean");
                let sum: f64 = v.as_chunks::<2>().0.iter().map(|[_, value]| value).sum();
                [sum / (v.len() / 2) as f64; 3]
            }
            (_, "spectrum" | "blackbody") => {
                notices.instead(&param.at, &what, "it counts as white");
                [1.0; 3]
            }
            _ => return Err(param.wrong(&["rgb", "xyz", "spectrum", "blackbody", "float"])),
        };
        if colour.iter().any(|&c| c < 0.0) && kind != "xyz" {
            let found = format!("a colour below 0 for \"{name}\"");
            return Err(self.refuse(name, found, "expected 0 or more"));
        }
        Ok(Some(colour.map(|c| c as f32)))
    }

    /// The `scale` of a light, by channel: pbrt-v4 gives a number, pbrt-v2 a colour.
    pub(super) fn scale(&self, notices: &mut Notices) -> Result<[f32; 3], SceneError> {
        Ok(self.colour("scale", notices)?.unwrap_or([1.0; 3]))
    }
}

impl Library {
    /// A texture or a colour, if one is given.
    pub(super) fn colour_or_texture(
        &self,
        params: &Params,
        name: &str,
        notices: &mut Notices,
    ) -> Result<Option<Texture>, SceneError> {
        let Some(texture) = params.texture(name)? else {
            return Ok(params.colour(name, notices)?.map(Texture::Constant));
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
    fn picture(
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
        let mut part = |name: &str, default: f32, notices: &mut Notices| {
            let texture = self.colour_or_texture(params, name, notices)?;
            let texture = texture.unwrap_or(Texture::Constant([default; 3]));
            parts += texture.parts();
            if parts > MOST_PARTS {
                let found = format!("a texture of more than {MOST_PARTS} parts");
                return Err(params.refuse(name, found, "textures inside textures multiply"));
            }
            Ok(texture)
        };
        Ok(match class {
            "constant" => part("value", 1.0, notices)?,
            "scale" => {
                let second = if params.find("scale").is_some() { "scale" } else { "tex2" };
                let first = if params.find("tex").is_some() { "tex" } else { "tex1" };
                Texture::Scale(
                    Arc::new(part(first, 1.0, notices)?),
                    Arc::new(part(second, 1.0, notices)?),
                )
            }
            "checkerboard" => {
                let mapping = mapping(params, notices)?;
                if params.float("dimension", 2.0)? != 2.0 {
                    notices.instead(&params.at, "a checkerboard in space", "it is flat, in uv");
                }
                let squares =
                    [Arc::new(part("tex1", 1.0, notices)?), Arc::new(part("tex2", 0.0, notices)?)];
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

    /// Makes a light that is no shape.
    pub(super) fn light(
        &mut self,
        name: &str,
        params: &Params,
        ctm: &DAffine3,
        dialect: Dialect,
        folder: &Path,
        notices: &mut Notices,
    ) -> Result<Light, SceneError> {
        let scale = params.scale(notices)?;
        let mut scaled = |name: &str| -> Result<[f32; 3], SceneError> {
            let colour = params.colour(name, notices)?.unwrap_or([1.0; 3]);
            Ok([0, 1, 2].map(|i| colour[i] * scale[i]))
        };
        let point = |name: &str, default: [f64; 3]| -> Result<DVec3, SceneError> {
            Ok(DVec3::from_array(params.triple(name)?.unwrap_or(default)))
        };
        Ok(match name {
            "point" => Light::Point {
                position: ctm.transform_point3(point("from", [0.0; 3])?).as_vec3(),
                intensity: scaled("I")?,
            },
            "distant" => {
                let towards = point("from", [0.0; 3])? - point("to", [0.0, 0.0, 1.0])?;
                let towards = ctm.transform_vector3(towards).try_normalize().ok_or_else(|| {
                    params.refuse("to", "a distant light from nowhere", "from and to must differ")
                })?;
                Light::Distant { towards: towards.as_vec3(), irradiance: scaled("L")? }
            }
            _ => {
                let radiance = scaled("L")?;
                let file = if params.find("filename").is_some() { "filename" } else { "mapname" };
                let picture = self.picture(params, file, folder, true)?;
                let image = picture.map(|picture| {
                    let flat = picture.size[0] != picture.size[1];
                    let layout = match dialect {
                        Dialect::V4 if !flat => SkyLayout::EqualArea,
                        _ => SkyLayout::Equirectangular,
                    };
                    let linear = ctm.matrix3.inverse().to_cols_array().map(|v| v as f32);
                    let mapping = Mapping { scale: Vec2::ONE, offset: Vec2::ZERO };
                    SkyImage {
                        map: ImageMap {
                            picture,
                            mapping,
                            wrap: Wrap::Clamp,
                            top_down: true,
                            scale: 1.0,
                            invert: false,
                        },
                        light_from_world: Mat3::from_cols_array(&linear),
                        layout,
                    }
                });
                Light::Infinite(Sky { radiance, image })
            }
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
