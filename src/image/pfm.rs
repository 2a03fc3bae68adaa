//! Portable float maps (Debevec 2001): a short header, then 32-bit floats from the lowest row up.

use std::io::{self, Write};
use std::path::Path;

use super::declared::too_large;
use super::{ImageError, ImageSamples, Raster};
use petzval_base::io::{HeldMemory, ReadContext, ReadError};

/// Reads a map. Returns also the memory that is held for it, and for its conversion to a picture.
pub(super) fn read(path: &Path, context: &ReadContext) -> Result<(Raster, HeldMemory), ImageError> {
    let bytes = context.bytes(path).map_err(|ReadError { path, source }| ImageError::Io {
        verb: "read",
        path,
        source,
    })?;
    // The file, its floats, and three for each in a picture.
    let held = context.hold(5 * bytes.len() as u64).map_err(|found| too_large(path, found))?;
    let raster = parse(&bytes).map_err(|found| ImageError::Malformed {
        path: path.to_owned(),
        found: found.to_owned(),
    })?;
    Ok((raster, held))
}

fn parse(bytes: &[u8]) -> Result<Raster, &'static str> {
    let mut rest = bytes;
    // A word of the header, and the single blank after it.
    let mut word = || {
        let start = rest.iter().position(|b| !b.is_ascii_whitespace())?;
        let end = start + rest[start..].iter().position(u8::is_ascii_whitespace)?;
        let word = std::str::from_utf8(&rest[start..end]).ok()?;
        rest = &rest[end + 1..];
        Some(word)
    };
    let channels = match word() {
        Some("PF") => 3,
        Some("Pf") => 1,
        _ => return Err("it begins neither with PF nor with Pf"),
    };
    let mut number = || word().and_then(|word| word.parse::<f32>().ok());
    let (Some(width), Some(height), Some(scale)) = (number(), number(), number()) else {
        return Err("its header is not width, height and scale");
    };
    let size = [width, height].map(|n| n as usize);
    let numbers = size[0].checked_mul(size[1]).and_then(|n| n.checked_mul(channels));
    if scale == 0.0 || !scale.is_finite() {
        return Err("its scale is 0 or not finite");
    }
    let (floats, _) = rest.as_chunks::<4>();
    if numbers != Some(floats.len()) || [width, height].iter().any(|n| n.fract() != 0.0) {
        return Err("its length does not match the size in its header");
    }
    // A negative scale means little-endian.
    let float = |b: &[u8; 4]| {
        let value = if scale < 0.0 { f32::from_le_bytes(*b) } else { f32::from_be_bytes(*b) };
        value * scale.abs()
    };
    let row = (size[0] * channels).max(1);
    let samples = floats.chunks(row).rev().flatten().map(float).collect();
    Ok(Raster { size, channels, samples: ImageSamples::Floats(samples) })
}

/// Writes a portable float map of three channels, little-endian. `pixel` gives the values of a pixel,
/// row after row from the top.
///
/// # Errors
/// Returns an error if it cannot be written.
pub fn write_pfm(
    [width, height]: [usize; 2],
    pixel: impl Fn(usize) -> [f32; 3],
    mut to: impl Write,
) -> io::Result<()> {
    write!(to, "PF\n{width} {height}\n-1.0\n")?;
    for y in (0..height).rev() {
        for x in 0..width {
            to.write_all(bytemuck::cast_slice(&pixel(y * width + x).map(f32::to_le_bytes)))?;
        }
    }
    to.flush()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_written_file_is_read_back() {
        let pixel = |i: usize| [i as f32, -1.5, 1e-30 * i as f32];
        let mut bytes = Vec::new();
        write_pfm([3, 2], pixel, &mut bytes).unwrap();
        let raster = parse(&bytes).unwrap();
        let expected = (0..6).flat_map(pixel).collect();
        assert_eq!((raster.size, raster.channels), ([3, 2], 3));
        assert_eq!(raster.samples, ImageSamples::Floats(expected));
    }

    #[test]
    fn rows_are_flipped_and_bytes_ordered() {
        let values = [1.0f32, 2.0, 3.0, 4.0, 5.0, 6.0];
        let little = [b"Pf\n3 2\n-1.0\n".to_vec(), values.map(f32::to_le_bytes).concat()].concat();
        let big = [b"Pf 3 2 0.5\n".to_vec(), values.map(f32::to_be_bytes).concat()].concat();
        let raster = parse(&little).unwrap();
        assert_eq!((raster.size, raster.channels), ([3, 2], 1));
        assert_eq!(raster.samples, ImageSamples::Floats(vec![4.0, 5.0, 6.0, 1.0, 2.0, 3.0]));
        assert_eq!(
            parse(&big).unwrap().samples,
            ImageSamples::Floats(vec![2.0, 2.5, 3.0, 0.5, 1.0, 1.5])
        );
    }

    #[test]
    fn a_truncated_file_or_a_wrong_size_is_refused() {
        let good = [b"PF\n1 1\n-1\n".to_vec(), vec![0; 12]].concat();
        assert!(parse(&good).is_ok());
        for end in 0..good.len() {
            assert!(parse(&good[..end]).is_err(), "{end}");
        }
        for header in ["PF 1e9 1e9 -1 ", "PF -1 1 -1 ", "PF nan 1 1 ", "PF 1 1 0 ", "PF 1.5 1 1 "] {
            assert!(parse(&[header.as_bytes(), &[0; 12]].concat()).is_err(), "{header}");
        }
    }
}
