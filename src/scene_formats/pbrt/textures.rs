//! The Texture directive: kinds of textures and their parameters.

use std::sync::Arc;

use glam::{DAffine3, DVec3};

use super::attributes::Target;
use super::colour::ColourRole;
use super::directive_kinds::{Directive, SILENT, Selected, known, unsupported};
use super::forward_references::Deferred;
use super::params::Params;
use super::reader::SceneReader;
use super::texture_library::{TextureKey, TextureLibrary, TextureType};
use super::{Dialect, SceneError};
use petzval_scene::{CheckerPattern, DotPattern, ImageTexture, SolidPattern, Texture};

/// The kinds of textures.
#[derive(Clone, Copy)]
pub(super) enum TextureKind {
    Constant,
    Scale,
    Mix,
    DirectionMix,
    Bilerp,
    Checkerboard,
    ImageMap,
    Dots,
    Fbm,
    Wrinkled,
    Windy,
    Marble,
}

const UNSUPPORTED: &str = "the constant 0.5 is used";

static TEXTURE: Directive<TextureKind> = Directive {
    name: "Texture",
    target: Some(Target::Texture),
    shared: &[],
    kinds: &[
        known("constant", TextureKind::Constant, &["value"], &[]),
        known("scale", TextureKind::Scale, &["tex1", "tex2", "tex", "scale"], &[]),
        known("mix", TextureKind::Mix, &["tex1", "tex2", "amount"], &[]),
        known("directionmix", TextureKind::DirectionMix, &["tex1", "tex2", "dir"], &[]),
        known(
            "bilerp",
            TextureKind::Bilerp,
            &[
                "v00", "v01", "v10", "v11", "mapping", "uscale", "vscale", "udelta", "vdelta",
                "v1", "v2",
            ],
            &[],
        ),
        known(
            "checkerboard",
            TextureKind::Checkerboard,
            &[
                "tex1",
                "tex2",
                "dimension",
                "mapping",
                "uscale",
                "vscale",
                "udelta",
                "vdelta",
                "v1",
                "v2",
            ],
            &[("aamode", SILENT)],
        ),
        known(
            "imagemap",
            TextureKind::ImageMap,
            &[
                "filename",
                "wrap",
                "filter",
                "trilinear",
                "encoding",
                "gamma",
                "scale",
                "invert",
                "mapping",
                "uscale",
                "vscale",
                "udelta",
                "vdelta",
                "v1",
                "v2",
                "maxanisotropy",
            ],
            &[],
        ),
        known(
            "dots",
            TextureKind::Dots,
            &["inside", "outside", "mapping", "uscale", "vscale", "udelta", "vdelta", "v1", "v2"],
            &[],
        ),
        known("fbm", TextureKind::Fbm, &["octaves", "roughness"], &[]),
        known("wrinkled", TextureKind::Wrinkled, &["octaves", "roughness"], &[]),
        known("windy", TextureKind::Windy, &[], &[]),
        known("marble", TextureKind::Marble, &["octaves", "roughness", "scale", "variation"], &[]),
        unsupported("uv", UNSUPPORTED),
        unsupported("ptex", "the constant 0.5 is used; bake it into an image and use an imagemap"),
    ],
};

/// Limit of the nodes in the tree of a texture, all of which one look-up may evaluate.
const MAX_NODES: usize = 1000;

/// A Texture directive.
pub(super) struct TextureDirective {
    pub(super) name: String,
    kind: TextureKind,
    pub(super) texture_type: TextureType,
    pub(super) params: Params,
    /// Texture space to world space.
    pub(super) world_from_texture: DAffine3,
    pub(super) dialect: Dialect,
}

impl SceneReader {
    pub(super) fn texture(&mut self) -> Result<(), SceneError> {
        self.require_in_world("Texture")?;
        let name = self.string()?;
        let texture_type = match self.string()?.as_str() {
            "float" => TextureType::Float,
            "color" | "spectrum" | "rgb" => TextureType::Spectrum,
            other => {
                let found = format!("a texture of type \"{other}\"");
                return self.refuse(found, "expected float, color or spectrum");
            }
        };
        let Selected { kind, params, .. } = self.select(&TEXTURE)?;
        let Some(kind) = kind else {
            self.library.textures.insert((texture_type, name), Texture::Constant([0.5; 3]));
            return Ok(());
        };
        let world_from_texture = self.state.ctm[0];
        self.define_or_defer(Deferred::Texture(Box::new(TextureDirective {
            name,
            kind,
            texture_type,
            params,
            world_from_texture,
            dialect: self.dialect,
        })))
    }
}

