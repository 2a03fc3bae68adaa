//! The MakeNamedMedium and MediumInterface directives.

use std::collections::HashMap;

use glam::{DAffine3, DVec3, Vec3};

use super::attributes::Target;
use super::colour::ColourRole;
use super::directive_kinds::{Directive, SILENT, Selected, known};
use super::lexer::TokenKind;
use super::memory::granted;
use super::params::Params;
use super::reader::SceneReader;
use super::{SceneError, resolve, suggestion_or};
use crate::io::{Location, hint, path_excerpt};
use crate::scene::nanovdb::{self, NanoGrid, NanoVdbError};
use crate::scene::{
    Blackbodies, CloudPattern, DensityField, Field, FieldEmission, Homogeneous, MeasuredMedium,
    Medium, MediumInterface, MediumModel, PlacedGrid, ScalarGrid, Subsurface, VACUUM,
    VaryingMedium, VoxelGrid, albedo_of_reflectance,
};
use crate::spectrum::luminosity_integral;

/// The kinds of media.
#[derive(Clone, Copy)]
enum MediumKind {
    Homogeneous,
    UniformGrid,
    RgbGrid,
    Cloud,
    NanoVdb,
}

const COEFFICIENTS: [&str; 4] = ["sigma_a", "sigma_s", "scale", "g"];

static MEDIUM: Directive<MediumKind> = Directive {
    name: "MakeNamedMedium",
    target: Some(Target::Medium),
    shared: &COEFFICIENTS,
    kinds: &[
        known("homogeneous", MediumKind::Homogeneous, &["preset", "Le", "Lescale"], &[]),
        known("uniformgrid", MediumKind::UniformGrid, GRID_READS, GRID_IGNORES),
        // The name in pbrt-v3.
        known("heterogeneous", MediumKind::UniformGrid, GRID_READS, GRID_IGNORES),
        known(
            "rgbgrid",
            MediumKind::RgbGrid,
            &["nx", "ny", "nz", "p0", "p1", "Le", "Lescale"],
            &[],
        ),
        known("cloud", MediumKind::Cloud, &["density", "wispiness", "frequency", "p0", "p1"], &[]),
        known(
            "nanovdb",
            MediumKind::NanoVdb,
            &[
                "filename",
                "gridname",
                "temperaturename",
                "Lescale",
                "temperatureoffset",
                "temperaturecutoff",
                "temperaturescale",
            ],
            &[],
        ),
    ],
};

const GRID_READS: &[&str] = &[
    "density",
    "temperature",
    "temperatureoffset",
    "temperaturecutoff",
    "temperaturescale",
    "nx",
    "ny",
    "nz",
    "p0",
    "p1",
    "Le",
    "Lescale",
    "preset",
];
const GRID_IGNORES: &[(&str, &str)] = &[("gridname", SILENT)];

/// Media by name, with the location of the first use of those that are not defined yet.
#[derive(Default)]
pub(super) struct NamedMedia(HashMap<String, (u32, Option<Location>)>);

impl SceneReader {
    pub(super) fn make_named_medium(&mut self) -> Result<(), SceneError> {
        let name = self.string()?;
        let mut params = self.params()?;
        let Some(kind) = params.text("type")?.map(str::to_owned) else {
            return self.refuse(
                "a medium without \"string type\"",
                "expected a kind, such as homogeneous",
            );
        };
        params.all.retain(|param| param.name != "type");
        let Selected { kind, params, .. } = self.check_kind(&MEDIUM, &kind, params)?;
        let Some(kind) = kind else { return Ok(()) };
        let medium = self.medium(kind, &params)?;
        let index = self.medium_index(&name);
        self.media.0.insert(name, (index, None));
        self.builder.replace_medium(index, medium);
        Ok(())
    }

    pub(super) fn medium_interface(&mut self) -> Result<(), SceneError> {
        let inside = self.string()?;
        let outside = match self.peek()? {
            Some(TokenKind::Text(_)) => self.string()?,
            _ => inside.clone(),
        };
        let [inside, outside] = [inside, outside].map(|name| match name.as_str() {
            "" => VACUUM,
            name => self.medium_index(name),
        });
        self.state.media = MediumInterface { inside, outside };
        Ok(())
    }

