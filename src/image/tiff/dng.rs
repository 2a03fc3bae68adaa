//! DNG files: the mosaic of a sensor as raw converters read it (Adobe, Digital Negative Specification
//! 1.7.1.0, 2023).
//!
//! The one directory of the file holds the codes, uncompressed and without a preview, as DNG 1.4 describes
//! them; converters since 2004 read that.

use std::borrow::Cow;
use std::io::{self, Seek, Write};

use tiff::TiffResult;
use tiff::encoder::{Rational, SRational, TiffEncoder, TiffValue};
use tiff::tags::{Tag, Type};

use super::tags::{COLOR_FILTER_ARRAY, D65, TUNGSTEN};
use super::{Directory, ascii, io_error, rational, text_of};
use crate::display::dimensions;
use crate::raw::RawFormat;
use crate::{Note, Notes, Picture, PictureWindow, find_note, find_number};

/// `SensitivityType` of Exif: the speed is an ISO speed.
const ISO_SPEED: u16 = 3;

/// Tags of DNG, TIFF/EP and Exif that the crate does not name.
mod tags {
    use tiff::tags::Tag;

    use super::super::tags as known;

    const fn both([a, b]: [u16; 2]) -> [Tag; 2] {
        [Tag::Unknown(a), Tag::Unknown(b)]
    }

    pub const CFA_REPEAT_PATTERN_DIM: Tag = Tag::Unknown(known::CFA_SIZE);
    pub const CFA_PATTERN: Tag = Tag::Unknown(known::CFA_PATTERN);
    pub const DNG_VERSION: Tag = Tag::Unknown(50706);
    pub const DNG_BACKWARD_VERSION: Tag = Tag::Unknown(50707);
    pub const UNIQUE_CAMERA_MODEL: Tag = Tag::Unknown(50708);
    pub const BLACK_LEVEL: Tag = Tag::Unknown(known::BLACK_LEVEL);
    pub const WHITE_LEVEL: Tag = Tag::Unknown(known::WHITE_LEVEL);
    pub const COLOR_MATRIX: [Tag; 2] = both(known::COLOR_MATRIX);
    pub const FORWARD_MATRIX: [Tag; 2] = both(known::FORWARD_MATRIX);
    pub const AS_SHOT_NEUTRAL: Tag = Tag::Unknown(known::AS_SHOT_NEUTRAL);
    pub const BASELINE_EXPOSURE: Tag = Tag::Unknown(known::BASELINE_EXPOSURE);
    pub const CALIBRATION_ILLUMINANT: [Tag; 2] = both(known::CALIBRATION_ILLUMINANT);
    pub const NOISE_PROFILE: Tag = Tag::Unknown(51041);
    pub const OPCODE_LIST_3: Tag = Tag::Unknown(known::OPCODE_LISTS[2]);
    pub const EXPOSURE_TIME: Tag = Tag::Unknown(33434);
    pub const F_NUMBER: Tag = Tag::Unknown(33437);
    pub const ISO_SPEED_RATINGS: Tag = Tag::Unknown(34855);
    pub const SENSITIVITY_TYPE: Tag = Tag::Unknown(34864);
    pub const ISO_SPEED: Tag = Tag::Unknown(34867);
    pub const EXIF_VERSION: Tag = Tag::Unknown(36864);
    pub const FOCAL_LENGTH: Tag = Tag::Unknown(37386);
    pub const LENS_MODEL: Tag = Tag::Unknown(42036);
}

/// Writes a mosaic, a part of its frame.
pub(crate) fn write_dng(
    picture: &Picture,
    raw: &RawFormat,
    window: PictureWindow,
    notes: &Notes,
    file: impl Write + Seek,
) -> io::Result<()> {
    write(picture, raw, window, notes, file).map_err(io_error)
}

