//! TIFF files: pictures of 16 bits, and the mosaic of a sensor as DNG.

mod display;
mod dng;

use std::io;

use tiff::TiffError;
use tiff::encoder::{DirectoryEncoder, Rational, TiffKindStandard};

use super::{Note, Notes};

pub(super) use display::write_tiff;
pub(super) use dng::write_dng;

type Directory<'a, W> = DirectoryEncoder<'a, W, TiffKindStandard>;

fn io_error(error: TiffError) -> io::Error {
    match error {
        TiffError::IoError(error) => error,
        other => io::Error::other(other),
    }
}

/// Returns the nearest fraction of a number from 0 to 4e9, of millionths where they fit.
fn rational(x: f64) -> Rational {
    let x = if x.is_finite() { x.clamp(0.0, f64::from(u32::MAX)) } else { 0.0 };
    let mut d = 1_000_000;
    while x * f64::from(d) > f64::from(u32::MAX) {
        d /= 10;
    }
    Rational { n: (x * f64::from(d)).round() as u32, d }
}

/// Returns the notes as text: a line each, in the ASCII that TIFF has.
fn text_of(notes: &Notes) -> String {
    let lines = notes.iter().map(|(name, note)| format!("{name}: {note}\n"));
    lines.collect::<String>().chars().map(|c| if c.is_ascii() { c } else { '?' }).collect()
}

fn number(notes: &Notes, name: &str) -> Option<f64> {
    match notes.iter().find(|(other, _)| *other == name) {
        Some((_, Note::Number(number))) => Some(*number),
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fractions_are_near_their_numbers() {
        for x in [0.0, 1e-6, 1.0 / 125.0, 2.8, 50.008, 4294.0, 4295.0, 1e6, 4e9] {
            let Rational { n, d } = rational(x);
            let off = f64::from(n) / f64::from(d) - x;
            assert!(off.abs() <= 5e-7_f64.max(2e-10 * x), "{x}: {n}/{d}");
        }
        for odd in [f64::NAN, f64::INFINITY, -1.0] {
            assert_eq!(rational(odd).n, 0);
        }
    }
}
