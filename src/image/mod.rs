//! Pictures in files: EXR, PNG and JPEG, in and out.
//!
//! Writing is atomic: a picture is written beside its final name and renamed, so that the name
//! holds either the whole new picture or what it held before.

mod declared;
mod display;
mod exr;
mod pfm;
mod raster;
mod replace;

use std::io::{self, BufWriter};
use std::path::{Path, PathBuf};

pub use display::{Exposure, srgb_decode, srgb_encode};
pub use raster::{Raster, Samples, Transfer};
pub use replace::{replace, sweep, target};

use crate::source::{self, shown};

/// Linear RGB pixels, row 0 at the top.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Picture {
    /// Width and height.
    pub size: [usize; 2],
    /// Row after row.
    pub pixels: Vec<[f32; 3]>,
}

/// What is known of every pixel beside its colour: distances, shares, numbers of things.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layer {
    /// What it is about; its channels are called `name.channel`.
    pub name: String,
    /// Names, and a value for each pixel of the picture, row after row from the top.
    pub channels: Vec<(String, Vec<f32>)>,
}

/// One thing to know about a picture, written into its file.
#[derive(Clone, Debug, PartialEq)]
pub enum Note {
    /// Words.
    Text(String),
    /// A number; its name says the unit.
    Number(f64),
}

/// What is known about a picture, by name, in order.
pub type Notes = Vec<(&'static str, Note)>;

/// Where a picture lies in the frame it is a part of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Its upper left pixel in the frame.
    pub origin: [u32; 2],
    /// Width and height of the frame.
    pub frame: [u32; 2],
}

/// How a picture is written.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Encoding {
    /// 16-bit floats instead of 32-bit, EXR only.
    pub half: bool,
    /// What 8-bit formats multiply the picture by.
    pub exposure: Exposure,
}

/// The formats, by file name extension.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Format {
    /// OpenEXR.
    Exr,
    /// PNG.
    Png,
    /// JPEG.
    Jpeg,
}

/// Why a picture could not be read or written.
#[derive(Debug, thiserror::Error)]
pub enum ImageError {
    /// The file could not be opened, read or written.
    #[error("cannot {verb} the picture {}: {source}", shown(path))]
    Io {
        /// "read" or "write".
        verb: &'static str,
        /// The file.
        path: PathBuf,
        /// What the system said.
        source: io::Error,
    },
    /// The content is not what its name promises.
    #[error("cannot read the picture {}: {found}", shown(path))]
    Malformed {
        /// The file.
        path: PathBuf,
        /// What is wrong.
        found: String,
    },
    /// The format holds no layers.
    #[error("{}: only EXR holds layers; name a picture.exr", shown(path))]
    NoLayers {
        /// The file.
        path: PathBuf,
    },
    /// The extension says no known format.
    #[error("{}: the extension {found:?} names no picture format; known are {known}", shown(path))]
    Format {
        /// The file.
        path: PathBuf,
        /// Its extension.
        found: String,
        /// What can be read or written.
        known: &'static str,
    },
}

fn extension(path: &Path) -> String {
    path.extension().unwrap_or_default().to_string_lossy().to_lowercase()
}

impl Format {
    /// The format that a file name asks for.
    ///
    /// # Errors
    /// Where the extension is none of .exr .png .jpg .jpeg.
    pub fn of(path: &Path) -> Result<Self, ImageError> {
        let found = extension(path);
        match found.as_str() {
            "exr" => Ok(Self::Exr),
            "png" => Ok(Self::Png),
            "jpg" | "jpeg" => Ok(Self::Jpeg),
            _ => Err(ImageError::Format {
                path: path.to_owned(),
                found,
                known: ".exr, .png, .jpg and .jpeg",
            }),
        }
    }
}

impl Picture {
    /// Reads a picture. Pixels of 8-bit formats are decoded from sRGB if `srgb` says so.
    ///
    /// # Errors
    /// Where the file cannot be read or is no picture.
    pub fn read(path: &Path, srgb: bool) -> Result<Self, ImageError> {
        let refused = |source| ImageError::Io { verb: "read", path: path.to_owned(), source };
        source::register(path).map_err(refused)?;
        match extension(path).as_str() {
            "exr" => exr::read(path),
            "png" | "jpg" | "jpeg" | "tga" => display::read(path, srgb),
            // Radiance pictures hold linear light.
            "hdr" => display::read(path, false),
            "pfm" => Ok(pfm::read(path)?.into_picture()),
            found => Err(ImageError::Format {
                path: path.to_owned(),
                found: found.to_owned(),
                known: ".exr, .png, .jpg, .jpeg, .tga, .hdr and .pfm",
            }),
        }
    }

    /// Writes the picture in the format of the file's extension.
    ///
    /// # Errors
    /// Where the extension is unknown or the file cannot be written; what stood under its
    /// name is then still there.
    pub fn write(
        &self,
        path: &Path,
        window: Window,
        encoding: Encoding,
        notes: &Notes,
    ) -> Result<(), ImageError> {
        self.write_with_layers(&[], path, window, encoding, notes)
    }

    /// The picture as a PNG file, multiplied by a factor.
    ///
    /// # Errors
    /// Where its size is none that PNG has.
    pub fn png(&self, factor: f32) -> io::Result<Vec<u8>> {
        let mut file = Vec::new();
        display::write_png(self, Exposure::by(factor), &Vec::new(), &mut file)?;
        Ok(file)
    }

    /// The picture as a JPEG file, multiplied by a factor, of this quality, of 100.
    ///
    /// # Errors
    /// Where its size is none that JPEG has.
    pub fn jpeg(&self, factor: f32, quality: u8) -> io::Result<Vec<u8>> {
        let mut file = Vec::new();
        display::write_jpeg(self, Exposure::by(factor), quality, &mut file)?;
        Ok(file)
    }

    /// Writes the picture with layers beside its colours, into an EXR.
    ///
    /// # Errors
    /// As [`Picture::write`], and where there are layers that the format cannot hold or that are
    /// of another size.
    pub fn write_with_layers(
        &self,
        layers: &[Layer],
        path: &Path,
        window: Window,
        encoding: Encoding,
        notes: &Notes,
    ) -> Result<(), ImageError> {
        let format = Format::of(path)?;
        if !layers.is_empty() && format != Format::Exr {
            return Err(ImageError::NoLayers { path: path.to_owned() });
        }
        let io = |source| ImageError::Io { verb: "write", path: path.to_owned(), source };
        replace(path, |file| match format {
            Format::Exr => exr::write(self, layers, window, encoding.half, notes, file),
            Format::Png => display::write_png(self, encoding.exposure, notes, BufWriter::new(file)),
            Format::Jpeg => {
                display::write_jpeg(self, encoding.exposure, QUALITY, BufWriter::new(file))
            }
        })
        .map_err(io)
    }
}

/// The quality of JPEG files, of 100.
const QUALITY: u8 = 95;
