//! Calibration as cameras.txt of COLMAP, whose first pixel has its centre at (0.5, 0.5).

use petzval_optics::{DistortionModel, FittedModel};

use super::{Report, list};

/// Returns a camera for each of COLMAP's models that describes the lens; `None` if none does.
pub(super) fn text(report: &Report) -> Option<String> {
    let models = [
        (DistortionModel::RadTan, "OPENCV"),
        (DistortionModel::Rational, "FULL_OPENCV"),
        (DistortionModel::KannalaBrandt, "OPENCV_FISHEYE"),
    ];
    let found: Vec<(&FittedModel, &str)> = models
        .into_iter()
        .filter_map(|(model, name)| Some((report.calibration.fitted(model)?, name)))
        .collect();
    if found.is_empty() {
        return None;
    }
    let mut text = format!(
        "# {}\n\
         # One camera, described by {} models: keep one of these lines.\n\
         # CAMERA_ID, MODEL, WIDTH, HEIGHT, PARAMS[]\n",
        report.headline(),
        found.len()
    );
    let [width, height] = report.calibration.pixels.resolution;
    for (i, (fit, name)) in found.into_iter().enumerate() {
        let [fx, fy] = fit.matrix.focal;
        let [cx, cy] = fit.matrix.centre.map(|v| v + 0.5);
        let mut numbers = vec![fx, fy, cx, cy];
        numbers.extend(&fit.coefficients);
        let numbers = list(&numbers).replace(',', "");
        text += &format!("{} {name} {width} {height} {numbers}\n", i + 1);
    }
    Some(text)
}
