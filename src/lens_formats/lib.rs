//! Readers of lens files, chosen by content, and writers.
//!
//! ```
//! use petzval_lens::Paraxial;
//!
//! # let root = concat!(env!("CARGO_MANIFEST_DIR"), "/../..");
//! # std::env::set_current_dir(root)?;
//! let lens = petzval_lens_formats::read("lenses/dgauss.50mm.dat".as_ref())?;
//! let focal_length = Paraxial::new(&lens).focal_length;
//! assert!((focal_length - 50.0).abs() < 1.0, "{focal_length}");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
//!
//! The feature `pictures` reads apertures that are pictures; it brings the codecs of pictures.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub(crate) mod axis;
mod checks;
pub(crate) mod codev;
mod csv;
pub(crate) mod dat;
mod diff_optics;
pub(crate) mod format;
mod fx;
pub(crate) mod glass_name;
mod json;
#[cfg(feature = "pictures")]
pub(crate) mod mask_file;
mod optical_bench;
pub mod options;
pub(crate) mod oslo;
mod placeholder;
pub(crate) mod report;
pub(crate) mod text;
pub(crate) mod toml;
pub(crate) mod write;
mod zar;
pub(crate) mod zmx;

pub use dat::parse as parse_dat;
#[cfg(feature = "pictures")]
pub use mask_file::{read_mask, read_mask_by_pbrt};
pub use options::LensOptions;
pub use toml::parse as parse_toml;
pub use write::{WrittenLens, write_lens};

use std::io::Read;
use std::path::{Path, PathBuf};

use format::LensFormat;
use petzval_base::io::ReadContext;
pub use petzval_lens::LensError;
use petzval_lens::Prescription;
use petzval_lens::RealRayFocus;
pub use petzval_lens::SpectralLine;
pub use petzval_lens::{INFINITE, MAX_INDEX, MIN_INDEX};

/// Largest size of a lens file (bytes).
const MAX_BYTES: usize = 1 << 20;

/// Largest number of surfaces of a file.
pub(crate) const MAX_SURFACES: usize = 1000;

/// Ratio of the f-number of the marginal ray to the stated one from which a file is suspicious.
const NARROWEST_RATIO: f64 = 1.25;

/// Highest power of an aspheric polynomial. Smaller coefficients than single precision holds belong to
/// higher ones.
pub(crate) const MAX_POWER: u32 = 30;

/// Range of wavelengths (nm): from the vacuum ultraviolet to radio waves of a metre.
pub(crate) const WAVELENGTHS: std::ops::RangeInclusive<f64> = 100.0..=1e9;

/// Smallest radius of curvature [mm]: a nanometre. The power of a much smaller one overflows.
pub(crate) const MIN_RADIUS: f64 = 1e-6;

/// Reads a lens: petzval's own format, or one of those that other programs write, told by its
/// content. `FILE#ENTRY` names a lens of a file that holds many.
///
/// # Errors
/// Returns an error if the file cannot be read or is not a lens, with the line.
pub fn read(path: &Path) -> Result<Prescription, LensError> {
    read_with(path, &ReadContext::default())
}

/// Reads a lens, and logs its files.
///
/// # Errors
/// Returns an error if the file cannot be read or is not a lens, with the line.
pub fn read_with(path: &Path, context: &ReadContext) -> Result<Prescription, LensError> {
    read_at(path, &[], context)
}

/// Reads a lens for these wavelengths (nm), the middle one as the primary one, or for those of the
/// file if there are none.
///
/// # Errors
/// Returns an error if the file cannot be read or is not a lens, or if a medium has no index at the
/// primary wavelength.
pub(crate) fn read_at(
    path: &Path,
    wavelengths: &[f64],
    context: &ReadContext,
) -> Result<Prescription, LensError> {
    let (mut lens, format) = parse(path, context)?;
    if !wavelengths.is_empty() {
        let lines = wavelengths.iter().map(|&nm| SpectralLine { nm, weight: 1.0 });
        lens.design.wavelengths = lines.collect();
        lens.design.primary = wavelengths.len() / 2;
    } else if format == LensFormat::Toml {
        return Ok(lens);
    }
    let nm = lens.design.primary_wavelength();
    match lens.at_wavelength(nm) {
        Ok(lens) => Ok(lens),
        Err(source) if context.approximates() => {
            lens.design.notes.push(format!("{source}; the index of the nearest end is used"));
            Ok(lens.at_checked_wavelength(nm))
        }
        Err(source) => Err(LensError::Wavelength { path: path.to_owned(), source }),
    }
}

