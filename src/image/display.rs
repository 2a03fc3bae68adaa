//! Files for display: PNG and JPEG, and the signals of TIFF, with the sRGB transfer curve
//! (IEC 61966-2-1).
//!
//! An EXR holds linear light, and viewers apply the screen's curve. A file for display holds signals
//! with that curve applied; without it the picture would look too dark. The PNG declares it in its
//! sRGB chunk; a JPEG without a profile is sRGB by convention.

use std::io::{self, Cursor, Write};
use std::path::Path;
use std::str::FromStr;

use glam::DVec3;
use image::codecs::jpeg::JpegEncoder;
use image::{ColorType, DynamicImage, ImageDecoder, ImageEncoder};

use super::declared::{hold_picture, too_large};
use super::tone::ToneCurve;
use super::{BitDepth, ImageError, Notes, Picture, Transfer, WhiteBalance};
use petzval_base::io::{HeldMemory, ReadContext};

/// Reflectance of middle grey, the usual aim of a light meter.
const MIDDLE_GREY: f32 = 0.18;

/// Factor on a picture before formats for display clip it.
#[derive(Clone, Copy, Debug, PartialEq)]
#[non_exhaustive]
pub enum DisplayExposure {
    /// Two to the power of this many stops.
    Stops(f64),
    /// The factor that makes a hundredth of the lit pixels brighter than white. A darker picture is
    /// brightened further, until its median is middle grey (18 %) or a twentieth of the lit pixels
    /// is brighter than white.
    Auto,
}

impl Default for DisplayExposure {
    fn default() -> Self {
        Self::Stops(0.0)
    }
}

impl FromStr for DisplayExposure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        match text.strip_suffix("EV").unwrap_or(text).trim().parse::<f64>() {
            Ok(stops) if stops.abs() <= 100.0 => Ok(Self::Stops(stops)),
            _ => Err("expected stops (-1.5, 0, 2 ...) or \"auto\"".to_owned()),
        }
    }
}

impl DisplayExposure {
    /// Returns the exposure of a factor above 0.
    pub fn by(factor: f32) -> Self {
        Self::Stops(f64::from(factor).log2())
    }

    /// Returns the factor for a picture.
    pub fn factor(self, picture: &Picture) -> f32 {
        match self {
            Self::Stops(stops) => stops.exp2() as f32,
            Self::Auto => {
                let luminance = |p: &[f32; 3]| 0.2126 * p[0] + 0.7152 * p[1] + 0.0722 * p[2];
                let mut lit: Vec<f32> =
                    picture.pixels.iter().map(luminance).filter(|&l| l > 0.0).collect();
                if lit.is_empty() {
                    return 1.0;
                }
                let mut at = |percent: usize| {
                    let place = (lit.len() - 1) * percent / 100;
                    *lit.select_nth_unstable_by(place, f32::total_cmp).1
                };
                let [middle, bright, white] = [50, 95, 99].map(&mut at);
                // Light so weak that its inverse overflows is shown as it is.
                let factor = (MIDDLE_GREY / middle).clamp(1.0 / white, 1.0 / bright);
                if factor.is_finite() { factor } else { 1.0 }
            }
        }
    }
}

