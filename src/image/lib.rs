//! Image files: EXR, PNG, JPEG and TIFF, read and written, NPY, which is only written, DNG, whose codes are read
//! as [`RawCodes`], and formats that are only read.
//!
//! Writing is atomic: a picture is written under a temporary name and renamed, so the final name
//! holds either the complete new picture or the previous file.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod array;
mod channels;
mod declared;
mod develop;
mod display;
mod exr;
mod format;
mod lens_correction;
mod pfm;
mod raster;
mod raw;
mod raw_codes;
mod spectral;
mod tiff;
mod tone;
mod white_balance;

use std::fmt;
use std::fs::File;
use std::io::{self, BufWriter, Read};
use std::path::{Path, PathBuf};

pub use channels::ChannelImage;
pub use develop::{DevelopError, Developed, RawFile};
use display::DisplayMapping;
pub use display::decode_image;
pub use display::{DisplayExposure, srgb_decode, srgb_encode};
pub use exr::PictureLayers;
pub use format::{BitDepth, EncodingOptions, ImageFormat};
use format::{READABLE, Writer, extension};
pub use lens_correction::LensCorrection;
pub use pfm::write_pfm;
pub use raster::{ImageSamples, Raster, Transfer};
pub use raw::{ColourCalibration, RawCamera, RawFormat};
pub use raw_codes::RawCodes;
pub use spectral::{SPECTRAL_LAYER, channel_wavelength, spectral_layer};
pub use tone::ToneCurve;
pub use white_balance::WhiteBalance;

pub use petzval_spectrum::Primaries;

use petzval_base::io::{OutputFile, ReadContext, path_excerpt};

/// Pixels in linear sRGB, row 0 at the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Width and height (pixels).
    pub size: [usize; 2],
    /// Linear R, G and B, row after row.
    pub pixels: Vec<[f32; 3]>,
}

/// Per-pixel data besides colour, such as depths, shares or counts.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct ImageLayer {
    /// Name of the layer; its channels are called `name.channel`. That of [`ALPHA_LAYER`] is called A.
    pub name: String,
    /// Channels: a name, and a value for each pixel, row after row from the top.
    pub channels: Vec<(String, Vec<f32>)>,
    /// Metadata of the layer, which EXR files hold as attributes.
    pub notes: Notes,
}

impl ImageLayer {
    /// Returns a layer without metadata.
    pub fn new(name: &str, channels: Vec<(String, Vec<f32>)>) -> Self {
        Self { name: name.to_owned(), channels, notes: Notes::new() }
    }
}

/// Name of the layer of opacity: the channel A of a picture whose colours are premultiplied by it.
pub const ALPHA_LAYER: &str = "alpha";

/// Value of a metadata entry.
#[derive(Clone, Debug, PartialEq)]
pub enum Note {
    /// Text.
    Text(String),
    /// A number, in the unit that belongs to the entry's name.
    Number(f64),
}

impl fmt::Display for Note {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Text(text) => to.write_str(text),
            Self::Number(number) => number.fmt(to),
        }
    }
}

/// Metadata of a picture, by name, in the order of writing.
pub type Notes = Vec<(&'static str, Note)>;

/// Returns the value of an entry.
pub fn find_note<'a>(notes: &'a Notes, name: &str) -> Option<&'a Note> {
    notes.iter().find(|(other, _)| *other == name).map(|(_, note)| note)
}

/// Returns the value of an entry, if it is a number.
pub fn find_number(notes: &Notes, name: &str) -> Option<f64> {
    match find_note(notes, name) {
        Some(Note::Number(number)) => Some(*number),
        _ => None,
    }
}

/// Position of a picture in the frame that it is a part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PictureWindow {
    /// Upper left pixel in the frame.
    pub origin: [u32; 2],
    /// Width and height of the frame (pixels).
    pub frame: [u32; 2],
}

