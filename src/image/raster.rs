//! Pictures in their file's pixel format: 8-bit samples stay 8-bit, and alpha is kept.

use std::path::Path;

use image::DynamicImage;

use super::{ImageError, Picture, READABLE, declared, display, exr, extension, pfm, qoi_transfer};
use super::{srgb_decode, srgb_encode};
use petzval_base::io::{HeldMemory, ReadContext};

/// Transfer curve between light and the samples of a file with 8 or 16 bits.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Transfer {
    /// Proportional to light.
    Linear,
    /// The curve of sRGB (IEC 61966-2-1).
    #[default]
    Srgb,
    /// A power: light is the signal to this exponent.
    Gamma(f32),
}

impl Transfer {
    /// Returns the light of a signal. Both range from 0 to 1.
    pub fn decode(self, signal: f32) -> f32 {
        match self {
            Self::Linear => signal,
            Self::Srgb => srgb_decode(signal),
            Self::Gamma(gamma) => signal.powf(gamma),
        }
    }

    /// Returns the signal of light. Both range from 0 to 1; light outside is clipped.
    pub fn encode(self, light: f32) -> f32 {
        let light = light.clamp(0.0, 1.0);
        match self {
            Self::Linear => light,
            Self::Srgb => srgb_encode(light),
            Self::Gamma(gamma) => light.powf(gamma.recip()),
        }
    }
}

/// Samples of a picture: channels within pixels within rows, from the top.
#[derive(Clone, Debug, PartialEq)]
pub enum ImageSamples {
    /// Signals with a transfer curve. Alpha is always linear.
    Bytes(Vec<u8>, Transfer),
    /// Linear light.
    Floats(Vec<f32>),
}

/// A picture in its file's pixel format.
#[derive(Clone, Debug, PartialEq)]
pub struct Raster {
    /// Width and height (pixels).
    pub size: [usize; 2],
    /// Number of channels: 1 (luminance), 3 (RGB) or 4 (RGB and alpha that is not 1 everywhere).
    pub channels: usize,
    /// Samples.
    pub samples: ImageSamples,
}

impl Raster {
    /// Reads a picture. `transfer` applies to PNG and TIFF files of 8 or 16 bits; other 8-bit formats hold
    /// sRGB, unless a QOI declares that it is linear, and formats of floats hold linear light. Alpha
    /// is read from PNG, TIFF, QOI and EXR; as in pbrt-v4, alpha of 16 bits has the curve of its
    /// colours. EXR files with `chromaticities` are converted to sRGB, white to white.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, is not a picture, has no pixels, or has a
    /// sample that is not finite.
    pub fn read(
        path: &Path,
        transfer: Transfer,
        context: &ReadContext,
    ) -> Result<Self, ImageError> {
        let (raster, held) = Self::read_held(path, transfer, context)?;
        held.keep(raster.bytes()).map_err(|found| declared::too_large(path, found))?;
        Ok(raster)
    }

    /// Reads a picture as [`Raster::read`]. Returns also the memory that is held for it.
    pub fn read_held(
        path: &Path,
        transfer: Transfer,
        context: &ReadContext,
    ) -> Result<(Self, HeldMemory), ImageError> {
        let refused = |source| ImageError::Io { verb: "read", path: path.to_owned(), source };
        context.register(path).map_err(refused)?;
        let decode = |transfer| {
            let (image, held) = display::decode(path, context)?;
            Ok::<_, ImageError>((from_image(image, transfer), held))
        };
        let (raster, mut held) = match extension(path).as_str() {
            "exr" => exr::read_raster(path, context)?,
            "pfm" => pfm::read(path, context)?,
            "png" | "tif" | "tiff" => decode(transfer)?,
            "qoi" => decode(qoi_transfer(path)?)?,
            "jpg" | "jpeg" | "tga" | "bmp" | "gif" | "hdr" => {
                let (raster, held) = decode(Transfer::Srgb)?;
                (raster.without_alpha(|_| true), held)
            }
            found => {
                return Err(ImageError::Format {
                    path: path.to_owned(),
                    found: found.to_owned(),
                    known: READABLE,
                });
            }
        };
        if raster.size.contains(&0) {
            let found = "it has no pixels".to_owned();
            return Err(ImageError::Malformed { path: path.to_owned(), found });
        }
        if let Some([x, y]) = raster.first_not_finite() {
            let found = format!("its pixel {x}, {y} is not finite");
            return Err(ImageError::Malformed { path: path.to_owned(), found });
        }
        let raster = raster.without_alpha(Raster::opaque);
        held.resize(raster.bytes()).map_err(|found| declared::too_large(path, found))?;
        Ok((raster, held))
    }