/// Returns the sRGB signal of linear light. Both range from 0 to 1; light outside is clipped, and
/// NaN is black.
pub fn srgb_encode(linear: f32) -> f32 {
    // A comparison with NaN is false, so NaN becomes 0.
    let linear = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// Returns the linear light of an sRGB signal. Both range from 0 to 1.
pub fn srgb_decode(signal: f32) -> f32 {
    if signal <= 0.040_45 { signal / 12.92 } else { ((signal + 0.055) / 1.055).powf(2.4) }
}

/// Signal in a file: a whole number, the largest of which is white.
pub(super) trait SignalCode: Copy + Default {
    const WHITE: f32;

    /// Returns the code of a whole number from 0 to [`Self::WHITE`].
    fn from_whole(number: f32) -> Self;

    /// Returns the nearest code of a share of white.
    fn of(share: f32) -> Self {
        Self::from_whole((share * Self::WHITE).round())
    }
}

impl SignalCode for u8 {
    const WHITE: f32 = 255.0;

    fn from_whole(number: f32) -> Self {
        number as Self
    }
}

impl SignalCode for u16 {
    const WHITE: f32 = 65535.0;

    fn from_whole(number: f32) -> Self {
        number as Self
    }
}

/// Map from linear light to the signals of files for display.
#[derive(Clone, Copy, Debug)]
pub(super) struct DisplayMapping {
    pub exposure: DisplayExposure,
    pub white_balance: WhiteBalance,
    pub tone: ToneCurve,
    /// Whether the file has a single channel.
    pub grey: bool,
}

impl DisplayMapping {
    /// Multiplies by a factor above 0.
    pub fn by(factor: f32) -> Self {
        Self {
            exposure: DisplayExposure::by(factor),
            white_balance: WhiteBalance::Off,
            tone: ToneCurve::Linear,
            grey: false,
        }
    }

    /// Returns the map from light to codes of a picture.
    fn of<C: SignalCode>(self, picture: &Picture) -> impl Fn(&[f32; 3]) -> [C; 3] + use<C> {
        let factor = self.exposure.factor(picture);
        let matrix = self.white_balance.found(picture, factor).matrix();
        let balanced = move |light: [f32; 3]| match &matrix {
            Some(matrix) => {
                (*matrix * DVec3::from_array(light.map(f64::from))).to_array().map(|v| v as f32)
            }
            None => light,
        };
        move |pixel| {
            self.tone.apply(balanced(pixel.map(|v| v * factor))).map(|v| C::of(srgb_encode(v)))
        }
    }
}

/// Returns the codes of the channels, or of the first alone. Colours that are premultiplied by an opacity are
/// made straight and followed by it.
///
/// # Errors
/// Returns an error if the opacity has another size than the picture.
pub(super) fn encoded<C: SignalCode>(
    picture: &Picture,
    alpha: Option<&[f32]>,
    mapping: DisplayMapping,
) -> io::Result<Vec<C>> {
    if let Some(alpha) = alpha.filter(|alpha| alpha.len() != picture.pixels.len()) {
        let (found, expected) = (alpha.len(), picture.pixels.len());
        let found = format!("the opacity has {found} values, expected {expected}");
        return Err(io::Error::new(io::ErrorKind::InvalidInput, found));
    }
    let show = mapping.of(picture);
    let channels = if mapping.grey { 1 } else { 3 };
    let mut codes = Vec::with_capacity(4 * picture.pixels.len());
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let alpha = alpha.map(|alpha| alpha[i]);
        let colour = match alpha {
            None => show(pixel),
            Some(alpha) if alpha > 0.0 => show(&pixel.map(|v| v / alpha)),
            Some(_) => [C::default(); 3],
        };
        codes.extend_from_slice(&colour[..channels]);
        codes.extend(alpha.map(C::of));
    }
    Ok(codes)
}

pub(super) fn dimensions(picture: &Picture) -> [u32; 2] {
    picture.size.map(|n| n as u32)
}

/// Writes a PNG, with an opacity if there is one.
pub(super) fn write_png(
    picture: &Picture,
    alpha: Option<&[f32]>,
    mapping: DisplayMapping,
    depth: BitDepth,
    notes: &Notes,
    file: impl Write,
) -> io::Result<()> {
    let [width, height] = dimensions(picture);
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(match (mapping.grey, alpha) {
        (false, None) => png::ColorType::Rgb,
        (false, Some(_)) => png::ColorType::Rgba,
        (true, None) => png::ColorType::Grayscale,
        (true, Some(_)) => png::ColorType::GrayscaleAlpha,
    });
    encoder.set_depth(match depth {
        BitDepth::Eight => png::BitDepth::Eight,
        BitDepth::Sixteen => png::BitDepth::Sixteen,
    });
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    for (name, note) in notes {
        encoder.add_itxt_chunk((*name).to_owned(), note.to_string())?;
    }
    let mut writer = encoder.write_header()?;
    match depth {
        BitDepth::Eight => writer.write_image_data(&encoded::<u8>(picture, alpha, mapping)?)?,
        BitDepth::Sixteen => {
            let mut codes: Vec<u16> = encoded(picture, alpha, mapping)?;
            codes.iter_mut().for_each(|code| *code = code.to_be());
            writer.write_image_data(bytemuck::cast_slice(&codes))?;
        }
    }
    writer.finish()?;
    Ok(())
}

/// Writes a JPEG. Each note is a comment, `name: value`.
pub(super) fn write_jpeg(
    picture: &Picture,
    mapping: DisplayMapping,
    quality: u8,
    notes: &Notes,
    mut file: impl Write,
) -> io::Result<()> {
    let [width, height] = dimensions(picture);
    let mut jpeg = Vec::new();
    let colour =
        if mapping.grey { image::ExtendedColorType::L8 } else { image::ExtendedColorType::Rgb8 };
    JpegEncoder::new_with_quality(&mut jpeg, quality)
        .write_image(&encoded::<u8>(picture, None, mapping)?, width, height, colour)
        .map_err(io::Error::other)?;
    // The start of the image and the JFIF segment come first (JFIF 1.02).
    let head = match jpeg[..] {
        [0xff, 0xd8, 0xff, 0xe0, high, low, ..] => {
            jpeg.len().min(4 + usize::from(u16::from_be_bytes([high, low])))
        }
        _ => jpeg.len().min(2),
    };
    let (head, rest) = jpeg.split_at(head);
    file.write_all(head)?;
    for (name, note) in notes {
        let text = format!("{name}: {note}");
        // The length of a segment counts itself.
        let text = &text.as_bytes()[..text.len().min(usize::from(u16::MAX) - 2)];
        file.write_all(&[0xff, 0xfe])?;
        file.write_all(&(text.len() as u16 + 2).to_be_bytes())?;
        file.write_all(text)?;
    }
    file.write_all(rest)
}

