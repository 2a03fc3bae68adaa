//! Printed summary of `petzval lens calibrate`.

use std::fmt::Write as _;
use std::path::Path;

use super::Report;

/// Returns the figures of a calibration and the names of its files.
pub(super) fn text(report: &Report, folder: &Path, written: &[&str]) -> String {
    let calibration = &report.calibration;
    let (pixels, centre) = (calibration.pixels, calibration.centre);
    let [width, height] = pixels.film_size();
    let mut text = format!("{}\n", report.headline());
    let mut line = |label: &str, words: String| {
        let _ = writeln!(text, "{label:<22}{words}");
    };
    let [columns, rows] = pixels.resolution;
    let used = match (width - report.sensor[0]).abs() + (height - report.sensor[1]).abs() {
        off if off < 1e-9 => String::new(),
        _ => format!(" of the sensor's {} x {} mm", report.sensor[0], report.sensor[1]),
    };
    line(
        "picture",
        format!(
            "{columns} x {rows} pixels of {:.3} um: {width:.3} x {height:.3} mm{used}",
            1e3 * pixels.pitch
        ),
    );
    line("field", format!("{:.2} degrees from the axis", calibration.largest_angle.to_degrees()));
    if calibration.lit < 1.0 {
        line("light", format!("reaches {:.1} % of the picture", 100.0 * calibration.lit));
    }
    line(
        "centre of projection",
        format!(
            "{:.4} mm before the film plane, {:.4} mm behind the front vertex",
            centre.point.z,
            calibration.front_depth - centre.point.z
        ),
    );
    let [low, high] = centre.wander;
    line(
        "",
        format!(
            "wanders by {:.4} mm with the field ({low:.4} to {high:.4}); rays pass it within {:.4} \
             mm",
            high - low,
            centre.miss[0]
        ),
    );
    if let Some(difference) = report.chief_difference {
        line(
            "chief ray, centroid",
            format!("differ by up to {difference:.4} pixels in the plane in focus"),
        );
    }
    text.push('\n');
    table(report, &mut text);
    match calibration.suggested() {
        Some(fit) => {
            let _ = writeln!(text, "\nsuggested model: {}", fit.model.name());
        }
        None => {
            text.push_str("\nno model describes this lens: no file of camera models is written\n")
        }
    }
    let _ = writeln!(text, "\n{}: {}", folder.display(), written.join(" "));
    text
}

/// Writes the models, their parameters and their errors.
fn table(report: &Report, text: &mut String) {
    let calibration = &report.calibration;
    let _ = writeln!(
        text,
        "{:<15}{:>11}{:>11}{:>10}{:>10}{:>9}{:>9}{:>11}",
        "model, pixels", "fx", "fy", "cx", "cy", "max", "rms", "max beyond"
    );
    let mut distances: Vec<String> = Vec::new();
    for (model, fit) in &calibration.models {
        let fit = match fit {
            Ok(fit) => fit,
            Err(misfit) => {
                let _ = writeln!(text, "{:<15}does not describe this lens: {misfit}", model.name());
                continue;
            }
        };
        let beyond = fit.elsewhere.iter().map(|(_, found)| found.max).fold(0.0, f64::max);
        distances =
            fit.elsewhere.iter().map(|(distance, _)| format!("{:.3} m", distance * 1e-3)).collect();
        let ([fx, fy], [cx, cy]) = (fit.matrix.focal, fit.matrix.centre);
        let residual = fit.residual;
        let _ = writeln!(
            text,
            "{:<15}{fx:>11.4}{fy:>11.4}{cx:>10.4}{cy:>10.4}{:>9.4}{:>9.4}{beyond:>11.4}",
            model.name(),
            residual.max,
            residual.rms
        );
        let coefficients: Vec<String> = model
            .coefficient_names()
            .iter()
            .zip(&fit.coefficients)
            .filter(|(_, value)| **value != 0.0)
            .map(|(name, value)| format!("{name} {value:.6e}"))
            .collect();
        for part in coefficients.chunks(4) {
            let _ = writeln!(text, "    {}", part.join("  "));
        }
    }
    if !distances.is_empty() {
        let _ = writeln!(
            text,
            "max and rms: errors in the plane in focus; max beyond: at {}",
            distances.join(" and ")
        );
    }
}