    /// Returns the memory of the samples (bytes).
    pub fn bytes(&self) -> u64 {
        match &self.samples {
            ImageSamples::Bytes(bytes, _) => bytes.len() as u64,
            ImageSamples::Floats(floats) => size_of_val(&floats[..]) as u64,
        }
    }

    /// Returns the first pixel with a sample that is not finite, from the upper left.
    fn first_not_finite(&self) -> Option<[usize; 2]> {
        let ImageSamples::Floats(floats) = &self.samples else { return None };
        let pixel = floats.iter().position(|v| !v.is_finite())? / self.channels;
        Some([pixel % self.size[0], pixel / self.size[0]])
    }

    /// Converts the samples to linear light, without alpha.
    pub fn into_picture(self) -> Picture {
        let light: Vec<f32> = match self.samples {
            ImageSamples::Bytes(bytes, transfer) => {
                bytes.iter().map(|&code| transfer.decode(f32::from(code) / 255.0)).collect()
            }
            ImageSamples::Floats(floats) => floats,
        };
        let colour = |pixel: &[f32]| match *pixel {
            [r, g, b, ..] => [r, g, b],
            _ => [pixel[0]; 3],
        };
        Picture { size: self.size, pixels: light.chunks_exact(self.channels).map(colour).collect() }
    }

    fn opaque(&self) -> bool {
        match &self.samples {
            ImageSamples::Bytes(bytes, _) => bytes.chunks_exact(4).all(|pixel| pixel[3] == 255),
            ImageSamples::Floats(floats) => floats.chunks_exact(4).all(|pixel| pixel[3] == 1.0),
        }
    }

    /// Removes the alpha channel, if there is one and the condition holds.
    fn without_alpha(self, condition: impl Fn(&Self) -> bool) -> Self {
        if self.channels != 4 || !condition(&self) {
            return self;
        }
        let samples = match self.samples {
            ImageSamples::Bytes(bytes, transfer) => {
                ImageSamples::Bytes(three_of_four(&bytes), transfer)
            }
            ImageSamples::Floats(floats) => ImageSamples::Floats(three_of_four(&floats)),
        };
        Self { channels: 3, samples, ..self }
    }
}

fn three_of_four<T: Copy>(values: &[T]) -> Vec<T> {
    values.as_chunks::<4>().0.iter().flat_map(|[r, g, b, _]| [*r, *g, *b]).collect()
}

fn from_image(image: DynamicImage, transfer: Transfer) -> Raster {
    let size = [image.width() as usize, image.height() as usize];
    let floats = |values: Vec<u16>| {
        let decode = |&v: &u16| transfer.decode(f32::from(v) / 65535.0);
        ImageSamples::Floats(values.iter().map(decode).collect())
    };
    let bytes = |values| ImageSamples::Bytes(values, transfer);
    let (channels, samples) = match image {
        DynamicImage::ImageLuma8(image) => (1, bytes(image.into_raw())),
        grey @ DynamicImage::ImageLumaA8(_) => (1, bytes(grey.into_luma8().into_raw())),
        DynamicImage::ImageRgb8(image) => (3, bytes(image.into_raw())),
        DynamicImage::ImageRgba8(image) => (4, bytes(image.into_raw())),
        DynamicImage::ImageLuma16(image) => (1, floats(image.into_raw())),
        grey @ DynamicImage::ImageLumaA16(_) => (1, floats(grey.into_luma16().into_raw())),
        DynamicImage::ImageRgb16(image) => (3, floats(image.into_raw())),
        DynamicImage::ImageRgba16(image) => (4, floats(image.into_raw())),
        // All other formats hold floats, which are linear light.
        other => (4, ImageSamples::Floats(other.into_rgba32f().into_raw())),
    };
    Raster { size, channels, samples }
}

#[cfg(test)]
mod tests {
    use image::{ImageBuffer, Luma, LumaA, Rgb, Rgba};

    use super::*;

