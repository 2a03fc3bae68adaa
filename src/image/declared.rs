//! Whether a file can hold the picture that it declares: a few bytes must not ask for gigabytes.

use std::path::Path;

use super::ImageError;

/// Pixels that a file of any size may hold, and for each of its bytes: deflate, the best of what
/// pictures are packed with, makes 1032 bytes of one.
const MOST_PIXELS: [u64; 2] = [1 << 20, 1100];

/// Whether a picture of this size can be in a file.
///
/// # Errors
/// Where it cannot, or there is no file.
pub(super) fn believe(path: &Path, [width, height]: [usize; 2]) -> Result<(), ImageError> {
    let io = |source| ImageError::Io { verb: "read", path: path.to_owned(), source };
    let length = path.metadata().map_err(io)?.len();
    let pixels = (width as u64).saturating_mul(height as u64);
    match pixels <= MOST_PIXELS[0].saturating_add(MOST_PIXELS[1].saturating_mul(length)) {
        true => Ok(()),
        false => Err(ImageError::Malformed {
            path: path.to_owned(),
            found: format!("it declares {width} x {height} pixels and has {length} bytes"),
        }),
    }
}
