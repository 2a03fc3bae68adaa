//! Calibration as a static sample of OpenTrackIO, whose lens follows OpenLensIO 1.0.
//!
//! OpenLensIO measures on the sensor in mm from its centre, x to the right and y down. With the
//! focal length F, a coefficient of OpenCV becomes k / F^n for the power n of its radius. The radial
//! terms of numerator and denominator alternate. "U-D" maps undistorted to distorted points, as
//! OpenCV does.

use petzval_optics::DistortionModel;
use serde_json::json;

use super::Report;

/// Returns the sample; `None` if the Brown-Conrady model does not describe the lens or its focal
/// lengths along x and y differ, as OpenLensIO has one.
pub(super) fn text(report: &Report) -> Option<String> {
    let calibration = &report.calibration;
    let fit = calibration.fitted(DistortionModel::BrownConrady)?;
    let (pixels, [fx, fy]) = (calibration.pixels, fit.matrix.focal);
    if (fx / fy - 1.0).abs() > 1e-4 {
        return None;
    }
    let focal = fx * pixels.pitch;
    let [k1, k2, k3] = ["k1", "k2", "k3"].map(|name| fit.coefficient(name));
    let [p1, p2] = ["p1", "p2"].map(|name| fit.coefficient(name) / focal);
    let f2 = focal * focal;
    let middle = pixels.centre();
    let offset = [0, 1].map(|i| (fit.matrix.centre[i] - middle[i]) * pixels.pitch);
    let [width, height] = pixels.film_size();
    let mut lens = json!({
        "distortion": [{
            "model": "Brown-Conrady U-D",
            "radial": [k1 / f2, 0.0, k2 / (f2 * f2), 0.0, k3 / (f2 * f2 * f2), 0.0],
            "tangential": [p1, p2],
        }],
        "entrancePupilOffset": calibration.centre.point.z * 1e-3,
        "pinholeFocalLength": focal,
        "projectionOffset": { "x": offset[0], "y": offset[1] },
    });
    if calibration.focus.is_finite() {
        lens["focusDistance"] = json!(calibration.focus * 1e-3);
    }
    if let Some(f_number) = report.f_number {
        lens["fStop"] = json!(f_number);
    }
    let sample = json!({
        "protocol": { "name": "OpenTrackIO", "version": [1, 0, 1] },
        "static": {
            "camera": {
                "activeSensorPhysicalDimensions": { "height": height, "width": width },
                "activeSensorResolution": {
                    "height": pixels.resolution[1],
                    "width": pixels.resolution[0],
                },
            },
            "lens": { "model": report.setup.lens.name },
        },
        "lens": lens,
    });
    Some(format!("{sample:#}\n"))
}
