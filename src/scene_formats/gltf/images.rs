//! Images of a document, each decoded once and unpacked for each use.

use std::collections::HashMap;
use std::path::PathBuf;
use std::sync::Arc;

use image::DynamicImage;

use super::document::Document;
use super::schema::Image;
use crate::pbrt::SceneError;
use petzval_base::io::HeldMemory;
use petzval_image::{ImageSamples, Picture, Raster, Transfer, decode_image};
use petzval_scene::{MipMap, PendingImage};

/// What a surface takes from an image.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum Channels {
    /// Red, green and blue, encoded as sRGB.
    Colour,
    /// Opacity.
    Alpha,
    /// Whether the opacity, times a factor, is at least a cutoff.
    Mask {
        /// Factor and cutoff.
        factor: f32,
        cutoff: f32,
    },
    /// One of the four channels, with its curve.
    Single(usize, Transfer),
}

/// The decoded images, and what is made of them.
#[derive(Default)]
pub(super) struct Images {
    decoded: HashMap<usize, (Arc<DynamicImage>, HeldMemory)>,
    unpacked: Vec<(usize, Channels, PendingImage)>,
}

impl Images {
    /// Returns channels of an image at every scale.
    pub fn mipmap(
        &mut self,
        document: &Document,
        image: usize,
        channels: Channels,
    ) -> Result<PendingImage, SceneError> {
        let known = self.unpacked.iter().find(|(i, c, _)| (*i, *c) == (image, channels));
        if let Some((_, _, made)) = known {
            return Ok(made.clone());
        }
        let decoded = self.decode(document, image)?;
        let element = format!("images/{image}");
        let refused = |found: String| document.too_large(&element, &found);
        let size = [decoded.width() as usize, decoded.height() as usize];
        let (picked, _) = picked(channels);
        let floats = is_deep(&decoded) && !matches!(channels, Channels::Mask { .. });
        let [coarse, working] = MipMap::more_bytes(size, picked.len(), floats);
        let pixels = size[0] as u64 * size[1] as u64;
        let kept = coarse + pixels * picked.len() as u64 * if floats { 4 } else { 1 };
        // All channels, in 8 bits or floats, before some are picked.
        let all = pixels * if matches!(channels, Channels::Mask { .. }) || floats { 16 } else { 4 };
        let held = document.context.hold(kept + working.max(all)).map_err(refused)?;
        let made = PendingImage::from(MipMap::new(unpack(&decoded, channels)));
        held.keep(kept).map_err(refused)?;
        self.unpacked.push((image, channels, made.clone()));
        Ok(made)
    }

    /// Returns an image in floats: its colours, or its signals if `linear`.
    pub fn picture(
        &mut self,
        document: &Document,
        image: usize,
        linear: bool,
    ) -> Result<Picture, SceneError> {
        let decoded = self.decode(document, image)?;
        let element = format!("images/{image}");
        let refused = |found: String| document.too_large(&element, &found);
        // Signals, and their light.
        let bytes = 12 * u64::from(decoded.width()) * u64::from(decoded.height());
        let held = document.context.hold(2 * bytes).map_err(refused)?;
        let transfer = if linear { Transfer::Linear } else { Transfer::Srgb };
        let pixels = decoded.to_rgb32f();
        let picture = Picture {
            size: [pixels.width() as usize, pixels.height() as usize],
            pixels: pixels.pixels().map(|p| p.0.map(|v| transfer.decode(v))).collect(),
        };
        held.keep(bytes).map_err(refused)?;
        Ok(picture)
    }

    fn decode(
        &mut self,
        document: &Document,
        index: usize,
    ) -> Result<Arc<DynamicImage>, SceneError> {
        if let Some((decoded, _)) = self.decoded.get(&index) {
            return Ok(Arc::clone(decoded));
        }
        let element = format!("images/{index}");
        let image = &document.root.images[index];
        let (content, name) = content(document, image, &element)?;
        let (decoded, held) = decode_image(&name, &content, &document.context)
            .map_err(|source| SceneError::Image { at: document.location(&element), source })?;
        let decoded = Arc::new(decoded);
        self.decoded.insert(index, (Arc::clone(&decoded), held));
        Ok(decoded)
    }
}

