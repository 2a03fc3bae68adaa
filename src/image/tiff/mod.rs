//! TIFF files: pictures of 16 bits, and the mosaic of a sensor as DNG.

mod chunks;
mod display;
mod dng;
mod lossless_jpeg;
mod mosaic;
mod numbers;
mod raw_colours;
mod raw_tags;
mod tags;

use std::fs::File;
use std::io::{self, BufReader};
use std::path::Path;

use tiff::TiffError;
use tiff::decoder::Decoder;
use tiff::encoder::{DirectoryEncoder, Rational, TiffKindStandard};
use tiff::tags::{SampleFormat, Tag};

use super::{ImageError, Notes};

pub(super) use display::write_tiff;
pub(super) use dng::write_dng;
pub(super) use mosaic::{raw_samples, read_mosaic};
pub(super) use raw_tags::read_raw;

type Directory<'a, W> = DirectoryEncoder<'a, W, TiffKindStandard>;

fn io_error(error: TiffError) -> io::Error {
    match error {
        TiffError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

/// Checks that the samples of a file are of a type that the image crate tells apart: it takes those of 32 bits
/// for floats.
///
/// # Errors
/// Returns an error for whole numbers of 32 or 64 bits, or if the file cannot be read.
pub(super) fn check_samples(path: &Path) -> Result<(), ImageError> {
    let malformed = |found: String| ImageError::Malformed { path: path.to_owned(), found };
    let file = File::open(path).map_err(|source| ImageError::Io {
        verb: "read",
        path: path.to_owned(),
        source,
    })?;
    let decoder = Decoder::new(BufReader::new(file));
    let mut decoder = decoder.map_err(|error| malformed(error.to_string()))?;
    let mut numbers = |tag: Tag, default: u16| match decoder.find_tag(tag) {
        Ok(Some(value)) => value.into_u16_vec().ok().and_then(|all| all.first().copied()),
        _ => Some(default),
    };
    let [bits, format] = [numbers(Tag::BitsPerSample, 1), numbers(Tag::SampleFormat, 1)];
    let is_float = format == Some(SampleFormat::IEEEFP.to_u16());
    match (bits, is_float) {
        (Some(32 | 64), false) => Err(malformed(
            "it has whole numbers of 32 bits or more; expected 8 or 16 bits, or floats".to_owned(),
        )),
        _ => Ok(()),
    }
}

/// Returns the bits of the samples of a file.
///
/// # Errors
/// Returns what was found if the file is no TIFF, or white is 0 in it.
pub(super) fn bits_of_codes(path: &Path) -> Result<u32, String> {
    let file = File::open(path).map_err(|error| error.to_string())?;
    let mut decoder = Decoder::new(BufReader::new(file)).map_err(|error| error.to_string())?;
    let mut number = |tag| decoder.find_tag_unsigned_vec::<u32>(tag).ok().flatten();
    match number(Tag::PhotometricInterpretation).as_deref() {
        Some([0]) => Err("white is 0 in it; expected codes that grow with the light".to_owned()),
        _ => Ok(number(Tag::BitsPerSample).and_then(|bits| bits.first().copied()).unwrap_or(1)),
    }
}

/// Returns a fraction near a number from 0 to 4e9.
fn rational(x: f64) -> Rational {
    let x = if x.is_finite() { x.clamp(0.0, f64::from(u32::MAX)) } else { 0.0 };
    let mut d = 1_000_000_000;
    while x * f64::from(d) > f64::from(u32::MAX) {
        d /= 10;
    }
    Rational { n: (x * f64::from(d)).round() as u32, d }
}

/// Returns the notes as text: a line each, in the ASCII that TIFF has.
fn text_of(notes: &Notes) -> String {
    let lines = notes.iter().map(|(name, note)| format!("{name}: {note}\n"));
    ascii(&lines.collect::<String>())
}

/// Returns the text in ASCII, with question marks for what it cannot hold.
fn ascii(text: &str) -> String {
    text.chars().map(|c| if c.is_ascii() && c != '\0' { c } else { '?' }).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_are_near_their_numbers() {
        for x in [1e-6, 1.0 / 32_000.0, 1.0 / 125.0, 2.8, 50.008, 4294.0, 4295.0, 1e6, 4e9] {
            let Rational { n, d } = rational(x);
            let off = f64::from(n) / f64::from(d) / x - 1.0;
            assert!(off.abs() < 1e-7, "{x}: {n}/{d}");
        }
        assert_eq!(ascii("50 mm f/2, \u{fc}\0\n"), "50 mm f/2, ??\n");
        for odd in [f64::NAN, f64::INFINITY, -1.0] {
            assert_eq!(rational(odd).n, 0);
        }
    }
}
