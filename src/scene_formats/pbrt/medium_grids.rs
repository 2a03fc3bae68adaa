//! Media that vary: grids of pbrt's, clouds and NanoVDB files.

use glam::{DAffine3, DVec3, Vec3};

use super::colour::ColourRole;
use super::medium_coefficients::{coefficients, non_negative, radiance};
use super::params::Params;
use super::{SceneError, resolve, suggestion_or};
use crate::nanovdb;
use crate::nanovdb::{NanoGrid, NanoVdbError};
use std::sync::Arc;

use petzval_base::io::{hint, path_excerpt};
use petzval_scene::{
    Blackbodies, CloudPattern, DensityField, Field, FieldEmission, MediumColours, PlacedGrid,
    ScalarGrid, VoxelGrid, Voxels,
};
use petzval_spectrum::luminosity_integral;

/// Returns the corners of a medium's box.
pub(super) fn bounds(params: &Params) -> Result<[DVec3; 2], SceneError> {
    let low = DVec3::from(params.triple("p0")?.unwrap_or([0.0; 3]));
    let high = DVec3::from(params.triple("p1")?.unwrap_or([1.0; 3]));
    Ok([low.min(high), low.max(high)])
}

/// Returns the numbers of voxels along the axes.
fn resolution(params: &Params) -> Result<[u32; 3], SceneError> {
    const MOST: u32 = 1 << 20;
    let mut resolution = [1; 3];
    for (count, name) in resolution.iter_mut().zip(["nx", "ny", "nz"]) {
        *count = params.count(name, MOST)?.unwrap_or(1);
    }
    Ok(resolution)
}

/// Returns a grid of one number a voxel, if it is given.
fn scalar_grid(params: &Params, name: &str) -> Result<Option<ScalarGrid>, SceneError> {
    let Some(numbers) = params.numbers(name, &["float"])? else { return Ok(None) };
    let values = numbers.iter().map(|&v| v as f32).collect();
    Ok(Some(ScalarGrid::Dense(placed(params, name, values)?)))
}

/// Returns a grid of a colour a voxel, if it is given.
fn colour_grid(
    params: &Params,
    name: &str,
    role: ColourRole,
    scale: f32,
) -> Result<Option<PlacedGrid<VoxelGrid<Vec3>>>, SceneError> {
    let Some(numbers) = params.numbers(name, &["rgb"])? else { return Ok(None) };
    let colour = |rgb: &[f64; 3]| {
        let rgb = match role {
            ColourRole::Light => params.space.light(*rgb),
            ColourRole::Albedo | ColourRole::Unbounded => params.space.surface(*rgb),
        };
        scale * Vec3::from(rgb.map(|channel| channel.max(0.0) as f32))
    };
    let values = numbers.as_chunks::<3>().0.iter().map(colour).collect();
    placed(params, name, values).map(Some)
}

/// Returns the grid of a parameter.
fn placed<T: Copy>(
    params: &Params,
    name: &str,
    values: Vec<T>,
) -> Result<PlacedGrid<VoxelGrid<T>>, SceneError>
where
    VoxelGrid<T>: Voxels,
{
    let [nx, ny, nz] = resolution(params)?;
    let found = values.len();
    let grid = VoxelGrid::new([nx, ny, nz], values).ok_or_else(|| {
        let all = u64::from(nx) * u64::from(ny) * u64::from(nz);
        let expected = format!("expected nx ny nz = {nx} {ny} {nz}, that is {all}");
        params.refuse(name, format!("{found} values for \"{name}\""), expected)
    })?;
    Ok(PlacedGrid::filling(grid))
}

/// Returns the field of a grid of densities, and the colours of its coefficients.
pub(super) fn density_field(params: &Params) -> Result<(Field, MediumColours), SceneError> {
    let Some(density) = scalar_grid(params, "density")? else {
        let found = "a grid without \"float density\"";
        return Err(SceneError::at(params.at.clone(), found, "expected a number for every voxel"));
    };
    let [absorption, scattering] = coefficients(params)?;
    let mut colours = MediumColours::dark(absorption, scattering);
    let strength = scalar_grid(params, "Lescale")?;
    let emission = match (scalar_grid(params, "temperature")?, radiance(params)?) {
        (Some(_), Some(_)) => {
            let found = "\"Le\" and \"temperature\" together";
            return Err(params.refuse("Le", found, "give one of them"));
        }
        (Some(temperature), None) => Some(FieldEmission::Thermal {
            temperature,
            offset: temperature_offset(params)?,
            scale: params.float("temperaturescale", 1.0)? as f32,
            // pbrt-v4's grid of one voxel, whose neighbours are 0.
            strength: Some(strength.unwrap_or_else(one_voxel)),
            radiance: Blackbodies::new(1.0),
        }),
        (None, Some(emission)) => {
            let radiance = emission.rgb;
            colours.emission = emission;
            Some(FieldEmission::Scaled { radiance, scale: strength.unwrap_or_else(one_voxel) })
        }
        (None, None) => None,
    };
    let [absorption, scattering] = [&colours.absorption, &colours.scattering].map(|c| c.rgb);
    Ok((Field::Density(DensityField { density, absorption, scattering, emission }), colours))
}