/// Reads a lens at the primary wavelength of its file.
fn parse(path: &Path, context: &ReadContext) -> Result<(Prescription, LensFormat), LensError> {
    let (path, mut entry) = file_and_entry(path);
    let mut path = path.as_path();
    let io = |source| LensError::Io { path: path.to_owned(), source };
    let mut bytes = Vec::new();
    let mut file = context.open_lens(path).map_err(io)?;
    file.by_ref().take(MAX_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(io)?;
    let archive = zar::is_archive(&bytes);
    if archive {
        file.take(zar::MAX_ARCHIVE as u64).read_to_end(&mut bytes).map_err(io)?;
    }
    context.log(path, &bytes);
    let (packed, context) = match archive {
        true => {
            let packed = zar::unpack(path, &bytes, entry.take().as_deref())?;
            bytes = packed.bytes;
            (packed.path, &context.clone().with_packed_catalogues(packed.catalogues))
        }
        false => (path.to_owned(), context),
    };
    path = &packed;
    if bytes.len() > MAX_BYTES {
        return Err(LensError::Malformed {
            path: path.to_owned(),
            line: 1 + bytes[..MAX_BYTES].iter().filter(|&&byte| byte == b'\n').count(),
            column: None,
            found: "the file is larger than 1 MiB".into(),
            expected: "expected a lens file of a few short lines".into(),
        });
    }
    let text = text::decode(&bytes);
    if let Some(error) = placeholder::reject(path, &text) {
        return Err(error);
    }
    let format = LensFormat::detect(path, &text);
    if let (Some(entry), false) = (&entry, format == LensFormat::Json) {
        return Err(LensError::Malformed {
            path: path.to_owned(),
            line: 1,
            column: None,
            found: format!("\"{entry}\" is asked for, and the file holds one lens"),
            expected: "leave out what follows the #".into(),
        });
    }
    let lens = match format {
        LensFormat::Toml => toml::parse_with(path, &text, context),
        LensFormat::Dat => {
            let lines: Vec<&str> = text.lines().collect();
            dat::parse(path, &lines)
        }
        LensFormat::Zmx => zmx::parse(path, &text, context),
        LensFormat::CodeV => codev::parse(path, &text, context),
        LensFormat::Oslo => oslo::parse(path, &text, context),
        LensFormat::OpticalBench => optical_bench::parse(path, &text, context),
        LensFormat::Fx => fx::parse(path, &text, context),
        LensFormat::Json => json::parse(path, &text, entry.as_deref(), context),
        LensFormat::Csv => csv::parse(path, &text, context),
        LensFormat::DiffOptics => diff_optics::parse(path, &text, context),
    };
    let mut lens = lens?;
    compare_with_stated(&mut lens);
    Ok((lens, format))
}

/// Notes a marginal ray that does not reach the f-number that the file states: some surface, diameter or
/// unit may have been read otherwise than it was meant.
fn compare_with_stated(lens: &mut Prescription) {
    let Some(stated) = lens.stated_f_number else { return };
    let found = RealRayFocus::new(lens).f_number();
    if let Some(found) = found.filter(|found| *found > NARROWEST_RATIO * stated) {
        lens.design.notes.push(format!(
            "the file states f/{stated:.2}, and its marginal ray gives f/{found:.2}: check the stop and \
             the clear diameters"
        ));
    }
}

/// Splits "FILE#ENTRY", which names a lens in a file of many. A file whose own name has a # is not
/// split.
fn file_and_entry(path: &Path) -> (PathBuf, Option<String>) {
    let text = path.to_string_lossy();
    match text.rsplit_once('#') {
        Some((file, entry)) if !path.exists() && Path::new(file).is_file() => {
            (PathBuf::from(file), Some(entry.to_owned()))
        }
        _ => (path.to_owned(), None),
    }
}