/// Returns the encoded image, and its name for messages.
fn content(
    document: &Document,
    image: &Image,
    element: &str,
) -> Result<(Vec<u8>, PathBuf), SceneError> {
    let embedded = || PathBuf::from(format!("the image {element}"));
    match (&image.uri, image.buffer_view) {
        (Some(uri), _) => {
            let name = if uri.starts_with("data:") { embedded() } else { PathBuf::from(uri) };
            Ok((document.resource(uri, &format!("{element}/uri"))?, name))
        }
        (None, Some(view)) => {
            let (bytes, _) = document.view(view, &format!("{element}/bufferView"))?;
            Ok((bytes.to_vec(), embedded()))
        }
        (None, None) => {
            let found = "an image without data";
            Err(document.error(element, found, "expected \"uri\" or \"bufferView\""))
        }
    }
}

/// Returns whether an image has more than 8 bits.
fn is_deep(image: &DynamicImage) -> bool {
    !matches!(
        image,
        DynamicImage::ImageLuma8(_)
            | DynamicImage::ImageLumaA8(_)
            | DynamicImage::ImageRgb8(_)
            | DynamicImage::ImageRgba8(_)
    )
}

/// Returns the numbers of the channels, and their curve.
fn picked(channels: Channels) -> (&'static [usize], Transfer) {
    match channels {
        Channels::Colour => (&[0, 1, 2], Transfer::Srgb),
        Channels::Alpha | Channels::Mask { .. } => (&[3], Transfer::Linear),
        Channels::Single(0, transfer) => (&[0], transfer),
        Channels::Single(1, transfer) => (&[1], transfer),
        Channels::Single(2, transfer) => (&[2], transfer),
        Channels::Single(_, transfer) => (&[3], transfer),
    }
}

/// Returns channels of an image in its own precision: 8 bits, or floats if it has more.
fn unpack(image: &DynamicImage, channels: Channels) -> Raster {
    let size = [image.width() as usize, image.height() as usize];
    let (picked, transfer) = picked(channels);
    let samples = match (is_deep(image), channels) {
        (_, Channels::Mask { factor, cutoff }) => {
            let pixels = image.to_rgba32f();
            let opaque = |alpha: f32| if alpha * factor >= cutoff { 255 } else { 0 };
            let bytes = pixels.pixels().map(|pixel| opaque(pixel.0[3])).collect();
            ImageSamples::Bytes(bytes, transfer)
        }
        (true, _) => {
            let pixels = image.to_rgba32f();
            let floats = pixels.pixels().flat_map(|p| picked.iter().map(|&c| p.0[c]));
            ImageSamples::Floats(floats.map(|signal| transfer.decode(signal)).collect())
        }
        (false, _) => {
            let pixels = image.to_rgba8();
            let bytes = pixels.pixels().flat_map(|p| picked.iter().map(|&c| p.0[c])).collect();
            ImageSamples::Bytes(bytes, transfer)
        }
    };
    Raster { size, channels: picked.len(), samples }
}

#[cfg(test)]
mod tests {
    use image::{ImageBuffer, Rgba};

    use super::*;

    #[test]
    fn channels_are_picked_with_their_curve() {
        let image = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Rgba([10u8, 20, 30, 40])));
        let bytes = |channels| match unpack(&image, channels).samples {
            ImageSamples::Bytes(bytes, _) => bytes,
            ImageSamples::Floats(_) => panic!("floats"),
        };
        assert_eq!(bytes(Channels::Colour), [10, 20, 30]);
        assert_eq!(bytes(Channels::Alpha), [40]);
        assert_eq!(bytes(Channels::Single(1, Transfer::Linear)), [20]);
        assert_eq!(bytes(Channels::Single(2, Transfer::Linear)), [30]);
        assert_eq!(bytes(Channels::Mask { factor: 1.0, cutoff: 40.0 / 255.0 }), [255]);
        assert_eq!(bytes(Channels::Mask { factor: 0.9, cutoff: 40.0 / 255.0 }), [0]);
    }

    #[test]
    fn sixteen_bits_keep_their_precision() {
        let image = DynamicImage::from(ImageBuffer::from_pixel(1, 1, Rgba([1u16, 2, 3, 65535])));
        let raster = unpack(&image, Channels::Single(1, Transfer::Gamma(2.0)));
        let ImageSamples::Floats(floats) = raster.samples else { panic!("bytes") };
        assert!((floats[0] / (2.0f32 / 65535.0).powi(2) - 1.0).abs() < 1e-5, "{floats:?}");
        let raster = unpack(&image, Channels::Colour);
        let ImageSamples::Floats(floats) = raster.samples else { panic!("bytes") };
        // The lower end of the curve of sRGB is straight.
        assert!((floats[2] * 12.92 * 65535.0 - 3.0).abs() < 1e-3, "{floats:?}");
    }
}
