//! Eight bits for the eye: PNG and JPEG with the sRGB transfer curve (IEC 61966-2-1).
//!
//! An EXR holds linear light and a colour-managed viewer shows it through the screen's curve;
//! an 8-bit file must carry that curve in its numbers. Leave it out and the picture comes out
//! too dark. The PNG also says so in its sRGB chunk; a JPEG without a profile is sRGB by
//! convention.

use std::io::{self, Write};
use std::path::Path;
use std::str::FromStr;

use image::codecs::jpeg::JpegEncoder;
use image::{DynamicImage, ImageDecoder, ImageEncoder};

use super::declared::believe;
use super::{ImageError, Note, Notes, Picture};

/// What 8-bit formats multiply the picture by before they clip it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// Two to the power of this many stops.
    Stops(f64),
    /// So that a hundredth of the lit pixels is brighter than white.
    Auto,
}

impl Default for Exposure {
    fn default() -> Self {
        Self::Stops(0.0)
    }
}

impl FromStr for Exposure {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        if text == "auto" {
            return Ok(Self::Auto);
        }
        match text.parse::<f64>() {
            Ok(stops) if stops.abs() <= 100.0 => Ok(Self::Stops(stops)),
            _ => Err("expected stops (-1.5, 0, 2 ...) or \"auto\"".to_owned()),
        }
    }
}

impl Exposure {
    /// That multiplies by a factor above 0.
    pub fn by(factor: f32) -> Self {
        Self::Stops(f64::from(factor).log2())
    }

    /// The factor for a picture.
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
                let place = (lit.len() - 1) * 99 / 100;
                let (_, white, _) = lit.select_nth_unstable_by(place, f32::total_cmp);
                1.0 / *white
            }
        }
    }
}

/// Linear light, 0 to 1, to the sRGB signal, 0 to 1. What is out of range is clipped.
pub fn srgb_encode(linear: f32) -> f32 {
    // A comparison with NaN is false: it becomes black.
    let linear = if linear > 0.0 { linear.min(1.0) } else { 0.0 };
    if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 }
}

/// The sRGB signal, 0 to 1, to linear light.
pub fn srgb_decode(signal: f32) -> f32 {
    if signal <= 0.040_45 { signal / 12.92 } else { ((signal + 0.055) / 1.055).powf(2.4) }
}

fn encoded(picture: &Picture, exposure: Exposure) -> Vec<u8> {
    let factor = exposure.factor(picture);
    let code = |v: f32| (srgb_encode(v * factor) * 255.0).round() as u8;
    picture.pixels.iter().flat_map(|pixel| pixel.map(code)).collect()
}

fn dimensions(picture: &Picture) -> [u32; 2] {
    picture.size.map(|n| n as u32)
}

pub(super) fn write_png(
    picture: &Picture,
    exposure: Exposure,
    notes: &Notes,
    file: impl Write,
) -> io::Result<()> {
    let [width, height] = dimensions(picture);
    let mut encoder = png::Encoder::new(file, width, height);
    encoder.set_color(png::ColorType::Rgb);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_source_srgb(png::SrgbRenderingIntent::RelativeColorimetric);
    for (name, note) in notes {
        let text = match note {
            Note::Text(text) => text.clone(),
            Note::Number(number) => number.to_string(),
        };
        encoder.add_itxt_chunk((*name).to_owned(), text)?;
    }
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&encoded(picture, exposure))?;
    writer.finish()?;
    Ok(())
}

pub(super) fn write_jpeg(
    picture: &Picture,
    exposure: Exposure,
    quality: u8,
    file: impl Write,
) -> io::Result<()> {
    let [width, height] = dimensions(picture);
    JpegEncoder::new_with_quality(file, quality)
        .write_image(&encoded(picture, exposure), width, height, image::ExtendedColorType::Rgb8)
        .map_err(io::Error::other)
}

/// Reads a picture as it is.
pub(super) fn decode(path: &Path) -> Result<DynamicImage, ImageError> {
    let io = |source| ImageError::Io { verb: "read", path: path.to_owned(), source };
    let malformed = |error: image::ImageError| match error {
        image::ImageError::IoError(error) => io(error),
        other => ImageError::Malformed { path: path.to_owned(), found: other.to_string() },
    };
    let open = || image::ImageReader::open(path).and_then(image::ImageReader::with_guessed_format);
    let decoder = open().map_err(io)?.into_decoder().map_err(malformed)?;
    let (width, height) = decoder.dimensions();
    let bytes = decoder.color_type().bytes_per_pixel();
    believe(path, [width as usize, height as usize], bytes.into())?;
    open().map_err(io)?.decode().map_err(malformed)
}

pub(super) fn read(path: &Path, srgb: bool) -> Result<Picture, ImageError> {
    let pixels = decode(path)?.into_rgb32f();
    let decode = |v: f32| if srgb { srgb_decode(v) } else { v };
    Ok(Picture {
        size: [pixels.width() as usize, pixels.height() as usize],
        pixels: pixels.pixels().map(|p| p.0.map(decode)).collect(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_srgb_curve_has_its_published_values() {
        // IEC 61966-2-1: 18 % grey is code 118, half of the light code 188.
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
        let factor = Exposure::Auto.factor(&picture);
        let above = picture.pixels.iter().filter(|p| p[0] * factor > 1.0001).count();
        assert_eq!(above, 10);
        let black = Picture { size: [4, 1], pixels: vec![[0.0; 3]; 4] };
        assert_eq!(Exposure::Auto.factor(&black), 1.0);
    }
}
