//! Textures from their parameters.

use std::cell::Cell;
use std::collections::HashMap;
use std::sync::Arc;

use glam::{Affine3A, DAffine3, DVec3, Vec2, Vec3};

use super::colour::Meaning;
use super::params::Params;
use super::pictures::Pictures;
use super::{Dialect, Notices, SceneError};
use crate::image::Transfer;
use crate::scene::{Board, Filter, ImageTexture, Mapping, Texture, Wrap};
use crate::source::{Location, hint};

/// Textures that are looked at for one colour.
const MOST_PARTS: usize = 1000;

/// What a texture gives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) enum Gives {
    Colours,
    Numbers,
}

impl Gives {
    fn name(self) -> &'static str {
        match self {
            Self::Colours => "spectrum",
            Self::Numbers => "float",
        }
    }

    fn other(self) -> Self {
        match self {
            Self::Colours => Self::Numbers,
            Self::Numbers => Self::Colours,
        }
    }
}

/// The pictures and textures that a scene file has named so far.
#[derive(Default)]
pub(super) struct Library {
    pub(super) pictures: Pictures,
    /// Textures of colours and textures of numbers: each has names of its own.
    pub(super) textures: HashMap<(Gives, String), Texture>,
    /// The last texture that was asked for and not there: what was made of it is to be made again.
    pub(super) missing: Cell<Option<Missing>>,
}

/// A texture that is named before it is made.
#[derive(Clone)]
pub(super) struct Missing {
    pub(super) name: String,
    pub(super) gives: Gives,
    /// The place that names it.
    pub(super) at: Location,
}

/// A directive that makes a texture.
pub(super) struct Request {
    pub(super) name: String,
    /// The texture's class, such as "imagemap".
    pub(super) class: String,
    pub(super) gives: Gives,
    pub(super) params: Params,
    /// Texture space to world space.
    pub(super) world_from_texture: DAffine3,
    pub(super) dialect: Dialect,
}

impl Library {
    /// A texture of colours or a colour, if one is given.
    pub(super) fn colour_or_texture(
        &self,
        params: &Params,
        name: &str,
        meaning: Meaning,
    ) -> Result<Option<Texture>, SceneError> {
        match params.texture(name)? {
            Some(texture) => Ok(Some(self.texture_named(params, name, texture, Gives::Colours))),
            None => Ok(params.colour(name, meaning)?.map(Texture::Constant)),
        }
    }

    /// A texture of numbers or a number, if one is given.
    pub(super) fn number_or_texture(
        &self,
        params: &Params,
        name: &str,
    ) -> Result<Option<Texture>, SceneError> {
        match params.texture(name)? {
            Some(texture) => Ok(Some(self.texture_named(params, name, texture, Gives::Numbers))),
            None => Ok(params.maybe_float(name)?.map(|v| Texture::Constant([v as f32; 3]))),
        }
    }

    /// The texture that a parameter names. Where it is not made yet, that is noted, and another
    /// takes its place.
    fn texture_named(&self, params: &Params, name: &str, texture: &str, gives: Gives) -> Texture {
        if let Some(texture) = self.textures.get(&(gives, texture.to_owned())) {
            return texture.clone();
        }
        let at = params.find(name).map_or(&params.at, |param| &param.at).clone();
        self.missing.set(Some(Missing { name: texture.to_owned(), gives, at }));
        Texture::Constant([0.5; 3])
    }

    /// The error for the name of a texture that is never made.
    pub(super) fn no_texture(&self, missing: Missing) -> SceneError {
        let Missing { name, gives, at } = missing;
        let (wanted, other) = (gives.name(), gives.other());
        if self.textures.contains_key(&(other, name.clone())) {
            let found = format!("\"{name}\" is a texture of type {}", other.name());
            return SceneError::at(at, found, format!("expected one of type {wanted}"));
        }
        let names = self.textures.keys().filter(|(of, _)| *of == gives);
        let hint = hint(&name, names.map(|(_, name)| name.as_str()));
        SceneError::at(at, format!("no texture \"{name}\"{hint}"), "")
    }

