//! Means and noise of photographed patches.

use petzval_image::Picture;

use super::luminance;
use crate::charts::patch_grid::PatchGrid;

/// Share of the sides of a patch that is measured, in its middle.
const MIDDLE: [f64; 2] = [0.25, 0.75];
/// Least side of what is measured of a patch (pixels).
const LEAST: usize = 3;

/// Why a patch cannot be measured.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum PatchError {
    /// The patches have too few pixels.
    #[error(
        "its patches are about {width:.0} x {height:.0} pixels; expected at least {least} x {least}",
        least = 2 * LEAST
    )]
    Small {
        /// Width of a patch (pixels).
        width: f64,
        /// Height of a patch (pixels).
        height: f64,
    },
    /// The picture has a value that is not finite.
    #[error("the patch in row {row}, column {column} has pixels that are not finite")]
    NotFinite {
        /// Row, from 1.
        row: usize,
        /// Column, from 1.
        column: usize,
    },
}

/// A photographed patch.
pub(super) struct PatchMean {
    /// Mean of its pixels, linear sRGB.
    pub mean: [f64; 3],
    /// Standard deviation of the luminance of its pixels.
    pub deviation: f64,
}

/// Measures the middle of a patch. `region` is that of all patches of a picture (pixels).
pub(super) fn patch_mean(
    picture: &Picture,
    grid: PatchGrid,
    region: [[f64; 2]; 2],
    patch: usize,
) -> Result<PatchMean, PatchError> {
    let [low, high] = grid.borders(region, patch, MIDDLE);
    let (from, to) = (low.map(|at| at.ceil() as usize), high.map(|at| at.floor() as usize));
    if (0..2).any(|i| to[i] < from[i] + LEAST) {
        let [low, high] = grid.borders(region, patch, [0.0, 1.0]);
        return Err(PatchError::Small { width: high[0] - low[0], height: high[1] - low[1] });
    }
    let (mut sums, mut luminances) = ([0.0; 3], Vec::new());
    for y in from[1]..to[1] {
        for pixel in &picture.pixels[y * picture.size[0]..][from[0]..to[0]] {
            let pixel = pixel.map(f64::from);
            sums = [0, 1, 2].map(|c| sums[c] + pixel[c]);
            luminances.push(luminance(pixel));
        }
    }
    let count = luminances.len() as f64;
    let mean = luminances.iter().sum::<f64>() / count;
    if !(mean.is_finite() && sums.iter().all(|sum| sum.is_finite())) {
        let [row, column] = grid.place(patch);
        return Err(PatchError::NotFinite { row: row + 1, column: column + 1 });
    }
    let square = luminances.iter().map(|value| (value - mean) * (value - mean)).sum::<f64>();
    let deviation = (square / (count - 1.0)).sqrt();
    Ok(PatchMean { mean: sums.map(|sum| sum / count), deviation })
}