impl TextureLibrary {
    /// Makes a texture.
    pub(super) fn texture(&mut self, directive: &TextureDirective) -> Result<Texture, SceneError> {
        let TextureDirective { kind, texture_type, params, .. } = directive;
        let texture_type = *texture_type;
        let one = |name: &str, default: f32, texture_type: TextureType| {
            let texture = match texture_type {
                TextureType::Spectrum => {
                    self.colour_or_texture(params, name, ColourRole::Albedo)?
                }
                TextureType::Float => self.number_or_texture(params, name)?,
            };
            Ok::<_, SceneError>(texture.unwrap_or(Texture::Constant([default; 3])))
        };
        let pair = |defaults: [f32; 2]| {
            let [first, second] = defaults;
            Ok::<_, SceneError>([
                Arc::new(one("tex1", first, texture_type)?),
                Arc::new(one("tex2", second, texture_type)?),
            ])
        };
        let texture = match kind {
            TextureKind::Constant => one("value", 1.0, texture_type)?,
            TextureKind::Scale => match params.find("tex").or(params.find("scale")) {
                Some(_) => {
                    let texture = one("tex", 1.0, texture_type)?;
                    scale(texture, one("scale", 1.0, TextureType::Float)?)
                }
                // pbrt-v2 multiplies two textures of the same type.
                None => {
                    let [first, second] = pair([1.0, 1.0])?;
                    Texture::Scale(first, second)
                }
            },
            TextureKind::Mix => Texture::Mix {
                amount: Arc::new(one("amount", 0.5, TextureType::Float)?),
                textures: pair([0.0, 1.0])?,
            },
            TextureKind::DirectionMix => {
                let direction = params.triple("dir")?.unwrap_or([0.0, 1.0, 0.0]);
                let direction =
                    directive.world_from_texture.transform_vector3(DVec3::from_array(direction));
                let Some(direction) = direction.try_normalize() else {
                    let found = "a direction of length 0";
                    return Err(params.refuse("dir", found, "give another one"));
                };
                Texture::DirectionMix {
                    direction: direction.as_vec3(),
                    textures: pair([0.0, 1.0])?,
                }
            }
            TextureKind::Bilerp => {
                let corner = |name: &str, default: f32| {
                    let colour = match texture_type {
                        TextureType::Spectrum => params.colour(name, ColourRole::Albedo)?,
                        TextureType::Float => params.maybe_float(name)?.map(|v| [v as f32; 3]),
                    };
                    Ok::<_, SceneError>(colour.unwrap_or([default; 3]))
                };
                let corners = [
                    corner("v00", 0.0)?,
                    corner("v10", 0.0)?,
                    corner("v01", 1.0)?,
                    corner("v11", 1.0)?,
                ];
                Texture::Bilerp { mapping: Arc::new(directive.mapping()?), corners }
            }
            TextureKind::Checkerboard => {
                let pattern = match params.float("dimension", 2.0)? {
                    2.0 => CheckerPattern::Squares(directive.mapping()?),
                    3.0 => {
                        let texture_from_world = directive.texture_from_world()?;
                        CheckerPattern::Cubes { texture_from_world }
                    }
                    other => {
                        let found = format!("a checkerboard of {other} dimensions");
                        return Err(params.refuse("dimension", found, "expected 2 or 3"));
                    }
                };
                Texture::Checkerboard { pattern: Arc::new(pattern), textures: pair([1.0, 0.0])? }
            }
            TextureKind::ImageMap => Texture::Image(Arc::new(self.image_texture(directive)?)),
            TextureKind::Dots => {
                let pattern = Arc::new(DotPattern { mapping: directive.mapping()? });
                // pbrt gives the dots the texture "outside", in all versions.
                let around = Arc::new(one("inside", 1.0, texture_type)?);
                let dots = Arc::new(one("outside", 0.0, texture_type)?);
                Texture::Dots { pattern, textures: [around, dots] }
            }
            TextureKind::Fbm => directive.solid(SolidPattern::Fbm(directive.octaves()?))?,
            TextureKind::Wrinkled => {
                directive.solid(SolidPattern::Wrinkled(directive.octaves()?))?
            }
            TextureKind::Windy => directive.solid(SolidPattern::Windy)?,
            TextureKind::Marble => directive.marble()?,
        };
        if texture.node_count() > MAX_NODES {
            let found = format!("a texture of more than {MAX_NODES} parts");
            let expected = "use fewer nested textures: their numbers multiply";
            return Err(SceneError::at(params.at.clone(), found, expected));
        }
        Ok(texture)
    }
}

/// Returns the product of a texture and a number. As in pbrt-v4, an image times a constant is the
/// image with another scale, which differs from the product if the image is inverted.
fn scale(texture: Texture, factor: Texture) -> Texture {
    match (texture, factor) {
        (texture, Texture::Constant([1.0, ..])) => texture,
        (Texture::Image(image), Texture::Constant([factor, ..])) => {
            let scale = image.scale * factor;
            Texture::Image(Arc::new(ImageTexture { scale, ..Arc::unwrap_or_clone(image) }))
        }
        (texture, factor) => {
            Texture::Scale(Arc::new(texture), Arc::new(Texture::Scalar(Arc::new(factor))))
        }
    }
}

impl TextureDirective {
    /// Returns the key of the texture in the library.
    pub(super) fn key(&self) -> TextureKey {
        (self.texture_type, self.name.clone())
    }
}