    /// Makes a texture.
    pub(super) fn texture(
        &mut self,
        request: &Request,
        notices: &mut Notices,
    ) -> Result<Texture, SceneError> {
        let Request { class, gives, params, .. } = request;
        let gives = *gives;
        let one = |name: &str, default: f32, gives: Gives| {
            let texture = match gives {
                Gives::Colours => self.colour_or_texture(params, name, Meaning::Albedo)?,
                Gives::Numbers => self.number_or_texture(params, name)?,
            };
            Ok::<_, SceneError>(texture.unwrap_or(Texture::Constant([default; 3])))
        };
        let pair = |defaults: [f32; 2]| {
            let [first, second] = defaults;
            Ok::<_, SceneError>([
                Arc::new(one("tex1", first, gives)?),
                Arc::new(one("tex2", second, gives)?),
            ])
        };
        let texture = match class.as_str() {
            "constant" => one("value", 1.0, gives)?,
            "scale" => match params.find("tex").or(params.find("scale")) {
                Some(_) => scale(one("tex", 1.0, gives)?, one("scale", 1.0, Gives::Numbers)?),
                // pbrt-v2 multiplies two of a kind.
                None => {
                    let [first, second] = pair([1.0, 1.0])?;
                    Texture::Scale(first, second)
                }
            },
            "mix" => Texture::Mix {
                amount: Arc::new(one("amount", 0.5, Gives::Numbers)?),
                textures: pair([0.0, 1.0])?,
            },
            "directionmix" => {
                let direction = params.triple("dir")?.unwrap_or([0.0, 1.0, 0.0]);
                let direction =
                    request.world_from_texture.transform_vector3(DVec3::from_array(direction));
                let Some(direction) = direction.try_normalize() else {
                    let found = "a direction without length";
                    return Err(params.refuse("dir", found, "expected any other"));
                };
                Texture::DirectionMix {
                    direction: direction.as_vec3(),
                    textures: pair([0.0, 1.0])?,
                }
            }
            "bilerp" => {
                let corner = |name: &str, default: f32| {
                    let colour = match gives {
                        Gives::Colours => params.colour(name, Meaning::Albedo)?,
                        Gives::Numbers => params.maybe_float(name)?.map(|v| [v as f32; 3]),
                    };
                    Ok::<_, SceneError>(colour.unwrap_or([default; 3]))
                };
                let corners = [
                    corner("v00", 0.0)?,
                    corner("v10", 0.0)?,
                    corner("v01", 1.0)?,
                    corner("v11", 1.0)?,
                ];
                Texture::Bilerp { mapping: Arc::new(request.mapping()?), corners }
            }
            "checkerboard" => {
                let board = match params.float("dimension", 2.0)? {
                    2.0 => Board::Squares(request.mapping()?),
                    3.0 => Board::Cubes { texture_from_world: request.texture_from_world()? },
                    other => {
                        let found = format!("a checkerboard of {other} dimensions");
                        return Err(params.refuse("dimension", found, "expected 2 or 3"));
                    }
                };
                Texture::Checkerboard { board: Arc::new(board), textures: pair([1.0, 0.0])? }
            }
            _ => Texture::Image(Arc::new(self.image_texture(request, notices)?)),
        };
        if texture.parts() > MOST_PARTS {
            let found = format!("a texture of more than {MOST_PARTS} parts");
            let expected = "textures inside textures multiply";
            return Err(SceneError::at(params.at.clone(), found, expected));
        }
        Ok(texture)
    }

    fn image_texture(
        &mut self,
        request: &Request,
        notices: &mut Notices,
    ) -> Result<ImageTexture, SceneError> {
        let params = &request.params;
        let transfer = transfer(params)?;
        let Some(picture) = self.pictures.order(params, "filename", transfer)? else {
            return Err(params.refuse("filename", "an imagemap without \"string filename\"", ""));
        };
        let wrap = match params.text("wrap")? {
            None | Some("repeat") => Wrap::Repeat,
            Some("clamp") => Wrap::Clamp,
            Some("black") => Wrap::Black,
            Some("octahedralsphere") => Wrap::OctahedralSphere,
            Some(other) => {
                let found = format!("the wrap mode \"{other}\"");
                let expected = "expected repeat, clamp, black or octahedralsphere";
                return Err(params.refuse("wrap", found, expected));
            }
        };
        let trilinear = params.truth("trilinear")?;
        let filter = match params.text("filter")? {
            // pbrt-v2 filters by ellipses unless told otherwise.
            None if request.dialect == Dialect::V2 || trilinear == Some(true) => Filter::Trilinear,
            None | Some("bilinear") => Filter::Bilinear,
            Some("point") => Filter::Point,
            Some("trilinear") => Filter::Trilinear,
            Some("EWA" | "ewa") => {
                let at = params.find("filter").map_or(&params.at, |param| &param.at);
                notices.instead(at, "the texture filter EWA", "trilinear is used");
                Filter::Trilinear
            }
            Some(other) => {
                let found = format!("the filter \"{other}\"");
                let expected = "expected point, bilinear, trilinear or EWA";
                return Err(params.refuse("filter", found, expected));
            }
        };
        Ok(ImageTexture {
            picture,
            mapping: request.mapping()?,
            wrap,
            filter,
            top_down: request.dialect == Dialect::V2,
            scale: params.float("scale", 1.0)? as f32,
            invert: params.truth("invert")?.unwrap_or(false),
        })
    }
}