    fn read(name: &str, image: DynamicImage, transfer: Transfer) -> Raster {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join(name);
        image.save(&path).unwrap();
        Raster::read(&path, transfer, &ReadContext::default()).unwrap()
    }

    #[test]
    fn eight_bits_stay_eight_bits() {
        let rgb = ImageBuffer::from_fn(2, 1, |x, _| Rgb([x as u8, 100, 255]));
        let raster = read("a.png", rgb.clone().into(), Transfer::Linear);
        assert_eq!((raster.size, raster.channels), ([2, 1], 3));
        assert_eq!(
            raster.samples,
            ImageSamples::Bytes(vec![0, 100, 255, 1, 100, 255], Transfer::Linear)
        );
        // As in pbrt-v4, only a PNG can be linear.
        let raster = read("a.tga", rgb.into(), Transfer::Linear);
        assert!(matches!(raster.samples, ImageSamples::Bytes(_, Transfer::Srgb)));
    }

    #[test]
    fn bitmaps_gifs_and_qois_are_read() {
        let rgba = ImageBuffer::from_pixel(2, 1, Rgba([200u8, 100, 0, 128]));
        let rgb = ImageBuffer::from_pixel(2, 1, Rgb([200u8, 100, 0]));
        let srgb = ImageSamples::Bytes(vec![200, 100, 0, 200, 100, 0], Transfer::Srgb);
        for name in ["a.bmp", "a.gif", "a.qoi"] {
            let raster = read(name, rgb.clone().into(), Transfer::Linear);
            assert_eq!((raster.size, raster.channels), ([2, 1], 3), "{name}");
            assert_eq!(raster.samples, srgb, "{name}");
        }
        assert_eq!(read("a.qoi", rgba.clone().into(), Transfer::Srgb).channels, 4);
        assert_eq!(read("a.bmp", rgba.into(), Transfer::Srgb).channels, 3);
    }

