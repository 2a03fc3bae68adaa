//! Files of a chart: its scene, and the picture of its texture beside it.

use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

use petzval_base::io::{OutputFile, path_excerpt};
use petzval_image::{BitDepth, EncodingOptions, ImageError, PictureWindow};
use petzval_lens::RealRayFocus;
use petzval_optics::{Calibration, CalibrationError, FocusedLens, FocusedLensError};

use super::{Chart, ChartCamera, ChartError, ChartKind, ChartView};

/// Why the files of a chart cannot be written.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ChartFilesError {
    /// The lens cannot be calibrated.
    #[error(transparent)]
    Calibration(#[from] CalibrationError),
    /// The chart cannot be drawn.
    #[error(transparent)]
    Chart(#[from] ChartError),
    /// The lens cannot be focused on the film.
    #[error(transparent)]
    Focus(#[from] FocusedLensError),
    /// A scene cannot name a file.
    #[error(
        "{}: a scene cannot name this file; expected a path in UTF-8 without control characters",
        path_excerpt(.0)
    )]
    Name(PathBuf),
    /// The picture of the texture cannot be written.
    #[error(transparent)]
    Texture(#[from] ImageError),
    /// The scene cannot be written.
    #[error("cannot write {}: {source}", path_excerpt(path))]
    Scene {
        /// The file.
        path: PathBuf,
        /// The error of the system.
        source: io::Error,
    },
}

/// Checks that a scene can name a file.
///
/// # Errors
/// Returns an error if its path is not UTF-8, or has control characters.
pub fn check_name(path: &Path) -> Result<(), ChartFilesError> {
    match path.to_str().is_none_or(|path| path.contains(char::is_control)) {
        false => Ok(()),
        true => Err(ChartFilesError::Name(path.to_owned())),
    }
}

impl ChartKind {
    /// Returns whether a chart of this kind has a picture of its texture beside its scene.
    pub fn has_texture(self) -> bool {
        matches!(self, Self::Leaves | Self::Star)
    }
}

/// A drawn chart, with what its scene says of the camera.
#[derive(Debug)]
pub struct ChartFiles<'a> {
    /// The chart.
    pub chart: Chart,
    calibration: Calibration,
    focused: &'a FocusedLens,
    lens_file: &'a Path,
}

impl<'a> ChartFiles<'a> {
    /// Draws a chart that fills the picture of a lens.
    ///
    /// # Errors
    /// Returns an error if the lens cannot be calibrated, or if no chart of the kind fills its picture.
    pub fn new(
        kind: ChartKind,
        focused: &'a FocusedLens,
        lens_file: &'a Path,
    ) -> Result<Self, ChartFilesError> {
        let calibration = focused.setup().calibrate_quickly()?;
        let chart = Chart::new(kind, &ChartView::new(&calibration)?)?;
        Ok(Self { chart, calibration, focused, lens_file })
    }

    /// Writes the scene, and the picture of the texture if the chart has one. `command` is the one that made it.
    ///
    /// # Errors
    /// Returns an error if a file cannot be written.
    pub fn write(
        &self,
        command: &str,
        scene: &OutputFile,
        texture: Option<&OutputFile>,
    ) -> Result<(), ChartFilesError> {
        let Self { chart, calibration, focused: FocusedLens { lens, .. }, lens_file } = self;
        let camera = ChartCamera {
            lens: lens_file,
            stop_diameter: lens.rows[lens.stop()].diameter,
            f_number: RealRayFocus::new(lens).f_number(),
        };
        let name = texture.and_then(|file| file.path().file_name()).unwrap_or_default();
        let view = ChartView::new(calibration)?;
        let text = chart.scene(&view, &camera, command, &name.to_string_lossy())?;
        if let (Some(file), Some(picture)) = (texture, &chart.texture) {
            let frame = picture.size.map(|n| n as u32);
            let window = PictureWindow { origin: [0, 0], frame };
            let encoding = EncodingOptions {
                grey: true,
                bit_depth: (chart.kind() == ChartKind::Star).then_some(BitDepth::Sixteen),
                ..EncodingOptions::default()
            };
            picture.write(file, window, encoding, &Vec::new())?;
        }
        let written = scene.write(|file| file.write_all(text.as_bytes()));
        written.map_err(|source| ChartFilesError::Scene { path: scene.path().to_owned(), source })
    }
}
