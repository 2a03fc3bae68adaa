//! Survey of light paths: the picture that strategies survey, and which of its light they take.

use std::sync::OnceLock;

use super::{CameraPose, CameraView, FrontEntry, LightPathInput, LightPaths};
use crate::timing::Timing;
use petzval_base::lanes::f32x8;
use petzval_lens::{LensModel, RealLens};

/// Selection of light paths.
#[derive(Clone, Copy, Debug)]
pub enum LightPathSelection {
    /// All that find light of the picture.
    All,
    /// Light paths that find light in which pictures of camera paths are noisy.
    Noisy {
        /// The mean luminance of the picture.
        mean: f64,
    },
}

impl LightPathSelection {
    /// Returns whether light paths are selected for light that gives a camera sample this variance: in
    /// a selection of noisy light, if it is not below the square of the picture's mean.
    pub(crate) fn includes(self, variance: f64) -> bool {
        match self {
            Self::All => true,
            Self::Noisy { mean } => variance >= mean * mean,
        }
    }
}

/// A picture whose light paths are surveyed.
pub(crate) struct SurveyedPicture<'a> {
    pub input: &'a LightPathInput<'a>,
    pub lens: &'a RealLens,
    pub selection: LightPathSelection,
    view: OnceLock<Option<CameraView>>,
}

impl<'a> SurveyedPicture<'a> {
    /// Returns the picture, or why light paths cannot find its light.
    pub fn new(
        input: &'a LightPathInput<'a>,
        selection: LightPathSelection,
    ) -> Result<Self, &'static str> {
        let LensModel::Real(lens) = &input.camera.model else {
            return Err("the camera has no lens of glass");
        };
        let view = OnceLock::new();
        obstacle(input, lens).map_or(Ok(Self { input, lens, selection, view }), Err)
    }

    /// Returns the view of the camera, or why it has none.
    pub fn view(&self) -> Result<&CameraView, &'static str> {
        let view = self.view.get_or_init(|| CameraView::new(self.input));
        view.as_ref().ok_or("no ray leaves the lens")
    }

    /// Traces a wave of paths from the lens to the film, in the first of its bands. Returns the indices
    /// of those that arrive on it, after testing which of them are unoccluded.
    pub fn arrivals(&self, front: &FrontEntry, wave: u32, paths: &mut LightPaths) -> Vec<usize> {
        let band = self.input.band_of_wave(wave);
        front.trace::<f32x8>(self.lens, band, paths);
        let half = self.input.camera.film.map(|size| size / 2.0);
        let on_film = |i: &usize| {
            paths.film_hit(*i).is_some_and(|hit| (0..2).all(|k| hit.point[k].abs() < half[k]))
        };
        let arrivals: Vec<usize> = (0..paths.len()).filter(on_film).collect();
        paths.connect::<f32x8>(self.input, arrivals.iter().map(|&i| i as u32));
        arrivals
    }
}

/// Returns why light paths cannot find the light of this picture.
fn obstacle(input: &LightPathInput<'_>, lens: &RealLens) -> Option<&'static str> {
    let instants = input.timing.is_some_and(Timing::rows_are_instants);
    match () {
        () if instants => Some("a rolling shutter reads rows without motion blur"),
        () if lens.prescription.has_mirrors() => Some("the lens has mirrors"),
        () if input.response.max_component.is_some() => Some("bright samples are clamped"),
        () if input.camera.depth != [0.0, f64::INFINITY] => Some("the camera clips distances"),
        () if is_stretched(input) => Some("the camera is stretched"),
        () => None,
    }
}

/// Returns whether the axes of the camera have different lengths, at the ends of the exposure or in its
/// middle.
fn is_stretched(input: &LightPathInput<'_>) -> bool {
    let [first, last] = input.timing.map_or([0.0; 2], Timing::range);
    [first, 0.5 * (first + last), last].into_iter().any(|time| {
        let pose = CameraPose::at(input.camera, input.timing, time as f32);
        let matrix = pose.world_from_camera.matrix3;
        let [x, y, z] = [matrix.x_axis, matrix.y_axis, matrix.z_axis].map(|a| a.length_squared());
        [y, z].into_iter().any(|length| (length / x - 1.0).abs() >= 1e-6)
    })
}
