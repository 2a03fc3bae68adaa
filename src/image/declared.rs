//! Whether a file can hold the picture that it declares, and the memory too: a few bytes must not
//! ask for gigabytes.

use std::path::Path;

use super::ImageError;
use crate::memory::budget;

/// Pixels that a file of any size may hold, and for each of its bytes: deflate, the best of what
/// pictures are packed with, makes 1032 bytes of one.
const MOST_PIXELS: [u64; 2] = [1 << 20, 1100];

/// Bytes of a pixel, four floats; where it has more, it counts as several.
const PIXEL: u64 = 16;

/// Whether a picture of this size can be in a file, and there is memory for so many bytes of each
/// pixel.
///
/// # Errors
/// Where it cannot, or there is no file or no memory.
pub(super) fn believe(path: &Path, size: [usize; 2], bytes: u64) -> Result<(), ImageError> {
    contained(path, "", size, 1)?;
    budget::claim(area(size).saturating_mul(bytes)).map_err(|found| malformed(path, found))
}

/// Whether blocks of this size can be in a file, with so many bytes of each pixel. OpenEXR's reader
/// makes room for all that a block may be before it knows what there is of it.
///
/// # Errors
/// Where they cannot, or there is no file or no memory.
pub(super) fn believe_block(path: &Path, size: [usize; 2], bytes: u64) -> Result<(), ImageError> {
    contained(path, "blocks of ", size, bytes.div_ceil(PIXEL))?;
    budget::fits(area(size).saturating_mul(bytes)).map_err(|found| malformed(path, found))
}

fn contained(
    path: &Path,
    what: &str,
    size @ [width, height]: [usize; 2],
    each: u64,
) -> Result<(), ImageError> {
    let io = |source| ImageError::Io { verb: "read", path: path.to_owned(), source };
    let length = path.metadata().map_err(io)?.len();
    let most = MOST_PIXELS[0].saturating_add(MOST_PIXELS[1].saturating_mul(length));
    match area(size).saturating_mul(each) <= most {
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

fn malformed(path: &Path, found: String) -> ImageError {
    ImageError::Malformed { path: path.to_owned(), found }
}