/// The product of a texture and a number. Of an image and a constant it is the image with another
/// scale, which is not the same where the image is inverted: so it is in pbrt-v4.
fn scale(texture: Texture, by: Texture) -> Texture {
    match (texture, by) {
        (texture, Texture::Constant([1.0, ..])) => texture,
        (Texture::Image(image), Texture::Constant([by, ..])) => {
            let scale = image.scale * by;
            Texture::Image(Arc::new(ImageTexture { scale, ..Arc::unwrap_or_clone(image) }))
        }
        (texture, by) => Texture::Scale(Arc::new(texture), Arc::new(Texture::Number(Arc::new(by)))),
    }
}

/// How a PNG is to be read.
fn transfer(params: &Params) -> Result<Transfer, SceneError> {
    let gamma = |name: &str, gamma: f64| match gamma > 0.0 && gamma.is_finite() {
        true if gamma == 1.0 => Ok(Transfer::Linear),
        true => Ok(Transfer::Gamma(gamma as f32)),
        false => Err(params.refuse(name, format!("a gamma of {gamma}"), "expected more than 0")),
    };
    match params.text("encoding")? {
        Some("sRGB") => Ok(Transfer::Srgb),
        Some("linear") => Ok(Transfer::Linear),
        Some(other) => match other.strip_prefix("gamma ").map(|rest| rest.trim().parse::<f64>()) {
            Some(Ok(power)) => gamma("encoding", power),
            _ => {
                let found = format!("the encoding \"{other}\"");
                Err(params.refuse("encoding", found, "expected sRGB, linear or \"gamma 2.2\""))
            }
        },
        // Before pbrt-v4, a power or whether it is sRGB.
        None => match params.find("gamma") {
            None => Ok(Transfer::Srgb),
            Some(param) if param.kind == "bool" => match params.truth("gamma")? {
                Some(false) => Ok(Transfer::Linear),
                _ => Ok(Transfer::Srgb),
            },
            Some(_) => gamma("gamma", params.float("gamma", 1.0)?),
        },
    }
}

impl Request {
    /// The key of the texture in the library.
    pub(super) fn key(&self) -> (Gives, String) {
        (self.gives, self.name.clone())
    }

    fn texture_from_world(&self) -> Result<Affine3A, SceneError> {
        let inverse = self.world_from_texture.inverse();
        let single = Affine3A::from_cols_array(&inverse.to_cols_array().map(|v| v as f32));
        match single.is_finite() {
            true => Ok(single),
            false => {
                let found = "a texture in a space that its transform flattens";
                Err(SceneError::at(self.params.at.clone(), found, "expected one with an inverse"))
            }
        }
    }

    fn mapping(&self) -> Result<Mapping, SceneError> {
        let params = &self.params;
        let number = |name: &str, default: f64| params.float(name, default).map(|v| v as f32);
        let offset = Vec2::new(number("udelta", 0.0)?, number("vdelta", 0.0)?);
        let axis = |name: &str, default: [f64; 3]| {
            let axis = params.triple(name)?.unwrap_or(default);
            Ok::<_, SceneError>(Vec3::from_array(axis.map(|v| v as f32)))
        };
        Ok(match params.text("mapping")? {
            None | Some("uv") => {
                let scale = Vec2::new(number("uscale", 1.0)?, number("vscale", 1.0)?);
                Mapping::Uv { scale, offset }
            }
            Some("spherical") => {
                Mapping::Spherical { texture_from_world: self.texture_from_world()? }
            }
            Some("cylindrical") => {
                Mapping::Cylindrical { texture_from_world: self.texture_from_world()? }
            }
            Some("planar") => Mapping::Planar {
                texture_from_world: self.texture_from_world()?,
                axes: [axis("v1", [1.0, 0.0, 0.0])?, axis("v2", [0.0, 1.0, 0.0])?],
                offset,
            },
            Some(other) => {
                let found = format!("the mapping \"{other}\"");
                let expected = "expected uv, spherical, cylindrical or planar";
                return Err(params.refuse("mapping", found, expected));
            }
        })
    }
}
