//! The medium of a subsurface material.

use super::SceneError;
use super::colour::ColourRole;
use super::medium_coefficients::{MAX_EXTINCTION, asymmetry, measured, scaled};
use super::params::Params;
use petzval_scene::{DiffuseBoundary, Dispersion, Homogeneous, MediumColours, Subsurface};
use petzval_spectrum::{BandSpectrum, Colour, uplift_reflectance};

/// Returns the medium below a surface, from the parameters of its material, its refractive index at the d
/// line and by wavelength, and a function that reads its colours.
pub(super) fn subsurface(
    params: &Params,
    (eta, dispersion): (f32, Dispersion),
    colour: impl Fn(&str, ColourRole) -> Result<Option<Colour>, SceneError>,
) -> Result<Subsurface, SceneError> {
    let given = |name: &str| colour(name, ColourRole::Unbounded);
    let named = params.text("name")?.filter(|name| !name.is_empty());
    let [absorption, scattering] = match (named, given("sigma_a")?, given("sigma_s")?) {
        (None, Some(absorption), Some(scattering)) => {
            [scaled(params, &absorption)?, scaled(params, &scattering)?]
        }
        (None, Some(_), None) => {
            return Err(params.refuse("sigma_a", "\"sigma_a\" without \"sigma_s\"", "give both"));
        }
        (None, None, Some(_)) => {
            return Err(params.refuse("sigma_s", "\"sigma_s\" without \"sigma_a\"", "give both"));
        }
        (named, ..) => match (named, colour("reflectance", ColourRole::Albedo)?) {
            (None, Some(reflectance)) => {
                let path = scaled(params, &given("mfp")?.unwrap_or([1.0; 3].into()))?;
                coefficients_of(&reflectance, &path, eta, &dispersion)
            }
            (named, _) => {
                let medium = measured(params, "name", named.unwrap_or("Wholemilk"))?;
                [
                    scaled(params, &medium.absorption.into())?,
                    scaled(params, &medium.scattering.into())?,
                ]
            }
        },
    };
    let g = if named.is_some() { 0.0 } else { asymmetry(params)? };
    let colours = MediumColours::dark(absorption, scattering);
    let medium = Homogeneous::of(&colours);
    Ok(Subsurface { medium, colours: colours.if_spectral(), g, eta, dispersion })
}

/// Returns the absorption and the scattering coefficient of a medium that reflects this share of diffuse
/// light, by its mean free path.
fn coefficients_of(
    reflectance: &Colour,
    path: &Colour,
    eta: f32,
    dispersion: &Dispersion,
) -> [Colour; 2] {
    let at = move |boundary: &DiffuseBoundary, reflectance: f32, path: f32| {
        let albedo = boundary.albedo_of_reflectance(reflectance);
        let extinction = (1.0 / path).min(MAX_EXTINCTION);
        [(1.0 - albedo) * extinction, albedo * extinction]
    };
    let boundary = DiffuseBoundary::new(eta);
    let rgb = [0, 1, 2].map(|c| at(&boundary, reflectance.rgb[c], path.rgb[c]));
    [0, 1].map(|which| {
        let (reflectance, path, dispersion) =
            (reflectance.clone(), path.clone(), dispersion.clone());
        Colour::new(rgb.map(|channel| channel[which]), move || {
            let shares = match reflectance.spectrum() {
                Some(spectrum) => spectrum.clone(),
                None => uplift_reflectance(reflectance.rgb),
            };
            let (shares, paths) = (shares.values(), path.unbounded_spectrum());
            BandSpectrum::from_bands(|band| {
                let at = |boundary| at(boundary, shares[band], paths.values()[band])[which];
                match &dispersion {
                    Some(eta) => at(&DiffuseBoundary::new(eta.values()[band])),
                    None => at(&boundary),
                }
            })
        })
    })
}