fn write(
    picture: &Picture,
    raw: &RawFormat,
    window: PictureWindow,
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
    let camera = raw.camera_name();
    to.write_tag(Tag::Model, &*camera)?;
    to.write_tag(Tag::StripOffsets, offset)?;
    to.write_tag(Tag::Orientation, 1u16)?;
    to.write_tag(Tag::SamplesPerPixel, 1u16)?;
    to.write_tag(Tag::RowsPerStrip, height)?;
    to.write_tag(Tag::StripByteCounts, bytes)?;
    to.write_tag(Tag::PlanarConfiguration, 1u16)?;
    to.write_tag(Tag::Software, concat!("petzval ", env!("CARGO_PKG_VERSION")))?;
    to.write_tag(Tag::ExifDirectory, exif.offset)?;
    to.write_tag(tags::CFA_REPEAT_PATTERN_DIM, &[2u16, 2][..])?;
    to.write_tag(tags::CFA_PATTERN, &raw.filters_from(window.origin)[..])?;
    to.write_tag(tags::DNG_VERSION, &[1u8, 4, 0, 0][..])?;
    to.write_tag(tags::DNG_BACKWARD_VERSION, &[1u8, 1, 0, 0][..])?;
    to.write_tag(tags::UNIQUE_CAMERA_MODEL, &*format!("petzval {camera}"))?;
    to.write_tag(tags::BLACK_LEVEL, raw.black)?;
    to.write_tag(tags::WHITE_LEVEL, raw.saturation)?;
    write_colours(&mut to, raw)?;
    // Converters stretch up to the saturation, which is less than the white of the picture at low speeds.
    let span = f64::from(raw.white - raw.black) / f64::from(raw.saturation - raw.black);
    // They also stretch the largest channel of white to 1.
    let stretch = span * raw.largest_neutral;
    to.write_tag(tags::BASELINE_EXPOSURE, signed_rational(-stretch.log2()))?;
    // One pair for all channels: they have the same gain.
    let [signal, dark] = raw.noise;
    to.write_tag(tags::NOISE_PROFILE, &[signal * span, dark * span * span][..])?;
    let correction = raw.correction.and_then(|lens| lens.opcodes(picture.size, window));
    if let Some(opcodes) = correction {
        to.write_tag(tags::OPCODE_LIST_3, Undefined(&opcodes))?;
    }
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
    matrix.iter().flatten().map(|&element| signed_rational(element)).collect()
}

fn signed_rational(x: f64) -> SRational {
    SRational { n: (x * 1e6).round() as i32, d: 1_000_000 }
}

