//! The medium of a subsurface material.

use super::SceneError;
use super::colour::ColourRole;
use super::medium_coefficients::{MAX_EXTINCTION, asymmetry, measured, scaled};
use super::params::Params;
use petzval_scene::{Homogeneous, Subsurface, albedo_of_reflectance};

/// Returns the medium below a surface, from the parameters of its material and a function that reads
/// its colours.
pub(super) fn subsurface(
    params: &Params,
    eta: f32,
    colour: impl Fn(&str, ColourRole) -> Result<Option<[f32; 3]>, SceneError>,
) -> Result<Subsurface, SceneError> {
    let given = |name: &str| colour(name, ColourRole::Unbounded);
    let named = params.text("name")?.filter(|name| !name.is_empty());
    let [absorption, scattering] = match (named, given("sigma_a")?, given("sigma_s")?) {
        (None, Some(absorption), Some(scattering)) => {
            [scaled(params, absorption)?, scaled(params, scattering)?]
        }
        (None, Some(_), None) => {
            return Err(params.refuse("sigma_a", "\"sigma_a\" without \"sigma_s\"", "give both"));
        }
        (None, None, Some(_)) => {
            return Err(params.refuse("sigma_s", "\"sigma_s\" without \"sigma_a\"", "give both"));
        }
        (named, ..) => match (named, colour("reflectance", ColourRole::Albedo)?) {
            (None, Some(reflectance)) => {
                let path = scaled(params, given("mfp")?.unwrap_or([1.0; 3]))?;
                let mut coefficients = [[0.0; 3]; 2];
                for channel in 0..3 {
                    let albedo = albedo_of_reflectance(reflectance[channel], eta);
                    let extinction = (1.0 / path[channel]).min(MAX_EXTINCTION);
                    coefficients[0][channel] = (1.0 - albedo) * extinction;
                    coefficients[1][channel] = albedo * extinction;
                }
                coefficients
            }
            (named, _) => {
                let medium = measured(params, "name", named.unwrap_or("Wholemilk"))?;
                [scaled(params, medium.absorption)?, scaled(params, medium.scattering)?]
            }
        },
    };
    let g = if named.is_some() { 0.0 } else { asymmetry(params)? };
    let medium = Homogeneous { absorption, scattering, emission: [0.0; 3] };
    Ok(Subsurface { medium, g, eta })
}
