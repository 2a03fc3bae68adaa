//! Textures of materials: an image with its wrapping, filter and placement.

use std::sync::Arc;

use glam::{Mat2, Vec2};

use super::document::Document;
use super::images::{Channels, Images};
use super::schema::{Index, Integer, TextureInfo, TextureTransform};
use crate::pbrt::SceneError;
use petzval_scene::{ImageMap, ImageTexture, Mapping, Texture, TextureFilter, Wrap};

/// Largest ratio of the axes of the ellipse over which a texture is averaged.
const MAX_ANISOTROPY: f32 = 8.0;

/// Codes of samplers.
const NEAREST: u64 = 9728;
const REPEAT: u64 = 10_497;
const CLAMP_TO_EDGE: u64 = 33_071;

/// A use of a texture by a material.
pub(super) struct TextureUse<'a> {
    index: Index,
    tex_coord: u32,
    transform: Option<&'a TextureTransform>,
    /// The element that names it.
    element: String,
}

impl<'a> TextureUse<'a> {
    pub fn new(info: &'a TextureInfo, element: String) -> Self {
        let extensions = info.extensions.as_ref();
        Self {
            index: info.index,
            tex_coord: info.tex_coord.0,
            transform: extensions.and_then(|extensions| extensions.transform.as_ref()),
            element,
        }
    }

    /// Returns the set of texture coordinates.
    pub fn set(&self) -> u32 {
        self.transform.and_then(|transform| transform.tex_coord).map_or(self.tex_coord, |set| set.0)
    }

    fn mapping(&self) -> Mapping {
        let Some(transform) = self.transform else { return Mapping::default() };
        let [scale, offset] = [transform.scale, transform.offset].map(Vec2::from);
        match transform.rotation {
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
    let Some(image) = texture.source else {
        let expected = "expected the index of one";
        return Err(document.error(&named_at, "a texture without an image", expected));
    };
    let image = image.value();
    document.entry(&document.root.images, image, "images", &named_at)?;
    let Some(sampler) = texture.sampler else {
        return Ok(Sampled { image, wrap: Wrap::Repeat, nearest: false });
    };
    let named_at = format!("textures/{}/sampler", index.value());
    let sampler =
        document.entry(&document.root.samplers, sampler.value(), "samplers", &named_at)?;
    let code = |wrap: Option<Integer>| wrap.map_or(REPEAT, |code| code.0);
    let wrap = match [sampler.wrap_s, sampler.wrap_t].map(code) {
        [CLAMP_TO_EDGE, CLAMP_TO_EDGE] => Wrap::Clamp,
        [REPEAT, REPEAT] => Wrap::Repeat,
        _ => {
            let message = "textures that repeat mirrored, or along one axis only, are not read: \
                           they repeat along both";
            document.warn(&named_at, message);
            Wrap::Repeat
        }
    };
    let nearest = sampler.mag_filter == Some(Integer(NEAREST));
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
