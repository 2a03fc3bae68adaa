//! DNG files: the mosaic of a sensor as raw converters read it (Adobe, Digital Negative Specification
//! 1.7.1.0, 2023).
//!
//! The one directory of the file holds the codes, uncompressed and without a preview, as DNG 1.4 describes
//! them; converters of twenty years read that.

use std::borrow::Cow;
use std::io::{self, Seek, Write};

use tiff::TiffResult;
use tiff::encoder::{Rational, SRational, TiffEncoder, TiffValue};
use tiff::tags::{Tag, Type};

use super::{Directory, io_error, number, rational, text_of};
use crate::display::dimensions;
use crate::raw::RawFormat;
use crate::{Note, Notes, Picture};

/// Photometric interpretation of a mosaic.
const COLOR_FILTER_ARRAY: u16 = 32803;
/// `CalibrationIlluminant` of illuminant A and of D65: light sources of Exif.
const TUNGSTEN: u16 = 17;
const D65: u16 = 21;
/// `SensitivityType` of Exif: the speed is an ISO speed.
const ISO_SPEED: u16 = 3;

/// Tags of DNG and of TIFF/EP that the crate does not name.
mod tags {
    use tiff::tags::Tag;

    pub const CFA_REPEAT_PATTERN_DIM: Tag = Tag::Unknown(33421);
    pub const CFA_PATTERN: Tag = Tag::Unknown(33422);
    pub const DNG_VERSION: Tag = Tag::Unknown(50706);
    pub const DNG_BACKWARD_VERSION: Tag = Tag::Unknown(50707);
    pub const UNIQUE_CAMERA_MODEL: Tag = Tag::Unknown(50708);
    pub const BLACK_LEVEL: Tag = Tag::Unknown(50714);
    pub const WHITE_LEVEL: Tag = Tag::Unknown(50717);
    pub const COLOR_MATRIX: [Tag; 2] = [Tag::Unknown(50721), Tag::Unknown(50722)];
    pub const FORWARD_MATRIX: [Tag; 2] = [Tag::Unknown(50964), Tag::Unknown(50965)];
    pub const AS_SHOT_NEUTRAL: Tag = Tag::Unknown(50728);
    pub const CALIBRATION_ILLUMINANT: [Tag; 2] = [Tag::Unknown(50778), Tag::Unknown(50779)];
    pub const NOISE_PROFILE: Tag = Tag::Unknown(51041);
    pub const EXPOSURE_TIME: Tag = Tag::Unknown(33434);
    pub const F_NUMBER: Tag = Tag::Unknown(33437);
    pub const ISO_SPEED_RATINGS: Tag = Tag::Unknown(34855);
    pub const SENSITIVITY_TYPE: Tag = Tag::Unknown(34864);
    pub const ISO_SPEED: Tag = Tag::Unknown(34867);
    pub const EXIF_VERSION: Tag = Tag::Unknown(36864);
    pub const FOCAL_LENGTH: Tag = Tag::Unknown(37386);
    pub const LENS_MODEL: Tag = Tag::Unknown(42036);
}

/// Writes a mosaic whose first pixel is at `origin` of its frame.
pub(crate) fn write_dng(
    picture: &Picture,
    raw: &RawFormat,
    origin: [u32; 2],
    notes: &Notes,
    file: impl Write + Seek,
) -> io::Result<()> {
    write(picture, raw, origin, notes, file).map_err(io_error)
}