/// Why a picture cannot be read or written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ImageError {
    /// The file could not be opened, read or written.
    #[error("cannot {verb} the picture {}: {source}", path_excerpt(path))]
    Io {
        /// "read" or "write".
        verb: &'static str,
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
    /// The content is not a valid picture of the format that its name says.
    #[error("cannot read the picture {}: {found}", path_excerpt(path))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// The problem.
        found: String,
    },
    /// A raw file is read as a picture.
    #[error(
        "{}: a raw file is no picture yet; develop it first, as by petzval develop",
        path_excerpt(path)
    )]
    Raw {
        /// The file.
        path: PathBuf,
    },
    /// The format cannot hold layers.
    #[error(
        "{}: only EXR holds layers, PNG and TIFF the layer {ALPHA_LAYER}, and NPY spectra; name a picture.exr",
        path_excerpt(path)
    )]
    NoLayers {
        /// The file.
        path: PathBuf,
    },
    /// Raw converters read no quad patterns.
    #[error(
        "{}: DNG holds mosaics of single filters, and this is a quad pattern; choose another 'bayer', or name a \
         picture.exr or .tif",
        path_excerpt(path)
    )]
    QuadMosaic {
        /// The file.
        path: PathBuf,
    },
    /// A DNG file has codes of 16 bits, and those of the sensor have more.
    #[error(
        "{}: the sensor's codes have {bits} bits, and those of DNG 16: reduce 'bits' or 'hdr', or name a picture.exr",
        path_excerpt(path)
    )]
    RawRange {
        /// The file.
        path: PathBuf,
        /// The bits of the codes.
        bits: u32,
    },
    /// A DNG file holds the mosaic of a sensor, and the picture is none.
    #[error(
        "{}: DNG holds the mosaic of a sensor; add 'bayer', or name a picture.exr or .tif",
        path_excerpt(path)
    )]
    NoMosaic {
        /// The file.
        path: PathBuf,
    },
    /// The format has another number of bits.
    #[error("{}: 'bit_depth' is for PNG, and this file has {bits}", path_excerpt(path))]
    BitDepth {
        /// The file.
        path: PathBuf,
        /// Bits of a channel of the format.
        bits: &'static str,
    },
    /// The extension belongs to no known format.
    #[error(
        "{}: the extension {found:?} names no picture format; known are {known}",
        path_excerpt(path)
    )]
    Format {
        /// The file.
        path: PathBuf,
        /// Its extension.
        found: String,
        /// The extensions that can be read or written.
        known: &'static str,
    },
}

/// Returns the curve that the header of a QOI file declares (qoiformat.org): its last byte is 1 if
/// all channels are linear.
fn qoi_transfer(path: &Path) -> Result<Transfer, ImageError> {
    let mut header = [0; 14];
    let read = File::open(path).and_then(|mut file| file.read_exact(&mut header));
    read.map_err(|source| ImageError::Io { verb: "read", path: path.to_owned(), source })?;
    Ok(if header[13] == 1 { Transfer::Linear } else { Transfer::Srgb })
}

impl Picture {
    /// Reads a picture. Signals of formats for display are decoded from sRGB. EXR files with
    /// `chromaticities` are converted to sRGB, with the same X, Y and Z.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read or is not a picture.
    pub fn read(path: &Path) -> Result<Self, ImageError> {
        Self::read_with(path, Transfer::Srgb, &ReadContext::default())
    }

    /// Reads a picture as [`Picture::read`] does. Also returns whether the file has a single colour
    /// channel, which all three channels of the picture repeat.
    ///
    /// # Errors
    /// As [`Picture::read`].
    pub fn read_with_grey(path: &Path) -> Result<(Self, bool), ImageError> {
        Self::read_file(path, Transfer::Srgb, &ReadContext::default())
    }

    /// Reads a picture whose signals of 8 or 16 bits have this transfer curve.
    ///
    /// # Errors
    /// Returns an error if the file cannot be read, is not a picture, or exceeds the memory budget.
    pub fn read_with(
        path: &Path,
        transfer: Transfer,
        context: &ReadContext,
    ) -> Result<Self, ImageError> {
        Self::read_file(path, transfer, context).map(|(picture, _)| picture)
    }

