//! Camera model of a rendered picture, for its metadata.

use petzval_image::{Note, Notes};
use petzval_optics::CalibrationSetup;
use petzval_render::job::Job;

/// Returns the camera model that `petzval lens calibrate` suggests for the lens of a job, in the
/// pixels of the whole picture; nothing without a real lens, or if no model describes it.
pub(super) fn notes(job: &Job) -> Notes {
    let Some(setup) = CalibrationSetup::of_camera(&job.camera, job.frame.resolution) else {
        return Notes::new();
    };
    let Ok(calibration) = setup.calibrate_quickly() else { return Notes::new() };
    let Some(fit) = calibration.suggested() else { return Notes::new() };
    let numbers = |values: &[f64]| {
        let texts: Vec<String> = values.iter().map(|value| format!("{:?}", value + 0.0)).collect();
        Note::Text(texts.join(" "))
    };
    vec![
        ("cameraModel", Note::Text(fit.model.name().to_owned())),
        ("cameraMatrix", numbers(&fit.matrix.rows().concat())),
        ("distortionCoefficients", numbers(&fit.coefficients)),
        ("distortionCoefficientNames", Note::Text(fit.model.coefficient_names().join(" "))),
        ("cameraModelError", Note::Number(fit.residual.max)),
        ("projectionCentre", numbers(&calibration.centre.point.to_array())),
    ]
}