    #[test]
    fn a_qoi_that_declares_linear_light_is_linear() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.qoi");
        DynamicImage::from(ImageBuffer::from_pixel(1, 1, Rgb([128u8; 3]))).save(&path).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        bytes[13] = 1;
        std::fs::write(&path, bytes).unwrap();
        let raster = Raster::read(&path, Transfer::Srgb, &ReadContext::default()).unwrap();
        assert!(matches!(raster.samples, ImageSamples::Bytes(_, Transfer::Linear)));
        let picture = Picture::read(&path).unwrap();
        assert!((picture.pixels[0][0] - 128.0 / 255.0).abs() < 1e-6);
    }

    #[test]
    fn a_sample_that_is_not_finite_is_refused_with_its_pixel() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.pfm");
        for odd in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY] {
            // The last row of the file is the upper row of the picture.
            let values = [1.0, 2.0, 3.0, 4.0, odd, 6.0];
            let bytes = [b"Pf\n3 2\n-1.0\n".to_vec(), values.map(f32::to_le_bytes).concat()];
            std::fs::write(&path, bytes.concat()).unwrap();
            let said = Raster::read(&path, Transfer::Linear, &ReadContext::default())
                .unwrap_err()
                .to_string();
            assert!(said.contains("a.pfm") && said.contains("pixel 1, 0"), "{said}");
        }
    }

    #[test]
    fn a_file_cannot_declare_more_than_it_can_hold() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.png");
        DynamicImage::from(ImageBuffer::from_pixel(1, 1, Luma([9u8]))).save(&path).unwrap();
        let mut bytes = std::fs::read(&path).unwrap();
        // Width and height follow the signature and the header of the first chunk.
        bytes[16..24].copy_from_slice(&[0, 0, 0x40, 0, 0, 0, 0x40, 0]);
        let mut sum = flate2::Crc::new();
        sum.update(&bytes[12..29]);
        bytes[29..33].copy_from_slice(&sum.sum().to_be_bytes());
        std::fs::write(&path, bytes).unwrap();
        let said =
            Raster::read(&path, Transfer::Linear, &ReadContext::default()).unwrap_err().to_string();
        assert!(said.contains("16384 x 16384"), "{said}");
    }

    #[test]
    fn alpha_is_kept_if_it_is_not_1_everywhere() {
        let with = |alpha| {
            read(
                "a.png",
                ImageBuffer::from_pixel(2, 2, Rgba([1u8, 2, 3, alpha])).into(),
                Transfer::Srgb,
            )
        };
        assert_eq!([with(255).channels, with(254).channels], [3, 4]);
        let grey = ImageBuffer::from_pixel(2, 2, LumaA([7u8, 9]));
        let raster = read("a.png", grey.into(), Transfer::Srgb);
        assert_eq!(raster.samples, ImageSamples::Bytes(vec![7; 4], Transfer::Srgb));
    }

    #[test]
    fn sixteen_bits_are_decoded_by_the_same_curve() {
        let grey: ImageBuffer<Luma<u16>, _> = ImageBuffer::from_pixel(1, 1, Luma([65535 / 5]));
        for (transfer, light) in
            [(Transfer::Linear, 0.2), (Transfer::Srgb, 0.033105), (Transfer::Gamma(2.0), 0.04)]
        {
            let raster = read("a.png", grey.clone().into(), transfer);
            let ImageSamples::Floats(floats) = &raster.samples else { panic!() };
            assert!((floats[0] - light).abs() < 1e-6, "{transfer:?}: {}", floats[0]);
            assert!((transfer.encode(floats[0]) - 0.2).abs() < 1e-6);
        }
    }

    #[test]
    fn alpha_of_sixteen_bits_is_decoded_as_colours_are() {
        let fifth = 65535 / 5;
        let pixel: ImageBuffer<Rgba<u16>, _> = ImageBuffer::from_pixel(1, 1, Rgba([fifth; 4]));
        let raster = read("a.png", pixel.into(), Transfer::Gamma(2.0));
        let ImageSamples::Floats(floats) = &raster.samples else { panic!() };
        for (found, expected) in floats.iter().zip([0.04; 4]) {
            assert!((found - expected).abs() < 1e-6, "{floats:?}");
        }
    }

    #[test]
    fn an_exr_is_light_with_its_alpha() {
        use ::exr::prelude::*;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.exr");
        for (alpha, channels) in [(0.5f32, 4), (1.0, 3)] {
            write_rgba_file(&path, 2, 1, |x, _| (x as f32, 2.0f32, 3.0f32, alpha)).unwrap();
            let raster = Raster::read(&path, Transfer::Srgb, &ReadContext::default()).unwrap();
            assert_eq!((raster.size, raster.channels), ([2, 1], channels));
            let ImageSamples::Floats(floats) = &raster.samples else { panic!() };
            assert_eq!(floats[channels..channels + 3], [1.0, 2.0, 3.0]);
        }
    }

    #[test]
    fn tiff_of_floats_is_light_and_whole_numbers_of_32_bits_are_refused() {
        use tiff::encoder::{
            TiffEncoder,
            colortype::{RGB32, RGB32Float},
        };
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.tif");
        let mut encoder = TiffEncoder::new(std::fs::File::create(&path).unwrap()).unwrap();
        encoder.write_image::<RGB32Float>(2, 1, &[0.5, 1.0, 7.0, 0.25, 0.0, 3.0]).unwrap();
        let picture = Picture::read(&path).unwrap();
        assert_eq!(picture.pixels, [[0.5, 1.0, 7.0], [0.25, 0.0, 3.0]]);
        let raster = Raster::read(&path, Transfer::Srgb, &ReadContext::default()).unwrap();
        assert_eq!(raster.into_picture(), picture);
        let mut encoder = TiffEncoder::new(std::fs::File::create(&path).unwrap()).unwrap();
        encoder.write_image::<RGB32>(1, 1, &[1, 2, 1 << 31]).unwrap();
        for said in [
            Picture::read(&path).unwrap_err().to_string(),
            Raster::read(&path, Transfer::Srgb, &ReadContext::default()).unwrap_err().to_string(),
        ] {
            assert!(said.contains("32 bits or more; expected 8 or 16"), "{said}");
        }
    }

    #[test]
    fn files_that_are_no_pictures_are_refused() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["a.png", "a.jpg", "a.exr", "a.hdr", "a.tga", "a.gif", "a.tif", "missing.png"] {
            let path = folder.path().join(name);
            if name != "missing.png" {
                std::fs::write(&path, b"\x89PNG\r\n\x1a\nnothing of the kind").unwrap();
            }
            assert!(
                Raster::read(&path, Transfer::Srgb, &ReadContext::default()).is_err(),
                "{name}"
            );
        }
    }
}