    /// Returns the index of a medium, which may be defined later: pbrt-v4 looks names up at the end
    /// of the file.
    fn medium_index(&mut self, name: &str) -> u32 {
        if let Some((index, _)) = self.media.0.get(name) {
            return *index;
        }
        let nothing =
            Homogeneous { absorption: [0.0; 3], scattering: [0.0; 3], emission: [0.0; 3] };
        let index = self.builder.add_medium(Medium::homogeneous(nothing, 0.0));
        self.media.0.insert(name.to_owned(), (index, Some(self.at.clone())));
        index
    }

    /// Reports each medium that is used by a name but never defined.
    pub(super) fn require_named_media(&mut self) {
        let of = |(name, (_, at)): (&String, &(u32, Option<Location>))| {
            at.clone().map(|at| (at, name.clone()))
        };
        let mut undefined: Vec<_> = self.media.0.iter().filter_map(of).collect();
        undefined.retain(|(_, name)| !self.recovery.is_lost(name));
        undefined.sort();
        let defined = self.media.0.iter().filter(|(_, (_, at))| at.is_none());
        let defined: Vec<String> = defined.map(|(name, _)| name.clone()).collect();
        for (at, name) in undefined {
            let hint = hint(&name, defined.iter().map(String::as_str));
            let behind = suggestion_or(hint, "expected a name that MakeNamedMedium defines");
            self.report(SceneError::at(at, format!("no medium named \"{name}\"{behind}"), ""));
        }
    }

    /// Returns the interface of a shape, if it separates two media.
    pub(super) fn shape_interface(&self) -> Option<MediumInterface> {
        let MediumInterface { inside, outside } = self.state.media;
        (inside != outside).then_some(self.state.media)
    }

    fn medium(&mut self, kind: MediumKind, params: &Params) -> Result<Medium, SceneError> {
        let g = asymmetry(params)?;
        let model = match kind {
            MediumKind::Homogeneous => {
                let [absorption, scattering] = coefficients(params)?;
                let emission = radiance(params)?.unwrap_or([0.0; 3]);
                let scale = non_negative(params, "Lescale", 1.0)?;
                let emission = emission.map(|channel| channel * scale);
                MediumModel::Homogeneous(Homogeneous { absorption, scattering, emission })
            }
            MediumKind::UniformGrid => self.in_box(params, density_field(params)?)?,
            MediumKind::RgbGrid => self.in_box(params, colour_field(params)?)?,
            MediumKind::Cloud => self.in_box(params, cloud(params)?)?,
            MediumKind::NanoVdb => {
                let (field, medium_from_unit) = nanovdb_field(params)?;
                self.varying(params, field, &medium_from_unit)?
            }
        };
        Ok(Medium { g, model, boundary: None })
    }

    /// Returns the medium of a field in the box from p0 to p1.
    fn in_box(&mut self, params: &Params, field: Field) -> Result<MediumModel, SceneError> {
        let [low, high] = bounds(params)?;
        let medium_from_unit = DAffine3::from_translation(low) * DAffine3::from_scale(high - low);
        self.varying(params, field, &medium_from_unit)
    }

    /// Returns the medium of a field, whose unit cube is mapped to medium space.
    fn varying(
        &mut self,
        params: &Params,
        field: Field,
        medium_from_unit: &DAffine3,
    ) -> Result<MediumModel, SceneError> {
        let unit_from_world = (self.state.ctm[0] * *medium_from_unit).inverse();
        let Some(medium) = VaryingMedium::new(field, &unit_from_world) else {
            let found = "a medium whose box or transform is flat";
            return Err(SceneError::at(params.at.clone(), found, "check p0, p1 and the transform"));
        };
        let bytes = medium.bytes() as u64;
        granted(&params.at, "the grid of a medium", self.context.claim(bytes))?;
        Ok(MediumModel::Varying(Box::new(medium)))
    }
}

/// Returns the corners of a medium's box.
fn bounds(params: &Params) -> Result<[DVec3; 2], SceneError> {
    let low = DVec3::from(params.triple("p0")?.unwrap_or([0.0; 3]));
    let high = DVec3::from(params.triple("p1")?.unwrap_or([1.0; 3]));
    Ok([low.min(high), low.max(high)])
}

fn non_negative(params: &Params, name: &str, default: f64) -> Result<f32, SceneError> {
    let value = params.float(name, default)? as f32;
    if value >= 0.0 && value.is_finite() {
        return Ok(value);
    }
    Err(params.refuse(name, format!("\"{name}\" is {value}"), "expected 0 or more"))
}

