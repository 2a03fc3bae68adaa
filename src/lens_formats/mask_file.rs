//! Apertures that are pictures.

use std::path::Path;
use std::sync::Arc;

use petzval_base::io::ReadContext;
use petzval_image::{ImageError, Picture, Transfer};
use petzval_lens::{ApertureMask, MaskConvention};

/// Largest number of rows and columns.
const MAX_SIZE: usize = 4096;

/// Reads a square picture as a mask: the mean of its channels, decoded from sRGB if they have 8 bits,
/// clipped to 0 to 1. A NaN is opaque.
///
/// # Errors
/// Returns an error if the file is no picture, or is not square, too large or black.
pub fn read_mask(path: &Path, context: &ReadContext) -> Result<ApertureMask, ImageError> {
    read(path, 1.0, context)
}

/// Reads a square picture as pbrt-v4's camera does, normalised to the light of the round opening.
///
/// # Errors
/// Returns an error in the same cases as [`read_mask`].
pub fn read_mask_by_pbrt(path: &Path, context: &ReadContext) -> Result<ApertureMask, ImageError> {
    Ok(read(path, f32::MAX, context)?.normalized())
}

fn read(path: &Path, most: f32, context: &ReadContext) -> Result<ApertureMask, ImageError> {
    let Picture { size: [width, height], pixels } =
        Picture::read_with(path, Transfer::Srgb, context)?;
    let refuse = |found: String| ImageError::Malformed { path: path.to_owned(), found };
    if width != height || width == 0 || width > MAX_SIZE {
        return Err(refuse(format!(
            "it has {width} x {height} pixels; an aperture is square, at most {MAX_SIZE} wide"
        )));
    }
    let grey = |rgb: &[f32; 3]| {
        let mean = rgb.iter().sum::<f32>() / 3.0;
        if mean > 0.0 { mean.min(most) } else { 0.0 }
    };
    let transmission: Arc<[f32]> = pixels.iter().map(grey).collect();
    if transmission.iter().all(|&t| t == 0.0) {
        return Err(refuse("it is black; an aperture lets light through".into()));
    }
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let convention = MaskConvention::Physical;
    Ok(ApertureMask { name, size: width, transmission, convention, is_shape: false })
}