fn temperature_offset(params: &Params) -> Result<f32, SceneError> {
    let cutoff = params.float("temperaturecutoff", 0.0)?;
    Ok(params.float("temperatureoffset", cutoff)? as f32)
}

/// Returns a grid of one voxel of 1: the factor of an emission that falls from the centre of the box
/// to its faces, as pbrt-v4 has it without "Lescale".
fn one_voxel() -> ScalarGrid {
    ScalarGrid::Dense(PlacedGrid::filling(VoxelGrid::one(1.0)))
}

pub(super) fn colour_field(params: &Params) -> Result<Field, SceneError> {
    // pbrt-v4 does not divide these radiances by the integral of the luminosity function.
    let strength = non_negative(params, "Lescale", 1.0)? * luminosity_integral() as f32;
    let field = Field::Colour {
        absorption: colour_grid(params, "sigma_a", ColourRole::Unbounded, 1.0)?,
        scattering: colour_grid(params, "sigma_s", ColourRole::Unbounded, 1.0)?,
        emission: colour_grid(params, "Le", ColourRole::Light, strength)?,
        scale: non_negative(params, "scale", 1.0)?,
        uplift: None,
    };
    match &field {
        Field::Colour { absorption: None, scattering: None, .. } => {
            let found = "a grid without \"rgb sigma_a\" and \"rgb sigma_s\"";
            Err(SceneError::at(params.at.clone(), found, "expected one of them"))
        }
        Field::Colour { absorption: None, emission: Some(_), .. } => {
            Err(params.refuse("Le", "\"Le\" without \"rgb sigma_a\"", "add the absorption"))
        }
        _ => Ok(field),
    }
}

/// Returns the field of a cloud, and the colours of its coefficients.
pub(super) fn cloud(params: &Params) -> Result<(Field, MediumColours), SceneError> {
    let [low, high] = bounds(params)?;
    let [absorption, scattering] = coefficients(params)?;
    let pattern = CloudPattern {
        density: non_negative(params, "density", 1.0)?,
        wispiness: non_negative(params, "wispiness", 1.0)?,
        frequency: non_negative(params, "frequency", 5.0)?,
        low: low.as_vec3(),
        size: (high - low).as_vec3(),
    };
    let field = Field::Cloud { pattern, absorption: absorption.rgb, scattering: scattering.rgb };
    Ok((field, MediumColours::dark(absorption, scattering)))
}

/// Returns the field of the grids of a NanoVDB file, the colours of its coefficients, and the transform of
/// its unit cube to medium space. The cube is the box of the active voxels.
pub(super) fn nanovdb_field(
    params: &Params,
) -> Result<(Field, MediumColours, DAffine3), SceneError> {
    let Some(name) = params.text("filename")? else {
        let found = "a medium without \"string filename\"";
        return Err(SceneError::at(params.at.clone(), found, "expected the name of a .nvdb file"));
    };
    let path = resolve(&params.folder, name);
    let invalid =
        |source: NanoVdbError| SceneError::Volume { at: params.location("filename"), source };
    let grid = |name: &str| nanovdb::read(&path, name, &params.context).map_err(invalid);
    let name = params.text("gridname")?.unwrap_or("density");
    let Some(density) = grid(name)? else {
        let names = nanovdb::names(&path, &params.context).map_err(invalid)?;
        let hint = hint(name, names.iter().map(String::as_str));
        let behind = suggestion_or(hint, &format!("the file has {}", names.join(", ")));
        let found = format!("no grid \"{name}\" in {}{behind}", path_excerpt(&path));
        return Err(params.refuse("gridname", found, ""));
    };
    let [low, high] = density.active;
    let (low, high) = (low.as_dvec3(), high.as_dvec3() + 1.0);
    let index_from_unit = DAffine3::from_translation(low) * DAffine3::from_scale(high - low);
    let medium_from_unit = density.medium_from_index * index_from_unit;
    let [absorption, scattering] = coefficients(params)?;
    let strength = non_negative(params, "Lescale", 1.0)?;
    let temperature = grid(params.text("temperaturename")?.unwrap_or("temperature"))?;
    let emission = match temperature {
        Some(temperature) if strength > 0.0 => Some(FieldEmission::Thermal {
            temperature: placed_in(temperature, &medium_from_unit),
            offset: temperature_offset(params)?,
            scale: params.float("temperaturescale", 1.0)? as f32,
            strength: None,
            radiance: Blackbodies::new(strength),
        }),
        _ => None,
    };
    let density = placed_in(density, &medium_from_unit);
    let field = Field::Density(DensityField {
        density,
        absorption: absorption.rgb,
        scattering: scattering.rgb,
        emission,
    });
    Ok((field, MediumColours::dark(absorption, scattering), medium_from_unit))
}

/// Places a grid in the unit cube of a medium.
fn placed_in(grid: NanoGrid, medium_from_unit: &DAffine3) -> ScalarGrid {
    let index_from_unit = grid.medium_from_index.inverse() * *medium_from_unit;
    let voxel_from_unit = DAffine3::from_translation(-grid.first.as_dvec3()) * index_from_unit;
    let voxel_from_unit = voxel_from_unit.as_affine3a();
    ScalarGrid::Sparse(Arc::new(PlacedGrid { grid: grid.voxels, voxel_from_unit }))
}
