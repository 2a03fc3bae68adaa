//! Everything about a calibration, as JSON.

use petzval_optics::{FittedModel, SpotGrid};
use serde_json::{Map, Value, json};

use super::Report;
use super::lensfun::Photographic;
use super::maps::MapWindow;

/// Returns a number, or null if it is not finite.
fn number(value: f64) -> Value {
    if value.is_finite() { json!(value) } else { Value::Null }
}

/// Describes a calibration: lengths in mm, wavelengths in nm, positions and errors on the picture in
/// pixels; null for infinity.
pub(super) fn describe(
    report: &Report,
    photographic: &Photographic,
    maps: Option<&MapWindow>,
    spots: Option<&SpotGrid>,
) -> String {
    let calibration = &report.calibration;
    let (pixels, centre) = (calibration.pixels, calibration.centre);
    let models: Map<String, Value> = calibration
        .models
        .iter()
        .map(|(model, fit)| {
            let value = match fit {
                Ok(fit) => fitted(fit),
                Err(misfit) => json!({ "describes_the_lens": false, "why": misfit.to_string() }),
            };
            (model.name().to_owned(), value)
        })
        .collect();
    let distortions: Vec<Value> = photographic
        .distortions
        .iter()
        .map(|distortion| {
            let terms: Map<String, Value> =
                distortion.terms.iter().map(|(k, v)| ((*k).to_owned(), json!(v))).collect();
            json!({
                "model": distortion.model,
                "terms": terms,
                "real_focal": distortion.real_focal,
                "max_error": distortion.error,
            })
        })
        .collect();
    let colour = photographic.colour.map(|[red, blue]| {
        let one = |colour: petzval_optics::LateralColour| {
            let [v, c, b] = colour.terms;
            json!({ "v": v, "c": c, "b": b, "max": colour.largest, "max_error": colour.error })
        };
        json!({ "red": one(red), "blue": one(blue) })
    });
    let value = json!({
        "lens": report.setup.lens.name,
        "petzval": env!("CARGO_PKG_VERSION"),
        "conventions": {
            "pixels": "x to the right, y down, the centre of the first pixel at (0, 0); \
                       cameras.txt of COLMAP has it at (0.5, 0.5)",
            "camera": "mm, x to the right and y down in the picture, z towards the scene from the \
                       film plane",
        },
        "sensor": report.sensor,
        "film_size": pixels.film_size(),
        "resolution": pixels.resolution,
        "pixel_pitch": pixels.pitch,
        "focus": number(calibration.focus),
        "film_distance": report.setup.film_distance,
        "f_number": report.f_number,
        "stop_diameter": report.stop_diameter,
        "wavelength": calibration.wavelength,
        "ray": calibration.ray.name(),
        "largest_difference_between_chief_and_centroid": report.chief_difference,
        "projection_centre": {
            "position": centre.point.to_array(),
            "behind_front_vertex": calibration.front_depth - centre.point.z,
            "largest_miss": centre.miss[0],
            "rms_miss": centre.miss[1],
            "wander": centre.wander,
        },
        "largest_field_angle": calibration.largest_angle.to_degrees(),
        "lit_share": calibration.lit,
        "round": calibration.round,
        "suggested_model": calibration.suggested().map(|fit| fit.model.name()),
        "models": models,
        "lensfun": {
            "reference": if calibration.is_fisheye() { "equidistant" } else { "rectilinear" },
            "distortion": distortions,
            "lateral_colour": colour,
            "falloff": photographic.falloff.map(|falloff| {
                json!({ "terms": falloff.terms, "max_error": falloff.error })
            }),
        },
        "st_maps": maps.map(|maps| {
            let [low, end] = maps.window;
            json!({
                "undistorted_camera_matrix": maps.matrix.rows(),
                "undistorted_window": [low, end],
                "holds_all_of_the_photograph": maps.complete,
                "values": "R from left to right, G from bottom to top of the frame, 0 to 1; -1 \
                           without a place",
            })
        }),
        "psf": spots.map(|spots| {
            json!({
                "axes": ["distance", "row", "column", "y", "x", "channel"],
                "distances": spots.distances.iter().copied().map(number).collect::<Vec<_>>(),
                "points": spots.fields,
                "grid": spots.grid,
                "side": spots.side,
                "least_share_held": spots.captured,
                "light": "white (D65), geometric, without diffraction",
            })
        }),
    });
    format!("{value:#}\n")
}

fn fitted(fit: &FittedModel) -> Value {
    let names = fit.model.coefficient_names();
    let coefficients: Map<String, Value> = names
        .iter()
        .zip(&fit.coefficients)
        .map(|(name, value)| ((*name).to_owned(), json!(value)))
        .collect();
    let elsewhere: Vec<Value> = fit
        .elsewhere
        .iter()
        .map(|(distance, residual)| {
            json!({ "distance": distance, "max_error": residual.max, "rms_error": residual.rms })
        })
        .collect();
    json!({
        "describes_the_lens": true,
        "camera_matrix": fit.matrix.rows(),
        "coefficients": coefficients,
        "coefficient_order": names,
        "max_error": fit.residual.max,
        "rms_error": fit.residual.rms,
        "at_other_distances": elsewhere,
    })
}
