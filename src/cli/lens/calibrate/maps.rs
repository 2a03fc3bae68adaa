//! Maps of a calibration: coordinates (ST maps) and relative illumination, as EXR.
//!
//! An ST map gives for each pixel of its picture the place in the other picture from which to take
//! the colour: R from 0 at the left edge of the frame to 1 at the right, G from 0 at the lower edge
//! to 1 at the upper. Beyond the frame there is overscan. Pixels without a place have -1.

use glam::DVec3;
use petzval_image::{ChannelImage, Note, Notes};
use petzval_optics::CameraMatrix;
use rayon::prelude::*;

use super::{CalibrationFiles, Report};
use crate::cli::Failure;

/// Largest overscan beyond each edge, as a share of the frame.
const OVERSCAN: f64 = 0.5;
/// Coordinates of a pixel without a place.
const NOWHERE: [f32; 2] = [-1.0; 2];

/// The undistorted picture.
pub(super) struct MapWindow {
    /// The camera matrix of the pinhole.
    pub matrix: CameraMatrix,
    /// First pixel and end (exclusive).
    pub window: [[i32; 2]; 2],
    /// Whether it holds all of the photograph.
    pub complete: bool,
}

/// Writes the maps. Returns the window of the undistorted picture, unless no model describes the
/// lens.
pub(super) fn write(
    report: &Report,
    files: &CalibrationFiles,
) -> Result<Option<MapWindow>, Failure> {
    let calibration = &report.calibration;
    let frame = calibration.pixels.resolution;
    let size = frame.map(|n| n as usize);
    let notes: Notes = vec![
        ("lensModel", Note::Text(report.setup.lens.name.clone())),
        ("calibration", Note::Text(report.headline())),
    ];
    let light = rows([0, 0], size, |pixel| calibration.relative_illumination(pixel) as f32);
    let illumination = ChannelImage { origin: [0, 0], size, frame, channels: vec![("Y", light)] };
    illumination.write(files.named("illumination.exr")?, &notes)?;
    let Some(matrix) = calibration.pinhole_matrix() else { return Ok(None) };

    let place = |found: Option<[f64; 2]>| match found {
        Some([x, y]) => {
            let [width, height] = frame.map(f64::from);
            [((x + 0.5) / width) as f32, (1.0 - (y + 0.5) / height) as f32]
        }
        None => NOWHERE,
    };
    let write = |name: &str, origin: [i32; 2], size: [usize; 2], places: Vec<[f32; 2]>| {
        let channel = |i: usize| places.iter().map(|place| place[i]).collect();
        let channels = vec![("R", channel(0)), ("G", channel(1))];
        let image = ChannelImage { origin, size, frame, channels };
        image.write(files.named(name)?, &notes).map_err(Failure::from)
    };
    let redistort = rows([0, 0], size, |pixel| place(calibration.undistorted(&matrix, pixel)));
    write("st_redistort.exr", [0, 0], size, redistort)?;
    let (window, complete) = calibration.undistorted_window(&matrix, OVERSCAN);
    let [low, end] = window;
    let fit = calibration.suggested();
    let size = [0, 1].map(|i| (end[i] - low[i]).max(1) as usize);
    let undistort = rows(low, size, |pixel| {
        let [x, y] = [0, 1].map(|i| (pixel[i] - matrix.centre[i]) / matrix.focal[i]);
        let estimate = fit.and_then(|fit| fit.project(DVec3::new(x, y, 1.0)));
        place(estimate.and_then(|estimate| calibration.distorted(&matrix, pixel, estimate)))
    });
    write("st_undistort.exr", low, size, undistort)?;
    Ok(Some(MapWindow { matrix, window, complete }))
}

/// Returns a value for each pixel of a window, row after row.
fn rows<T: Send>(
    low: [i32; 2],
    [width, height]: [usize; 2],
    value: impl Fn([f64; 2]) -> T + Sync,
) -> Vec<T> {
    (0..width * height)
        .into_par_iter()
        .map(|i| value([0, 1].map(|k| f64::from(low[k]) + [i % width, i / width][k] as f64)))
        .collect()
}
