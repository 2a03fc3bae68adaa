//! Textures of materials: an image with its wrapping, filter and placement.

use std::sync::Arc;

use glam::{Mat2, Vec2};
use gltf_json::Index;
use gltf_json::extensions::texture::TextureTransform;
use gltf_json::texture::{Info, MagFilter, Texture as TextureJson, WrappingMode};
use gltf_json::validation::Checked;

use super::document::Document;
use super::images::{Channels, Images};
use crate::scene::pbrt::SceneError;
use crate::scene::{ImageMap, ImageTexture, Mapping, Texture, TextureFilter, Wrap};

/// Largest ratio of the axes of the ellipse over which a texture is averaged.
const MAX_ANISOTROPY: f32 = 8.0;

/// A use of a texture by a material.
pub(super) struct TextureUse<'a> {
    pub index: Index<TextureJson>,
    pub tex_coord: u32,
    pub transform: Option<&'a TextureTransform>,
    /// The element that names it.
    pub element: String,
}

impl<'a> TextureUse<'a> {
    pub fn new(info: &'a Info, element: String) -> Self {
        let extensions = info.extensions.as_ref();
        Self {
            index: info.index,
            tex_coord: info.tex_coord,
            transform: extensions.and_then(|extensions| extensions.texture_transform.as_ref()),
            element,
        }
    }

    /// Returns the set of texture coordinates.
    pub fn set(&self) -> u32 {
        self.transform.and_then(|transform| transform.tex_coord).unwrap_or(self.tex_coord)
    }

    fn mapping(&self) -> Mapping {
        let Some(transform) = self.transform else { return Mapping::default() };
        let [scale, offset] = [transform.scale.0, transform.offset.0].map(Vec2::from);
        match transform.rotation.0 {
            0.0 => Mapping::Uv { scale, offset },
            // v grows downwards, so that the angle turns the coordinates the other way.
            angle => Mapping::UvMatrix {
                matrix: Mat2::from_angle(-angle) * Mat2::from_diagonal(scale),
                offset,
            },
        }
    }
}

/// The image of a texture, and how it continues beyond its edges.
struct Sampled {
    image: usize,
    wrap: Wrap,
    nearest: bool,
}

fn sampled(document: &Document, texture: &TextureUse) -> Result<Sampled, SceneError> {
    let TextureUse { index, element, .. } = texture;
    let textures = &document.root.textures;
    let texture = document.entry(textures, index.value(), "textures", element)?;
    let named_at = format!("textures/{}/source", index.value());
    let image = texture.source.value();
    document.entry(&document.root.images, image, "images", &named_at)?;
    let Some(sampler) = texture.sampler else {
        return Ok(Sampled { image, wrap: Wrap::Repeat, nearest: false });
    };
    let named_at = format!("textures/{}/sampler", index.value());
    let sampler =
        document.entry(&document.root.samplers, sampler.value(), "samplers", &named_at)?;
    let wrap = match (sampler.wrap_s, sampler.wrap_t) {
        (Checked::Valid(WrappingMode::ClampToEdge), Checked::Valid(WrappingMode::ClampToEdge)) => {
            Wrap::Clamp
        }
        (Checked::Valid(WrappingMode::Repeat), Checked::Valid(WrappingMode::Repeat)) => {
            Wrap::Repeat
        }
        _ => {
            let message = "textures that repeat mirrored, or along one axis only, are not read: \
                           they repeat along both";
            document.warn(&named_at, message);
            Wrap::Repeat
        }
    };
    let nearest = matches!(sampler.mag_filter, Some(Checked::Valid(MagFilter::Nearest)));
    Ok(Sampled { image, wrap, nearest })
}

/// Returns a texture of some channels of an image, times a factor.
pub(super) fn image_texture(
    document: &Document,
    images: &mut Images,
    texture: &TextureUse,
    channels: Channels,
    scale: f32,
) -> Result<Texture, SceneError> {
    let Sampled { image, wrap, nearest } = sampled(document, texture)?;
    Ok(Texture::Image(Arc::new(ImageTexture {
        picture: images.mipmap(document, image, channels)?,
        mapping: texture.mapping(),
        wrap,
        filter: if nearest { TextureFilter::Point } else { TextureFilter::Trilinear },
        max_anisotropy: (!nearest).then_some(MAX_ANISOTROPY),
        top_down: true,
        scale,
        invert: false,
    })))
}

/// Returns an image in floats. `change` is applied to every pixel: to its colour, or to its signals
/// if `linear`.
pub(super) fn image_map(
    document: &Document,
    images: &mut Images,
    texture: &TextureUse,
    linear: bool,
    change: impl Fn([f32; 3]) -> [f32; 3],
) -> Result<ImageMap, SceneError> {
    let Sampled { image, wrap, .. } = sampled(document, texture)?;
    let mut picture = images.picture(document, image, linear)?;
    picture.pixels.iter_mut().for_each(|pixel| *pixel = change(*pixel));
    Ok(ImageMap {
        picture: Arc::new(picture),
        mapping: texture.mapping(),
        wrap,
        top_down: true,
        scale: 1.0,
        invert: false,
    })
}