/// Reads a picture in the file's own pixel format. Returns also the memory that is held for it, and for
/// its conversion: floats of four channels, and then of three; bytes lose their alpha.
pub(super) fn decode(
    path: &Path,
    context: &ReadContext,
) -> Result<(DynamicImage, HeldMemory), ImageError> {
    let io = |source| ImageError::Io { verb: "read", path: path.to_owned(), source };
    let malformed = |error: image::ImageError| match error {
        image::ImageError::IoError(error) => io(error),
        other => ImageError::Malformed { path: path.to_owned(), found: other.to_string() },
    };
    let open = || image::ImageReader::open(path).and_then(image::ImageReader::with_guessed_format);
    let reader = open().map_err(io)?;
    if reader.format() == Some(image::ImageFormat::Tiff) {
        super::tiff::check_samples(path)?;
    }
    let decoder = reader.into_decoder().map_err(malformed)?;
    let (width, height) = decoder.dimensions();
    let bytes = u64::from(decoder.color_type().bytes_per_pixel());
    let converted = match decoder.color_type() {
        ColorType::L8 | ColorType::Rgb8 => 0,
        ColorType::La8 => 1,
        ColorType::Rgba8 => 3,
        _ => 16 + 12,
    };
    let held = hold_picture(context, path, [width as usize, height as usize], bytes + converted)?;
    Ok((open().map_err(io)?.decode().map_err(malformed)?, held))
}

/// Decodes an image that is in memory. `name` is its name in messages. Returns also the memory that is
/// held for it.
///
/// # Errors
/// Returns an error if it is not an image, has no pixels, or exceeds the memory budget.
pub fn decode_image(
    name: &Path,
    content: &[u8],
    context: &ReadContext,
) -> Result<(DynamicImage, HeldMemory), ImageError> {
    let malformed = |found: String| ImageError::Malformed { path: name.to_owned(), found };
    let open = || image::ImageReader::new(Cursor::new(content)).with_guessed_format();
    let broken = |error: image::ImageError| malformed(error.to_string());
    let decoder = open().map_err(|error| malformed(error.to_string()))?;
    let decoder = decoder.into_decoder().map_err(broken)?;
    let (width, height) = decoder.dimensions();
    if width == 0 || height == 0 {
        return Err(malformed("it has no pixels".to_owned()));
    }
    let bytes = u64::from(decoder.color_type().bytes_per_pixel());
    let size = u64::from(width) * u64::from(height);
    let held = context.hold(size.saturating_mul(bytes)).map_err(|found| too_large(name, found))?;
    Ok((DynamicImage::from_decoder(decoder).map_err(broken)?, held))
}

pub(super) fn read(
    path: &Path,
    transfer: Transfer,
    context: &ReadContext,
) -> Result<((Picture, bool), HeldMemory), ImageError> {
    let (image, mut held) = decode(path, context)?;
    let grey = !image.color().has_color();
    // Floats of the file's signals, and those of light.
    let floats = 24 * u64::from(image.width()) * u64::from(image.height());
    held.add(floats).map_err(|found| too_large(path, found))?;
    // Floats of a TIFF are light.
    let transfer = match image.color() {
        ColorType::Rgb32F | ColorType::Rgba32F => Transfer::Linear,
        _ => transfer,
    };
    let pixels = image.into_rgb32f();
    let decode = |v: f32| match transfer {
        Transfer::Linear => v,
        Transfer::Srgb => srgb_decode(v),
        Transfer::Gamma(gamma) => v.powf(gamma),
    };
    let picture = Picture {
        size: [pixels.width() as usize, pixels.height() as usize],
        pixels: pixels.pixels().map(|p| p.0.map(decode)).collect(),
    };
    Ok(((picture, grey), held))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_srgb_curve_has_its_published_values() {
        // IEC 61966-2-1: 18 % grey is code 118, and 50 % of the light code 188.
        assert_eq!((srgb_encode(0.18) * 255.0).round(), 118.0);
        assert_eq!((srgb_encode(0.5) * 255.0).round(), 188.0);
        let codes = [0.0, 1.0, 7.0, f32::INFINITY].map(|v| (srgb_encode(v) * 255.0).round());
        assert_eq!(codes, [0.0, 255.0, 255.0, 255.0]);
        assert_eq!(srgb_encode(f32::NAN), 0.0);
        for code in 0..=255 {
            let signal = code as f32 / 255.0;
            assert_eq!((srgb_encode(srgb_decode(signal)) * 255.0).round(), code as f32);
        }
    }

    #[test]
    fn auto_exposure_leaves_a_hundredth_above_white() {
        let pixels = (0..=1000).map(|i| [i as f32 * 0.03; 3]).collect();
        let picture = Picture { size: [1001, 1], pixels };
        let factor = DisplayExposure::Auto.factor(&picture);
        let above = picture.pixels.iter().filter(|p| p[0] * factor > 1.0001).count();
        assert_eq!(above, 10);
        let black = Picture { size: [4, 1], pixels: vec![[0.0; 3]; 4] };
        assert_eq!(DisplayExposure::Auto.factor(&black), 1.0);
    }
}
