//! Point spreads of a calibration, as a mosaic in EXR and as an array for NumPy.

use petzval_base::io::npy;
use petzval_image::{ChannelImage, Note, Notes};
use petzval_optics::SpotGrid;

use super::{CalibrationFiles, Report};
use crate::cli::Failure;

/// Writes the spreads and returns them.
pub(super) fn write(report: &Report, files: &CalibrationFiles) -> Result<SpotGrid, Failure> {
    let spots = report.setup.usual_spots(&report.calibration)?;
    files.write("psf.npy", &npy::encode(&spots.shape(), &spots.shares))?;
    mosaic(&spots).write(files.named("psf.exr")?, &notes(report))?;
    Ok(spots)
}

fn notes(report: &Report) -> Notes {
    vec![
        ("lensModel", Note::Text(report.setup.lens.name.clone())),
        ("calibration", Note::Text(report.headline())),
    ]
}

/// Returns the spreads side by side: the points of the picture as they lie in it, and one such
/// block below another for each distance.
fn mosaic(spots: &SpotGrid) -> ChannelImage {
    let ([columns, rows], side) = (spots.grid, spots.side);
    let size = [columns * side, spots.distances.len() * rows * side];
    let mut channels: [Vec<f32>; 3] = std::array::from_fn(|_| vec![0.0; size[0] * size[1]]);
    for (i, share) in spots.shares.iter().enumerate() {
        let (channel, x, y) = (i % 3, i / 3 % side, i / (3 * side) % side);
        let spread = i / (3 * side * side);
        let (column, row) = (spread % columns, spread / columns);
        channels[channel][(row * side + y) * size[0] + column * side + x] = *share;
    }
    let [red, green, blue] = channels;
    ChannelImage {
        origin: [0, 0],
        size,
        frame: size.map(|n| n as u32),
        channels: vec![("R", red), ("G", green), ("B", blue)],
    }
}
