//! Codes of a sensor as they were read out, without a picture made of them.

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use image::{DynamicImage, ImageFormat, ImageReader};
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
    /// Bits of a code in the file: 8 or 16, or fewer in compressed files.
    pub bits: u32,
}

impl RawCodes {
    /// Reads a DNG, uncompressed or compressed with lossless JPEG, or the samples of a grey PNG or TIFF of 8 or 16 bits as they are.
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
                let samples = tiff::raw_samples(&bytes).map_err(malformed)?;
                // In chunks, and in rows.
                let held = context.hold(samples.saturating_mul(4)).map_err(too_large)?;
                let codes = tiff::read_mosaic(&bytes).map_err(malformed)?;
                held.keep(2 * codes.codes.len() as u64).map_err(too_large)?;
                Ok(codes)
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

/// Returns the bits of the samples of a file, which the image crate scales if they are neither 8 nor 16.
///
/// # Errors
/// Returns what was found if they are others, or if white is 0 in a TIFF.
fn declared_bits(path: &Path) -> Result<u32, String> {
    let file = || File::open(path).map(BufReader::new).map_err(|error| error.to_string());
    let format = ImageReader::new(file()?).with_guessed_format();
    let bits = match format.map_err(|error| error.to_string())?.format() {
        Some(ImageFormat::Png) => {
            let reader =
                png::Decoder::new(file()?).read_info().map_err(|error| error.to_string())?;
            reader.info().bit_depth as u32
        }
        _ => tiff::bits_of_codes(path)?,
    };
    match bits {
        8 | 16 => Ok(bits),
        _ => Err(format!("its samples have {bits} bits; expected 8 or 16")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(path: &Path) -> Result<RawCodes, String> {
        RawCodes::read(path, &ReadContext::default()).map_err(|error| error.to_string())
    }

    #[test]
    fn codes_are_those_of_the_file_and_scaled_ones_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = |name: &str| folder.path().join(name);
        let codes = vec![0_u16, 7, 4095, 65535];
        let wide =
            image::ImageBuffer::<image::Luma<u16>, _>::from_vec(2, 2, codes.clone()).unwrap();
        for name in ["wide.png", "wide.tif"] {
            wide.save(path(name)).unwrap();
            let found = read(&path(name)).unwrap();
            assert_eq!(
                (found.size, found.codes, found.bits),
                ([2, 2], codes.clone(), 16),
                "{name}"
            );
            assert_eq!(found.filters, None);
        }
        image::GrayImage::from_vec(2, 1, vec![3, 200]).unwrap().save(path("byte.png")).unwrap();
        let found = read(&path("byte.png")).unwrap();
        assert_eq!((found.codes, found.bits), (vec![3, 200], 8));

        for (depth, bits) in [(png::BitDepth::One, 1), (png::BitDepth::Four, 4)] {
            let file = std::fs::File::create(path("few.png")).unwrap();
            let mut encoder = png::Encoder::new(file, 2, 1);
            encoder.set_color(png::ColorType::Grayscale);
            encoder.set_depth(depth);
            encoder.write_header().unwrap().write_image_data(&[0x40]).unwrap();
            let refused = read(&path("few.png")).unwrap_err();
            assert!(refused.contains(&format!("{bits} bits; expected 8 or 16")), "{refused}");
        }
        // The entry PhotometricInterpretation, BlackIsZero, becomes WhiteIsZero.
        let mut bytes = std::fs::read(path("wide.tif")).unwrap();
        let entry = [6, 1, 3, 0, 1, 0, 0, 0, 1, 0];
        let at = bytes.windows(entry.len()).position(|window| window == entry).unwrap();
        bytes[at + 8] = 0;
        std::fs::write(path("negative.tif"), bytes).unwrap();
        let refused = read(&path("negative.tif")).unwrap_err();
        assert!(refused.contains("white is 0 in it"), "{refused}");
        assert!(read(&path("picture.jpg")).unwrap_err().contains(".dng, .png, .tif and .tiff"));
    }
}
