//! Calibration as camera chains of Kalibr.

use petzval_optics::{DistortionModel, FittedModel};

use super::{Report, list};

/// Returns a file for each of Kalibr's pinhole models that describes the lens.
pub(super) fn files(report: &Report) -> Vec<(&'static str, String)> {
    let models = [
        (DistortionModel::RadTan, "kalibr_radtan.yaml", "radtan"),
        (DistortionModel::KannalaBrandt, "kalibr_equidistant.yaml", "equidistant"),
    ];
    let file = |(model, name, kalibr)| {
        Some((name, text(report, report.calibration.fitted(model)?, kalibr)))
    };
    models.into_iter().filter_map(file).collect()
}

fn text(report: &Report, fit: &FittedModel, model: &str) -> String {
    let [fx, fy] = fit.matrix.focal;
    let [cx, cy] = fit.matrix.centre;
    let [width, height] = report.calibration.pixels.resolution;
    format!(
        "# {}\n\
         cam0:\n\
         \x20 cam_overlaps: []\n\
         \x20 camera_model: pinhole\n\
         \x20 distortion_coeffs: [{}]\n\
         \x20 distortion_model: {model}\n\
         \x20 intrinsics: [{}]\n\
         \x20 resolution: [{width}, {height}]\n\
         \x20 rostopic: /cam0/image_raw\n",
        report.headline(),
        list(&fit.coefficients),
        list(&[fx, fy, cx, cy]),
    )
}
