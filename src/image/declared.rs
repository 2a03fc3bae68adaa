//! Whether a file can hold the picture that it declares, and the memory too: a few bytes must not
//! ask for gigabytes.

use std::path::Path;

use super::ImageError;
use crate::memory::budget;

/// Pixels that a file of any size may hold, and for each of its bytes: deflate, the best of what
/// pictures are packed with, makes 1032 bytes of one.
const MOST_PIXELS: [u64; 2] = [1 << 20, 1100];

/// Whether a picture of this size can be in a file, and there is memory for so many bytes of each
/// pixel.
///
/// # Errors
/// Where it cannot, or there is no file or no memory.
pub(super) fn believe(
    path: &Path,
    [width, height]: [usize; 2],
    bytes: u64,
) -> Result<(), ImageError> {
    let io = |source| ImageError::Io { verb: "read", path: path.to_owned(), source };
    let length = path.metadata().map_err(io)?.len();
    let pixels = (width as u64).saturating_mul(height as u64);
    let malformed = |found| ImageError::Malformed { path: path.to_owned(), found };
    match pixels <= MOST_PIXELS[0].saturating_add(MOST_PIXELS[1].saturating_mul(length)) {
        true => budget::claim(pixels.saturating_mul(bytes)).map_err(malformed),
        false => {
            let found = format!("it declares {width} x {height} pixels and has {length} bytes");
            Err(malformed(found))
        }
    }
}