/// Writes the exposure as tags of Exif 2.32. What is not known is left out.
fn write_exif<W: Write + Seek>(to: &mut Directory<'_, W>, notes: &Notes) -> TiffResult<()> {
    to.write_tag(tags::EXIF_VERSION, Undefined(b"0232"))?;
    for (tag, name) in [
        (tags::EXPOSURE_TIME, "expTime"),
        (tags::F_NUMBER, "aperture"),
        (tags::FOCAL_LENGTH, "effectiveFocalLength"),
    ] {
        let known = find_number(notes, name);
        if let Some(number) = known.filter(|number| number.is_normal() && *number > 0.0) {
            to.write_tag(tag, rational(number))?;
        }
    }
    if let Some(iso) = find_number(notes, "isoSpeed") {
        // Exif's short number ends here; a long one follows.
        to.write_tag(tags::ISO_SPEED_RATINGS, iso.round().min(f64::from(u16::MAX)) as u16)?;
        to.write_tag(tags::SENSITIVITY_TYPE, ISO_SPEED)?;
        to.write_tag(tags::ISO_SPEED, iso.round() as u32)?;
    }
    if let Some(Note::Text(lens)) = find_note(notes, "lensModel") {
        to.write_tag(tags::LENS_MODEL, &*ascii(lens))?;
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

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use tiff::decoder::Decoder;
    use tiff::decoder::ifd::Value;

    use super::*;
    use crate::raw::{ColourCalibration, RawCamera};

    const COLOURS: ColourCalibration =
        ColourCalibration { from_xyz: [[1.5, -0.25, 0.0]; 3], to_xyz_d50: [[0.5; 3]; 3] };

    fn numbers_of(value: Value) -> Vec<f64> {
        match value {
            Value::List(values) => values.into_iter().flat_map(numbers_of).collect(),
            Value::Rational(n, d) => vec![f64::from(n) / f64::from(d)],
            Value::SRational(n, d) => vec![f64::from(n) / f64::from(d)],
            Value::Double(number) => vec![number],
            Value::Byte(number) => vec![f64::from(number)],
            Value::Short(number) => vec![f64::from(number)],
            Value::Unsigned(number) => vec![f64::from(number)],
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn codes_and_tags_are_those_of_the_sensor() {
        let raw = RawFormat {
            camera: RawCamera::Own,
            filters: [0, 1, 1, 2],
            filter_side: 1,
            correction: None,
            largest_neutral: 1.0,
            black: 100,
            white: 1123,
            bits: 11,
            saturation: 612,
            daylight: COLOURS,
            tungsten: Some(COLOURS),
            neutral: [0.5, 1.0, 0.75],
            noise: [0.01, 0.0001],
        };
        let codes: Vec<u16> = (0..600).map(|i| (i * 37) % 1124).collect();
        let value = |code: &u16| [(f32::from(*code) - 100.0) / 1023.0; 3];
        let picture = Picture { size: [30, 20], pixels: codes.iter().map(value).collect() };
        let notes = vec![
            ("lensModel", Note::Text("Elmar \u{b5}".to_owned())),
            ("expTime", Note::Number(1.0 / 32_000.0)),
            ("aperture", Note::Number(f64::INFINITY)),
            ("isoSpeed", Note::Number(102_400.0)),
        ];
        let mut file = Cursor::new(Vec::new());
        let window = PictureWindow { origin: [7, 2], frame: [100, 80] };
        write_dng(&picture, &raw, window, &notes, &mut file).unwrap();
        let mut bytes = file.into_inner();
        // The decoder knows no mosaics: their entry becomes that of a grey picture.
        let entry = |interpretation: u16| {
            let short = [262u16, 3].map(u16::to_ne_bytes).concat();
            [short, 1u32.to_ne_bytes().to_vec(), interpretation.to_ne_bytes().to_vec()].concat()
        };
        let mosaic = entry(COLOR_FILTER_ARRAY);
        let at = bytes.windows(10).position(|found| found == mosaic).expect("a mosaic");
        bytes[at..at + 10].copy_from_slice(&entry(1));
        let mut decoder = Decoder::new(Cursor::new(&bytes)).unwrap();
        let mut numbers = |tag: Tag| decoder.find_tag(tag).unwrap().map(numbers_of);
        let offset = numbers(Tag::StripOffsets).unwrap()[0] as usize;
        let stored = bytes[offset..][..1200].as_chunks::<2>().0.iter();
        assert!(stored.map(|code| u16::from_ne_bytes(*code)).eq(codes));
        for (tag, expected) in [
            (tags::CFA_PATTERN, vec![1.0, 0.0, 2.0, 1.0]),
            (tags::BLACK_LEVEL, vec![100.0]),
            (tags::WHITE_LEVEL, vec![612.0]),
            (tags::BASELINE_EXPOSURE, vec![-0.998_59]),
            (tags::AS_SHOT_NEUTRAL, vec![0.5, 1.0, 0.75]),
            (tags::COLOR_MATRIX[1], COLOURS.from_xyz.as_flattened().to_vec()),
            (tags::CALIBRATION_ILLUMINANT[0], vec![17.0]),
            (tags::CALIBRATION_ILLUMINANT[1], vec![21.0]),
            (
                tags::NOISE_PROFILE,
                vec![0.01 * 1023.0 / 512.0, 0.0001 * (1023.0_f64 / 512.0).powi(2)],
            ),
        ] {
            let found = numbers(tag).unwrap_or_else(|| panic!("no {tag:?}"));
            assert_eq!(found.len(), expected.len(), "{tag:?}");
            let off = found.iter().zip(&expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 1e-5, "{tag:?}: {found:?}, not {expected:?}");
        }
        let exif = numbers(Tag::ExifDirectory).unwrap()[0] as u64;
        let exif = decoder.read_directory(tiff::tags::IfdPointer(exif)).unwrap();
        let mut exif = decoder.read_directory_tags(&exif);
        let mut find = |tag: Tag| exif.find_tag(tag).unwrap();
        let time = find(tags::EXPOSURE_TIME).map(numbers_of).unwrap();
        assert!((time[0] * 32_000.0 - 1.0).abs() < 1e-6);
        assert_eq!(find(tags::F_NUMBER), None, "it is not finite");
        assert_eq!(find(tags::ISO_SPEED_RATINGS).unwrap().into_u32().unwrap(), 65535);
        assert_eq!(find(tags::ISO_SPEED).unwrap().into_u32().unwrap(), 102_400);
        assert_eq!(find(tags::LENS_MODEL).unwrap().into_string().unwrap(), "Elmar ?");
    }
}