fn write(
    picture: &Picture,
    raw: &RawFormat,
    origin: [u32; 2],
    notes: &Notes,
    file: impl Write + Seek,
) -> TiffResult<()> {
    let [width, height] = dimensions(picture);
    let codes: Vec<u16> = picture.pixels.iter().map(|pixel| raw.code(pixel[0])).collect();
    let mut encoder = TiffEncoder::new(file)?;
    let mut exif = encoder.extra_directory()?;
    write_exif(&mut exif, notes)?;
    let exif = exif.finish_with_offsets()?;
    let mut to = encoder.image_directory()?;
    let offset = u32::try_from(to.write_data(&codes[..])?)?;
    let bytes = u32::try_from(size_of_val(&codes[..]))?;
    to.write_tag(Tag::NewSubfileType, 0u32)?;
    to.write_tag(Tag::ImageWidth, width)?;
    to.write_tag(Tag::ImageLength, height)?;
    to.write_tag(Tag::BitsPerSample, 16u16)?;
    to.write_tag(Tag::Compression, 1u16)?;
    to.write_tag(Tag::PhotometricInterpretation, COLOR_FILTER_ARRAY)?;
    to.write_tag(Tag::ImageDescription, &*text_of(notes))?;
    to.write_tag(Tag::Make, "petzval")?;
    let camera = raw.camera.unwrap_or("linear sRGB");
    to.write_tag(Tag::Model, camera)?;
    to.write_tag(Tag::StripOffsets, offset)?;
    to.write_tag(Tag::Orientation, 1u16)?;
    to.write_tag(Tag::SamplesPerPixel, 1u16)?;
    to.write_tag(Tag::RowsPerStrip, height)?;
    to.write_tag(Tag::StripByteCounts, bytes)?;
    to.write_tag(Tag::PlanarConfiguration, 1u16)?;
    to.write_tag(Tag::Software, concat!("petzval ", env!("CARGO_PKG_VERSION")))?;
    to.write_tag(Tag::ExifDirectory, exif.offset)?;
    to.write_tag(tags::CFA_REPEAT_PATTERN_DIM, &[2u16, 2][..])?;
    to.write_tag(tags::CFA_PATTERN, &raw.filters_from(origin)[..])?;
    to.write_tag(tags::DNG_VERSION, &[1u8, 4, 0, 0][..])?;
    to.write_tag(tags::DNG_BACKWARD_VERSION, &[1u8, 1, 0, 0][..])?;
    to.write_tag(tags::UNIQUE_CAMERA_MODEL, &*format!("petzval {camera}"))?;
    to.write_tag(tags::BLACK_LEVEL, raw.black)?;
    to.write_tag(tags::WHITE_LEVEL, raw.saturation)?;
    write_colours(&mut to, raw)?;
    // One pair for all channels: they have the same gain.
    let span = f64::from(raw.white - raw.black) / f64::from(raw.saturation - raw.black);
    let [signal, dark] = raw.noise;
    to.write_tag(tags::NOISE_PROFILE, &[signal * span, dark * span * span][..])?;
    to.finish()
}

/// Writes the matrices and the white balance. A matrix stands alone, or that of tungsten comes first, as converters
/// expect.
fn write_colours<W: Write + Seek>(to: &mut Directory<'_, W>, raw: &RawFormat) -> TiffResult<()> {
    let known = raw.tungsten.map(|colours| (colours, TUNGSTEN)).into_iter();
    for (k, (colours, illuminant)) in known.chain([(raw.daylight, D65)]).enumerate() {
        to.write_tag(tags::COLOR_MATRIX[k], &signed_rationals(&colours.from_xyz)[..])?;
        to.write_tag(tags::FORWARD_MATRIX[k], &signed_rationals(&colours.to_xyz_d50)[..])?;
        to.write_tag(tags::CALIBRATION_ILLUMINANT[k], illuminant)?;
    }
    let neutral: Vec<Rational> = raw.neutral.iter().map(|&share| rational(share)).collect();
    to.write_tag(tags::AS_SHOT_NEUTRAL, &neutral[..])
}

/// Returns the elements of a matrix, which are near 1, in millionths.
fn signed_rationals(matrix: &[[f64; 3]; 3]) -> Vec<SRational> {
    let fraction = |&x: &f64| SRational { n: (x * 1e6).round() as i32, d: 1_000_000 };
    matrix.iter().flatten().map(fraction).collect()
}

/// Writes what Exif 2.32 knows of an exposure.
fn write_exif<W: Write + Seek>(to: &mut Directory<'_, W>, notes: &Notes) -> TiffResult<()> {
    to.write_tag(tags::EXIF_VERSION, Undefined(b"0232"))?;
    for (tag, name) in [
        (tags::EXPOSURE_TIME, "expTime"),
        (tags::F_NUMBER, "aperture"),
        (tags::FOCAL_LENGTH, "effectiveFocalLength"),
    ] {
        if let Some(number) = number(notes, name) {
            to.write_tag(tag, rational(number))?;
        }
    }
    if let Some(iso) = number(notes, "isoSpeed") {
        // Exif's short number ends here; a long one follows.
        to.write_tag(tags::ISO_SPEED_RATINGS, iso.round().min(f64::from(u16::MAX)) as u16)?;
        to.write_tag(tags::SENSITIVITY_TYPE, ISO_SPEED)?;
        to.write_tag(tags::ISO_SPEED, iso.round() as u32)?;
    }
    if let Some((_, Note::Text(lens))) = notes.iter().find(|(name, _)| *name == "lensModel") {
        let ascii: String = lens.chars().map(|c| if c.is_ascii() { c } else { '?' }).collect();
        to.write_tag(tags::LENS_MODEL, &*ascii)?;
    }
    Ok(())
}

/// Bytes of the type UNDEFINED.
struct Undefined<'a>(&'a [u8]);

impl TiffValue for Undefined<'_> {
    const BYTE_LEN: u8 = 1;
    const FIELD_TYPE: Type = Type::UNDEFINED;

    fn count(&self) -> usize {
        self.0.len()
    }

    fn data(&self) -> Cow<'_, [u8]> {
        Cow::Borrowed(self.0)
    }
}
