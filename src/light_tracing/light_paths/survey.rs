//! Survey of light paths: whether they are worth their time in a picture, and why.

use super::{CameraPose, LightPathInput};
use crate::lens::RealLens;
use crate::shutter::Timing;

/// Result of a survey.
#[derive(Clone, Debug)]
pub struct LightPathSurvey<T> {
    /// The light paths, if they are worth their time.
    pub light_paths: Option<T>,
    /// The reason, in a sentence.
    pub reason: String,
}

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

impl<T> LightPathSurvey<T> {
    /// Returns the survey of light paths that the user does not want.
    pub fn unwanted() -> Self {
        Self { light_paths: None, reason: "not wanted".to_owned() }
    }

    /// Returns the survey with this result, which is a reason if there are no light paths. `describe`
    /// returns the reason for those that there are.
    pub(crate) fn new(
        result: Result<T, &'static str>,
        describe: impl FnOnce(&T) -> String,
    ) -> Self {
        match result {
            Ok(found) => Self { reason: describe(&found), light_paths: Some(found) },
            Err(reason) => Self { light_paths: None, reason: reason.to_owned() },
        }
    }
}

/// Returns why light paths cannot find the light of this picture.
pub(crate) fn obstacle(input: &LightPathInput<'_>, lens: &RealLens) -> Option<&'static str> {
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