/// Returns the asymmetry of the phase function.
fn asymmetry(params: &Params) -> Result<f32, SceneError> {
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
fn measured(
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
fn coefficients(params: &Params) -> Result<[[f32; 3]; 2], SceneError> {
    let preset = match params.text("preset")? {
        None | Some("") => None,
        Some(name) => Some(measured(params, "preset", name)?),
    };
    let of = |name: &str, measured: Option<[f32; 3]>| -> Result<[f32; 3], SceneError> {
        let given = match measured {
            Some(measured) => Some(measured),
            None => params.colour(name, ColourRole::Unbounded)?,
        };
        scaled(params, given.unwrap_or([1.0; 3]))
    };
    Ok([
        of("sigma_a", preset.map(|medium| medium.absorption))?,
        of("sigma_s", preset.map(|medium| medium.scattering))?,
    ])
}

/// Returns coefficients times the parameter `scale`.
fn scaled(params: &Params, coefficients: [f32; 3]) -> Result<[f32; 3], SceneError> {
    let scale = non_negative(params, "scale", 1.0)?;
    let scaled = coefficients.map(|channel| channel * scale);
    match scaled.iter().all(|channel| *channel <= MAX_EXTINCTION) {
        true => Ok(scaled),
        false => {
            let found = format!("a coefficient of {:e}", scaled.into_iter().fold(0.0, f32::max));
            Err(params.refuse("scale", found, format!("expected at most {MAX_EXTINCTION:e}")))
        }
    }
}

/// Returns the emitted radiance, if there is any.
fn radiance(params: &Params) -> Result<Option<[f32; 3]>, SceneError> {
    let colour = params.colour("Le", ColourRole::Light)?;
    Ok(colour.filter(|colour| colour.iter().any(|&channel| channel > 0.0)))
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
    VoxelGrid<T>: crate::scene::Voxels,
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

fn density_field(params: &Params) -> Result<Field, SceneError> {
    let Some(density) = scalar_grid(params, "density")? else {
        let found = "a grid without \"float density\"";
        return Err(SceneError::at(params.at.clone(), found, "expected a number for every voxel"));
    };
    let [absorption, scattering] = coefficients(params)?;
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
        (None, Some(radiance)) => {
            Some(FieldEmission::Scaled { radiance, scale: strength.unwrap_or_else(one_voxel) })
        }
        (None, None) => None,
    };
    Ok(Field::Density(DensityField { density, absorption, scattering, emission }))
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

fn colour_field(params: &Params) -> Result<Field, SceneError> {
    // pbrt-v4 does not divide these radiances by the integral of the luminosity function.
    let strength = non_negative(params, "Lescale", 1.0)? * luminosity_integral() as f32;
    let field = Field::Colour {
        absorption: colour_grid(params, "sigma_a", ColourRole::Unbounded, 1.0)?,
        scattering: colour_grid(params, "sigma_s", ColourRole::Unbounded, 1.0)?,
        emission: colour_grid(params, "Le", ColourRole::Light, strength)?,
        scale: non_negative(params, "scale", 1.0)?,
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

fn cloud(params: &Params) -> Result<Field, SceneError> {
    let [low, high] = bounds(params)?;
    let [absorption, scattering] = coefficients(params)?;
    let pattern = CloudPattern {
        density: non_negative(params, "density", 1.0)?,
        wispiness: non_negative(params, "wispiness", 1.0)?,
        frequency: non_negative(params, "frequency", 5.0)?,
        low: low.as_vec3(),
        size: (high - low).as_vec3(),
    };
    Ok(Field::Cloud { pattern, absorption, scattering })
}

/// Returns the field of the grids of a NanoVDB file, and the transform of its unit cube to medium
/// space. The cube is the box of the active voxels.
fn nanovdb_field(params: &Params) -> Result<(Field, DAffine3), SceneError> {
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
    let field = Field::Density(DensityField { density, absorption, scattering, emission });
    Ok((field, medium_from_unit))
}

/// Places a grid in the unit cube of a medium.
fn placed_in(grid: NanoGrid, medium_from_unit: &DAffine3) -> ScalarGrid {
    let index_from_unit = grid.medium_from_index.inverse() * *medium_from_unit;
    let voxel_from_unit = DAffine3::from_translation(-grid.first.as_dvec3()) * index_from_unit;
    let voxel_from_unit = voxel_from_unit.as_affine3a();
    ScalarGrid::Sparse(PlacedGrid { grid: grid.voxels, voxel_from_unit })
}

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

/// Largest absorption or scattering coefficient.
const MAX_EXTINCTION: f32 = 1e9;
