//! File formats, and the options with which pictures are written.

use std::path::Path;

use super::display::DisplayMapping;
use super::spectral::SPECTRAL_LAYER;
use super::{
    ALPHA_LAYER, DisplayExposure, ImageError, Primaries, RawFormat, ToneCurve, WhiteBalance,
};

/// Bits of a channel of a file for display.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum BitDepth {
    /// 256 codes.
    #[default]
    Eight,
    /// 65536 codes.
    Sixteen,
}

/// Options of a format when a picture is written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct EncodingOptions {
    /// Whether EXR files have 16-bit floats instead of 32-bit.
    pub half: bool,
    /// Whether each layer has a part of its own in EXR files.
    pub multipart: bool,
    /// Bits of a channel of PNG files, 8 by default. JPEG has 8 and TIFF 16 in any case.
    pub bit_depth: Option<BitDepth>,
    /// Exposure of formats for display.
    pub exposure: DisplayExposure,
    /// Light that formats for display show as white.
    pub white_balance: WhiteBalance,
    /// Tone curve of formats for display.
    pub tone: ToneCurve,
    /// Colour space of EXR files, which have its `chromaticities`; `None` is linear sRGB. Files
    /// for display are always sRGB.
    pub space: Option<Primaries>,
    /// Whether the file has one channel, the first of the picture: that of a mosaic, whose channels are
    /// equal. EXR files call it `Y`.
    pub grey: bool,
    /// The sensor of a grey picture, whose readings DNG files hold as codes.
    pub raw: Option<RawFormat>,
}

impl EncodingOptions {
    /// Checks that a file can be written with these options.
    ///
    /// # Errors
    /// Returns an error if the extension is unknown, a DNG has no mosaic, or the format has another number of
    /// bits than asked for.
    pub fn check(&self, path: &Path) -> Result<(), ImageError> {
        self.writer(path).map(drop)
    }

    /// Returns the writer of a file.
    pub(super) fn writer(&self, path: &Path) -> Result<Writer, ImageError> {
        let (format, path) = (ImageFormat::of(path)?, path.to_owned());
        if self.bit_depth.is_some() && format.display_depth(self.bit_depth) != self.bit_depth {
            return Err(ImageError::BitDepth { path, bits: format.bits(None) });
        }
        Ok(match format {
            ImageFormat::Exr => Writer::Exr,
            ImageFormat::Png => Writer::Png(self.bit_depth.unwrap_or_default()),
            ImageFormat::Jpeg => Writer::Jpeg,
            ImageFormat::Tiff => Writer::Tiff,
            ImageFormat::Dng => match self.raw.filter(|_| self.grey) {
                None => return Err(ImageError::NoMosaic { path }),
                Some(mosaic) if mosaic.filter_side > 1 => {
                    return Err(ImageError::QuadMosaic { path });
                }
                Some(RawFormat { bits, .. }) if bits > 16 => {
                    return Err(ImageError::RawRange { path, bits });
                }
                Some(mosaic) => Writer::Dng(Box::new(mosaic)),
            },
            ImageFormat::Npy => Writer::Npy,
        })
    }

    pub(super) fn mapping(&self) -> DisplayMapping {
        let Self { exposure, white_balance, tone, grey, .. } = *self;
        DisplayMapping { exposure, white_balance, tone, grey }
    }
}

/// A format with what it needs besides the picture.
pub(super) enum Writer {
    Exr,
    Png(BitDepth),
    Jpeg,
    Tiff,
    Dng(Box<RawFormat>),
    Npy,
}

/// File formats that can be written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum ImageFormat {
    /// OpenEXR.
    Exr,
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
    /// TIFF of 16 bits.
    Tiff,
    /// Digital Negative: the mosaic of a sensor, which [`RawFile`](crate::RawFile) reads.
    Dng,
    /// Array of NumPy: height x width x buckets of the spectral layer, or else height x width x 3 of
    /// linear sRGB, or height x width of a grey picture. It has no metadata and cannot be read.
    Npy,
}

/// Extensions of the formats that can be read.
pub(super) const READABLE: &str =
    ".exr, .png, .jpg, .jpeg, .tif, .tiff, .tga, .bmp, .gif, .qoi, .hdr and .pfm";
/// Extensions of the formats that can be written.
const WRITABLE: &str = ".exr, .png, .jpg, .jpeg, .tif, .tiff, .dng and .npy";

pub(super) fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

impl ImageFormat {
    /// Returns the format of a file name.
    ///
    /// # Errors
    /// Returns an error if the extension is none of .exr, .png, .jpg, .jpeg, .tif, .tiff, .dng and .npy.
    pub fn of(path: &Path) -> Result<Self, ImageError> {
        let found = extension(path);
        match found.as_str() {
            "exr" => Ok(Self::Exr),
            "png" => Ok(Self::Png),
            "jpg" | "jpeg" => Ok(Self::Jpeg),
            "tif" | "tiff" => Ok(Self::Tiff),
            "dng" => Ok(Self::Dng),
            "npy" => Ok(Self::Npy),
            _ => Err(ImageError::Format { path: path.to_owned(), found, known: WRITABLE }),
        }
    }

    /// Returns whether files of this format hold a layer of this name.
    pub fn holds(self, layer: &str) -> bool {
        match self {
            Self::Exr => true,
            Self::Png | Self::Tiff => layer == ALPHA_LAYER,
            Self::Jpeg | Self::Dng => false,
            Self::Npy => layer == SPECTRAL_LAYER,
        }
    }

    /// Returns whether files of this format hold linear light, instead of the signals of a display.
    pub fn is_linear(self) -> bool {
        self.display_depth(None).is_none()
    }

    /// Returns the bits of a channel of files of this format in words.
    pub fn bits(self, asked: Option<BitDepth>) -> &'static str {
        match (self.display_depth(asked), self) {
            (Some(BitDepth::Eight), _) => "8 bits",
            (Some(BitDepth::Sixteen), _) => "16 bits",
            (None, Self::Dng) => "the codes of the sensor",
            (None, _) => "floats",
        }
    }

    /// Returns the bits of a channel of files of this format for display, of those that are asked for; `None` for
    /// formats of linear light.
    pub fn display_depth(self, asked: Option<BitDepth>) -> Option<BitDepth> {
        match self {
            Self::Exr | Self::Npy | Self::Dng => None,
            Self::Png => Some(asked.unwrap_or_default()),
            Self::Jpeg => Some(BitDepth::Eight),
            Self::Tiff => Some(BitDepth::Sixteen),
        }
    }
}
