//! Checks of declared picture sizes against the file and the memory budget, before any allocation.

use std::io;
use std::path::Path;

use super::ImageError;
use petzval_base::io::{HeldMemory, ReadContext};

/// Most pixels of a file of any size.
const MAX_PIXELS: u64 = 1 << 20;
/// Further pixels per byte of the file: deflate, the densest packing of pictures, unpacks a byte to
/// at most 1032.
const MAX_PIXELS_PER_BYTE: u64 = 1100;

/// Bytes of a pixel of four floats; a larger pixel counts as several.
const PIXEL: u64 = 16;

/// Holds the memory that the reading of a picture of this size takes, with this many bytes per pixel.
///
/// # Errors
/// Returns an error if the file is too small for the picture, or the budget is.
pub(super) fn hold_picture(
    context: &ReadContext,
    path: &Path,
    size: [usize; 2],
    bytes: u64,
) -> Result<HeldMemory, ImageError> {
    check_against_file(path, "", size, 1)?;
    context.hold(area(size).saturating_mul(bytes)).map_err(|found| too_large(path, found))
}

/// Returns the memory of a block of this size (bytes), with this many bytes per pixel, if it fits into
/// the file. OpenEXR's reader allocates a whole block before it knows its content.
///
/// # Errors
/// Returns an error if the file is too small for the block.
pub(super) fn block_bytes(path: &Path, size: [usize; 2], bytes: u64) -> Result<u64, ImageError> {
    check_against_file(path, "blocks of ", size, bytes.div_ceil(PIXEL))?;
    Ok(area(size).saturating_mul(bytes))
}

fn check_against_file(
    path: &Path,
    what: &str,
    size @ [width, height]: [usize; 2],
    pixels_each: u64,
) -> Result<(), ImageError> {
    let io = |source| ImageError::Io { verb: "read", path: path.to_owned(), source };
    let length = path.metadata().map_err(io)?.len();
    let most = MAX_PIXELS.saturating_add(MAX_PIXELS_PER_BYTE.saturating_mul(length));
    match area(size).saturating_mul(pixels_each) <= most {
        true => Ok(()),
        false => {
            let found =
                format!("it declares {what}{width} x {height} pixels and has {length} bytes");
            Err(malformed(path, found))
        }
    }
}

fn area([width, height]: [usize; 2]) -> u64 {
    (width as u64).saturating_mul(height as u64)
}

/// Returns the error of a picture that is larger than the budget.
pub(super) fn too_large(path: &Path, found: String) -> ImageError {
    let source = io::Error::new(io::ErrorKind::OutOfMemory, found);
    ImageError::Io { verb: "read", path: path.to_owned(), source }
}

fn malformed(path: &Path, found: String) -> ImageError {
    ImageError::Malformed { path: path.to_owned(), found }
}
