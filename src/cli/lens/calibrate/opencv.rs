//! Calibration in the YAML of OpenCV's FileStorage.

use petzval_optics::{DistortionModel, FittedModel};

use super::{Report, list};

/// Returns a file for each model of OpenCV that describes the lens.
pub(super) fn files(report: &Report) -> Vec<(&'static str, String)> {
    let models = [
        (DistortionModel::BrownConrady, "opencv_brown_conrady.yaml"),
        (DistortionModel::Rational, "opencv_rational.yaml"),
        (DistortionModel::ThinPrism, "opencv_thin_prism.yaml"),
        (DistortionModel::KannalaBrandt, "opencv_fisheye.yaml"),
    ];
    let file = |(model, name)| Some((name, text(report, report.calibration.fitted(model)?)));
    models.into_iter().filter_map(file).collect()
}

fn text(report: &Report, fit: &FittedModel) -> String {
    let [width, height] = report.calibration.pixels.resolution;
    let matrix = |rows: usize, columns: usize, data: &[f64]| {
        format!(
            "!!opencv-matrix\n   rows: {rows}\n   cols: {columns}\n   dt: d\n   data: [ {} ]",
            list(data)
        )
    };
    let model = match fit.model {
        DistortionModel::KannalaBrandt => "fisheye",
        DistortionModel::BrownConrady => "plumb_bob",
        DistortionModel::ThinPrism => "thin_prism",
        _ => "rational_polynomial",
    };
    let camera = fit.matrix.rows().concat();
    let centre = report.calibration.centre.point;
    format!(
        "%YAML:1.0\n---\n\
         # {}\n\
         # {}; the centre of the first pixel is (0, 0)\n\
         image_width: {width}\n\
         image_height: {height}\n\
         camera_matrix: {}\n\
         distortion_model: {model}\n\
         distortion_coefficients: {}\n\
         rms_error: {:?}\n\
         max_error: {:?}\n\
         # mm, x to the right and y down in the picture, z towards the scene from the film plane\n\
         projection_centre: {}\n",
        report.headline(),
        fit.model.coefficient_names().join(" "),
        matrix(3, 3, &camera),
        matrix(1, fit.coefficients.len(), &fit.coefficients),
        fit.residual.rms,
        fit.residual.max,
        matrix(3, 1, &centre.to_array()),
    )
}
