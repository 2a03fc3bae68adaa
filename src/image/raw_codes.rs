//! Codes of a sensor as they were read out, without a picture made of them.

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
                let bytes = context.bytes(path).map_err(|error| malformed(error.to_string()))?;
                tiff::read_mosaic(&bytes).map_err(malformed)
            }
            "png" | "tif" | "tiff" => {
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
                Ok(Self { size, codes, filters: None })
            }
            found => Err(ImageError::Format {
                path: path.to_owned(),
                found: found.to_owned(),
                known: ".dng, .png, .tif and .tiff",
            }),
        }
    }
}