    /// Reads a picture, and whether its file has a single colour channel.
    fn read_file(
        path: &Path,
        transfer: Transfer,
        context: &ReadContext,
    ) -> Result<(Self, bool), ImageError> {
        let refused = |source| ImageError::Io { verb: "read", path: path.to_owned(), source };
        context.register(path).map_err(refused)?;
        let ((picture, grey), held) = match extension(path).as_str() {
            "exr" => exr::read(path, context)?,
            "png" | "jpg" | "jpeg" | "tif" | "tiff" | "tga" | "bmp" | "gif" => {
                display::read(path, transfer, context)?
            }
            "qoi" => display::read(path, qoi_transfer(path)?, context)?,
            // Radiance pictures hold linear light.
            "hdr" => display::read(path, Transfer::Linear, context)?,
            "pfm" => {
                let (raster, held) = pfm::read(path, context)?;
                let grey = raster.channels == 1;
                ((raster.into_picture(), grey), held)
            }
            "dng" => return Err(ImageError::Raw { path: path.to_owned() }),
            found => {
                return Err(ImageError::Format {
                    path: path.to_owned(),
                    found: found.to_owned(),
                    known: READABLE,
                });
            }
        };
        let kept = held.keep(size_of_val(&picture.pixels[..]) as u64);
        kept.map_err(|found| declared::too_large(path, found))?;
        Ok((picture, grey))
    }

    /// Writes the picture in the format of the file's extension.
    ///
    /// # Errors
    /// Returns an error if the extension is unknown or the file cannot be written. The previous
    /// file of that name is then unchanged.
    pub fn write(
        &self,
        to: &OutputFile,
        window: PictureWindow,
        encoding: EncodingOptions,
        notes: &Notes,
    ) -> Result<(), ImageError> {
        self.write_with_layers(&[], to, window, encoding, notes)
    }

    /// Encodes the picture, multiplied by a factor, as a PNG file.
    ///
    /// # Errors
    /// Returns an error if PNG does not support the size.
    pub fn png(&self, factor: f32) -> io::Result<Vec<u8>> {
        let mut file = Vec::new();
        let mapping = DisplayMapping::by(factor);
        display::write_png(self, None, mapping, BitDepth::Eight, &Vec::new(), &mut file)?;
        Ok(file)
    }

    /// Encodes the picture, multiplied by a factor, as a JPEG file of this quality, of 100.
    ///
    /// # Errors
    /// Returns an error if JPEG does not support the size.
    pub fn jpeg(&self, factor: f32, quality: u8) -> io::Result<Vec<u8>> {
        let mut file = Vec::new();
        display::write_jpeg(self, DisplayMapping::by(factor), quality, &Vec::new(), &mut file)?;
        Ok(file)
    }

    /// Writes the picture with layers. With [`ALPHA_LAYER`], its colours are premultiplied: an EXR
    /// keeps them, and a PNG or TIFF gets straight colours. Light without opacity, such as a flare before an
    /// empty background, is in the EXR alone.
    ///
    /// # Errors
    /// As [`Picture::write`]. Also returns an error if the format does not hold a layer or is for mosaics only,
    /// or if a layer has another size than the picture.
    pub fn write_with_layers(
        &self,
        layers: &[ImageLayer],
        to: &OutputFile,
        window: PictureWindow,
        encoding: EncodingOptions,
        notes: &Notes,
    ) -> Result<(), ImageError> {
        let path = to.path();
        let format = ImageFormat::of(path)?;
        if !layers.iter().all(|layer| format.holds(&layer.name)) {
            return Err(ImageError::NoLayers { path: path.to_owned() });
        }
        let writer = encoding.writer(path)?;
        let io = |source| ImageError::Io { verb: "write", path: path.to_owned(), source };
        let alpha = layers.iter().find(|layer| layer.name == ALPHA_LAYER);
        let alpha = alpha.and_then(|layer| layer.channels.first());
        let alpha = alpha.map(|(_, values)| &values[..]);
        to.write(|file| match writer {
            Writer::Exr => exr::write(self, layers, window, encoding, notes, file),
            Writer::Png(depth) => display::write_png(
                self,
                alpha,
                encoding.mapping(),
                depth,
                notes,
                BufWriter::new(file),
            ),
            Writer::Tiff => {
                tiff::write_tiff(self, alpha, encoding.mapping(), notes, BufWriter::new(file))
            }
            Writer::Dng(raw) => tiff::write_dng(self, &raw, window, notes, BufWriter::new(file)),
            Writer::Npy => {
                let spectrum = layers.iter().find(|layer| layer.name == SPECTRAL_LAYER);
                array::write(self, spectrum, encoding.grey, BufWriter::new(file))
            }
            Writer::Jpeg => {
                let mapping = encoding.mapping();
                display::write_jpeg(self, mapping, JPEG_QUALITY, notes, BufWriter::new(file))
            }
        })
        .map_err(io)
    }
}

/// Quality of JPEG files, of 100.
const JPEG_QUALITY: u8 = 95;
