//! Coefficients of media: their parameters, presets and limits.

use super::colour::ColourRole;
use super::params::Params;
use super::{SceneError, suggestion_or};
use petzval_base::io::hint;
use petzval_scene::MeasuredMedium;
use petzval_spectrum::Colour;

/// Largest absorption or scattering coefficient.
pub(super) const MAX_EXTINCTION: f32 = 1e9;

/// Returns a number, 0 or more.
pub(super) fn non_negative(params: &Params, name: &str, default: f64) -> Result<f32, SceneError> {
    let value = params.float(name, default)? as f32;
    if value >= 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(params.refuse(name, format!("\"{name}\" is {value}"), "expected 0 or more"))
}

/// Returns the asymmetry of the phase function.
pub(super) fn asymmetry(params: &Params) -> Result<f32, SceneError> {
    let g = params.float("g", 0.0)? as f32;
    match (-1.0..=1.0).contains(&g) {
        true => Ok(g),
        false => {
            let found = format!("an asymmetry \"g\" of {g}");
            Err(params.refuse("g", found, "expected -1 to 1"))
        }
    }
}

/// Returns the measured medium that a parameter names.
pub(super) fn measured(
    params: &Params,
    parameter: &str,
    name: &str,
) -> Result<&'static MeasuredMedium, SceneError> {
    MeasuredMedium::named(name).ok_or_else(|| {
        let hint = hint(name, MeasuredMedium::names());
        let names = MeasuredMedium::names().collect::<Vec<_>>().join(", ");
        let behind = suggestion_or(hint, &format!("expected one of {names}"));
        params.refuse(parameter, format!("no measured medium \"{name}\"{behind}"), "")
    })
}

/// Returns the absorption and the scattering coefficient.
pub(super) fn coefficients(params: &Params) -> Result<[Colour; 2], SceneError> {
    let preset = match params.text("preset")? {
        None | Some("") => None,
        Some(name) => Some(measured(params, "preset", name)?),
    };
    let of = |name: &str, measured: Option<[f32; 3]>| -> Result<Colour, SceneError> {
        let given = match measured {
            Some(measured) => Some(measured.into()),
            None => params.spectral_colour(name, ColourRole::Unbounded)?,
        };
        scaled(params, &given.unwrap_or([1.0; 3].into()))
    };
    Ok([
        of("sigma_a", preset.map(|medium| medium.absorption))?,
        of("sigma_s", preset.map(|medium| medium.scattering))?,
    ])
}

/// Returns coefficients times the parameter `scale`.
pub(super) fn scaled(params: &Params, coefficients: &Colour) -> Result<Colour, SceneError> {
    let scale = non_negative(params, "scale", 1.0)?;
    let scaled = coefficients.scaled([scale; 3]);
    match scaled.rgb.iter().all(|channel| *channel <= MAX_EXTINCTION) {
        true => Ok(scaled),
        false => {
            let found =
                format!("a coefficient of {:e}", scaled.rgb.into_iter().fold(0.0, f32::max));
            Err(params.refuse("scale", found, format!("expected at most {MAX_EXTINCTION:e}")))
        }
    }
}

/// Returns the emitted radiance, if there is any.
pub(super) fn radiance(params: &Params) -> Result<Option<Colour>, SceneError> {
    let colour = params.spectral_colour("Le", ColourRole::Light)?;
    Ok(colour.filter(|colour| colour.rgb.iter().any(|&channel| channel > 0.0)))
}
