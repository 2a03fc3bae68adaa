//! Point spreads of a calibration, as a mosaic in EXR and as an array for NumPy.

use std::io::Write as _;
use std::path::Path;

use petzval::io::image::{ChannelImage, Note, Notes};
use petzval::io::replace_file;
use petzval::lens::{Paraxial, SpotGrid};

use super::{Report, npy};
use crate::cli::Failure;

/// Columns and rows of points of the picture.
const GRID: [usize; 2] = [7, 5];
/// Largest width of a spread (pixels).
const MOST: usize = 65;
/// Distances relative to that in focus; infinity is added.
const DISTANCES: [f64; 4] = [0.5, 0.75, 1.0, 1.5];
/// The same if infinity is in focus, in focal lengths.
const FOCAL_LENGTHS: [f64; 4] = [50.0, 100.0, 200.0, 400.0];

/// Writes the spreads and returns them.
pub(super) fn write(report: &Report, folder: &Path) -> Result<SpotGrid, Failure> {
    let calibration = &report.calibration;
    let focal_length = Paraxial::new(report.setup.lens).focal_length.abs();
    let (steps, unit) = match calibration.focus.is_finite() {
        true => (DISTANCES, calibration.focus),
        false => (FOCAL_LENGTHS, focal_length),
    };
    // Points just before the lens are of no use.
    let nearest = calibration.front_depth + 2.0 * report.setup.lens.rows[0].diameter;
    let mut distances: Vec<f64> =
        steps.into_iter().map(|step| step * unit).filter(|d| *d > nearest).collect();
    distances.push(f64::INFINITY);
    let spots = report.setup.spots(calibration, GRID, distances, MOST)?;
    let path = folder.join("psf.npy");
    let shape = [spots.distances.len(), GRID[1], GRID[0], spots.side, spots.side, 3];
    let array = npy::encode(&shape, &spots.shares);
    replace_file(&path, |file| file.write_all(&array))
        .map_err(|error| format!("cannot write {}: {error}", path.display()))?;
    mosaic(&spots).write(&folder.join("psf.exr"), &notes(report))?;
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
