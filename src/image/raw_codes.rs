//! Codes of a sensor as they were read out, without a picture made of them.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use image::DynamicImage;
use petzval_base::io::ReadContext;

use super::format::extension;
use super::{ImageError, declared, display, tiff};

/// Readings of a sensor.
#[derive(Clone, Debug, PartialEq)]
pub struct RawCodes {
    /// Width and height (pixels).
    pub size: [usize; 2],
    /// Codes, row after row from the top.
    pub codes: Vec<u16>,
    /// Channels behind the filters of the first two by two pixels, in reading order: 0 red, 1 green, 2 blue; `None`
    /// for a sensor without filters.
    pub filters: Option<[u8; 4]>,
    /// Bits of a code in the file: 8 or 16.
    pub bits: u32,
}

impl RawCodes {
    /// Reads a DNG that is not compressed, or the samples of a grey PNG or TIFF of 8 or 16 bits as they are.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, is of another format, or holds a picture instead of codes.
    pub fn read(path: &Path, context: &ReadContext) -> Result<Self, ImageError> {
        let io = |source| ImageError::Io { verb: "read", path: path.to_owned(), source };
        let malformed = |found: String| ImageError::Malformed { path: path.to_owned(), found };
        let too_large = |found| declared::too_large(path, found);
        context.register(path).map_err(io)?;
        match extension(path).as_str() {
            "dng" => {
                let bytes = context.bytes(path).map_err(|error| io(error.source))?;
                tiff::read_mosaic(&bytes).map_err(malformed)
            }
            "png" | "tif" | "tiff" => {
                let bits = declared_bits(path).map_err(malformed)?;
                let (image, held) = display::decode(path, context)?;
                let size = [image.width() as usize, image.height() as usize];
                let codes = match image {
                    DynamicImage::ImageLuma8(grey) => {
                        grey.into_raw().into_iter().map(u16::from).collect()
                    }
                    DynamicImage::ImageLuma16(grey) => grey.into_raw(),
                    _ => {
                        let found = "it is a picture in colours or with alpha; expected the codes of a sensor, in \
                                     grey of 8 or 16 bits";
                        return Err(malformed(found.to_owned()));
                    }
                };
                held.keep(2 * codes.len() as u64).map_err(too_large)?;
                Ok(Self { size, codes, filters: None, bits })
            }
            found => Err(ImageError::Format {
                path: path.to_owned(),
                found: found.to_owned(),
                known: ".dng, .png, .tif and .tiff",
            }),
        }
    }
}

/// Returns the bits of a grey file whose samples grow with the light.
///
/// # Errors
/// Returns what was found if they are neither 8 nor 16, which the decoder would scale, or if white is 0.
fn declared_bits(path: &Path) -> Result<u32, String> {
    let mut head = [0; 26];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut head));
    let is_png = read.is_ok() && head.starts_with(b"\x89PNG\r\n\x1a\n");
    // The header of a PNG stands first; its bits follow the size.
    let bits = if is_png { u32::from(head[24]) } else { tiff::bits_of_codes(path)? };
    match bits {
        8 | 16 => Ok(bits),
        _ => Err(format!("its samples have {bits} bits; expected 8 or 16")),
    }
}
