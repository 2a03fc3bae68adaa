//! Lights from their parameters, with the units of pbrt-v4: colours are relative to luminance
//! 1, `scale` multiplies them, and `power` and `illuminance` are lumens and lux.

use std::f32::consts::PI;
use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3, Mat3};

use super::colour::Meaning;
use super::params::Params;
use super::textures::Library;
use super::{Dialect, SceneError};
use crate::image::Picture;
use crate::scene::{
    Beam, Emission, ImageMap, Lamp, Light, Mapping, Sky, SkyImage, SkyLayout, Wrap, luminance,
};

impl Library {
    /// Makes a light that is no shape.
    pub(super) fn light(
        &mut self,
        name: &str,
        params: &Params,
        ctm: &DAffine3,
        dialect: Dialect,
        folder: &Path,
    ) -> Result<Light, SceneError> {
        let light_from_world = ctm.matrix3.inverse();
        if !light_from_world.is_finite() {
            let found = format!("a {name} light that its transform flattens");
            return Err(SceneError::at(params.at.clone(), found, "check the transform"));
        }
        let colour = match name {
            "distant" | "infinite" => "L",
            _ => "I",
        };
        let colour = params.colour(colour, Meaning::Light)?.unwrap_or([1.0; 3]);
        let scale = params.scale()?;
        let strength = [0, 1, 2].map(|i| colour[i] * scale[i]);
        match name {
            "distant" => distant(params, ctm, strength),
            "infinite" => self.sky(params, light_from_world, dialect, folder, strength),
            _ => self.lamp(name, params, ctm, folder, strength),
        }
    }

    fn sky(
        &mut self,
        params: &Params,
        light_from_world: DMat3,
        dialect: Dialect,
        folder: &Path,
        strength: [f32; 3],
    ) -> Result<Light, SceneError> {
        let image = match self.light_picture(params, folder)? {
            None => None,
            Some(picture) => {
                let square = picture.size[0] == picture.size[1];
                let layout = match dialect {
                    Dialect::V4 if square => SkyLayout::EqualArea,
                    _ => SkyLayout::Equirectangular,
                };
                let image = SkyImage::new(flat(picture, true), single(light_from_world), layout);
                let found = "a sky that its transform flattens";
                Some(image.ok_or_else(|| SceneError::at(params.at.clone(), found, ""))?)
            }
        };
        let factor = match wish(params, "illuminance")? {
            Some(wish) => wish / image.as_ref().map_or(PI, SkyImage::illuminance),
            None => 1.0,
        };
        if !factor.is_finite() {
            let found = "an illuminance for a picture that is black above the horizon";
            return Err(params.refuse("illuminance", found, "leave it out"));
        }
        let radiance = product(params, strength, factor, "illuminance")?;
        Ok(Light::Infinite(Sky { radiance, image }))
    }

    fn lamp(
        &mut self,
        name: &str,
        params: &Params,
        ctm: &DAffine3,
        folder: &Path,
        strength: [f32; 3],
    ) -> Result<Light, SceneError> {
        let from = triple(params, "from", DVec3::ZERO)?;
        let mut light_from_world = ctm.matrix3.inverse();
        let beam = match name {
            "point" => Beam::Bare,
            "spot" => {
                let axis = (triple(params, "to", DVec3::Z)? - from).try_normalize();
                let axis = axis.ok_or_else(|| {
                    params.refuse("to", "a spot light without direction", "from and to must differ")
                })?;
                let (x, y) = axis.any_orthonormal_pair();
                light_from_world = DMat3::from_cols(x, y, axis).transpose() * light_from_world;
                Beam::Spot { cosines: spot(params)? }
            }
            _ => {
                let Some(picture) = self.light_picture(params, folder)? else {
                    let found = format!("a {name} light without \"string filename\"");
                    return Err(params.refuse("filename", found, ""));
                };
                let [width, height] = picture.size;
                if name == "projection" {
                    let fov = between(params, "fov", 90.0, [0.0, 180.0])?;
                    Beam::Projection { picture, tangent: (fov.to_radians() / 2.0).tan() as f32 }
                } else if width == height {
                    let swap = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y);
                    light_from_world = swap * light_from_world;
                    Beam::Diagram(picture)
                } else {
                    let found = format!("a goniometric diagram of {width} x {height} pixels");
                    let expected = "expected a square of all directions (equal-area octahedral)";
                    return Err(params.refuse("filename", found, expected));
                }
            }
        };
        let factor = match wish(params, "power")? {
            Some(wish) => wish / beam.power(),
            None => 1.0,
        };
        if !factor.is_finite() {
            let found = "a power for a light that sends nothing";
            return Err(params.refuse("power", found, "leave it out"));
        }
        let intensity = product(params, strength, factor, "power")?;
        let position = ctm.transform_point3(from).as_vec3();
        let light_from_world = single(light_from_world);
        Ok(Light::Lamp(Lamp { position, light_from_world, intensity, beam }))
    }

    /// What the shapes that follow send out.
    pub(super) fn emission(
        &mut self,
        params: &Params,
        folder: &Path,
    ) -> Result<Emission, SceneError> {
        let radiance = params.colour("L", Meaning::Light)?;
        let scale = params.scale()?;
        let two_sided = params.truth("twosided")?.unwrap_or(false);
        let image = self.light_picture(params, folder)?;
        if radiance.is_some() && image.is_some() {
            let found = "an area light with both \"L\" and \"filename\"";
            return Err(params.refuse("filename", found, "give one of them"));
        }
        let mut factor = 1.0;
        let power = wish(params, "power")?;
        if let Some(power) = power {
            let luminous = image.as_ref().map_or(1.0, |picture| {
                let sum: f64 = picture.pixels.iter().map(|&p| f64::from(luminance(p))).sum();
                (sum / picture.pixels.len() as f64) as f32
            });
            factor = power / (PI * luminous * if two_sided { 2.0 } else { 1.0 });
            if !factor.is_finite() {
                let found = "a power for a picture that is black";
                return Err(params.refuse("power", found, "leave it out"));
            }
        }
        let radiance = radiance.unwrap_or([1.0; 3]);
        let strength = [0, 1, 2].map(|i| radiance[i] * scale[i]);
        Ok(Emission {
            radiance: product(params, strength, factor, "power")?,
            two_sided,
            image: image.map(|picture| flat(picture, false)),
            by_area: power.is_some(),
        })
    }

    /// The picture of a light, if it has one: `filename`, or `mapname` in pbrt-v2.
    fn light_picture(
        &mut self,
        params: &Params,
        folder: &Path,
    ) -> Result<Option<Arc<Picture>>, SceneError> {
        let name = if params.find("mapname").is_some() { "mapname" } else { "filename" };
        let picture = self.picture(params, name, folder, true)?;
        if let Some(picture) = &picture
            && !picture.pixels.iter().flatten().all(|v| v.is_finite())
        {
            let found = "a picture with pixels that are infinite or no numbers";
            return Err(params.refuse(name, found, "a light needs finite ones"));
        }
        Ok(picture)
    }
}

fn distant(params: &Params, ctm: &DAffine3, strength: [f32; 3]) -> Result<Light, SceneError> {
    let towards = triple(params, "from", DVec3::ZERO)? - triple(params, "to", DVec3::Z)?;
    let towards = ctm.transform_vector3(towards.normalize_or_zero()).try_normalize();
    let towards = towards.ok_or_else(|| {
        params.refuse("to", "a distant light from nowhere", "from and to must differ")
    })?;
    let factor = wish(params, "illuminance")?.unwrap_or(1.0);
    let irradiance = product(params, strength, factor, "illuminance")?;
    Ok(Light::Distant { towards: towards.as_vec3(), irradiance })
}

/// Cosines of the angles at which a spot light ends and begins to fade.
fn spot(params: &Params) -> Result<[f32; 2], SceneError> {
    let end = between(params, "coneangle", 30.0, [0.0, 180.0])?;
    let fade = params.float("conedeltaangle", 5.0)?;
    let given = params.find("conedeltaangle").is_some();
    if given && !(0.0..=2.0 * end).contains(&fade) {
        let found = format!("\"conedeltaangle\" is {fade}");
        let expected = format!("expected 0 to the cone angle, {end}");
        return Err(params.refuse("conedeltaangle", found, expected));
    }
    // Beyond the axis pbrt-v4 fades on the other side.
    let start = (end - fade).abs().min(end);
    Ok([end, start].map(|angle| angle.to_radians().cos() as f32))
}

/// A power or an illuminance that is wished for; pbrt-v4 takes 0 and less for no wish.
fn wish(params: &Params, name: &str) -> Result<Option<f32>, SceneError> {
    match params.maybe_float(name)?.filter(|&wish| wish > 0.0) {
        Some(wish) if wish > f64::from(f32::MAX) => Err(too_large(params, name)),
        wish => Ok(wish.map(|wish| wish as f32)),
    }
}

/// The emission of a light, scaled by the factor that the parameter `wished` asks for.
fn product(
    params: &Params,
    strength: [f32; 3],
    factor: f32,
    wished: &str,
) -> Result<[f32; 3], SceneError> {
    let product = strength.map(|s| s * factor);
    let at_fault = if params.find(wished).is_some() { wished } else { "scale" };
    match product.iter().all(|s| s.is_finite()) {
        true => Ok(product),
        false => Err(too_large(params, at_fault)),
    }
}

/// The error for a light that no picture can hold.
fn too_large(params: &Params, name: &str) -> SceneError {
    let found = format!("\"{name}\" makes this light too large for a picture");
    params.refuse(name, found, "expected less than 3.4e38 of all that it sends")
}

/// A number above the first and below the second limit, or at it.
fn between(
    params: &Params,
    name: &str,
    default: f64,
    [low, high]: [f64; 2],
) -> Result<f64, SceneError> {
    let value = params.float(name, default)?;
    if value > low && value <= high {
        return Ok(value);
    }
    let expected = format!("expected more than {low} and at most {high} degrees");
    Err(params.refuse(name, format!("\"{name}\" is {value}"), expected))
}

fn triple(params: &Params, name: &str, default: DVec3) -> Result<DVec3, SceneError> {
    Ok(params.triple(name)?.map_or(default, DVec3::from_array))
}

fn single(matrix: DMat3) -> Mat3 {
    Mat3::from_cols_array(&matrix.to_cols_array().map(|v| v as f32))
}

/// A picture as it is, without a frame.
fn flat(picture: Arc<Picture>, top_down: bool) -> ImageMap {
    let mapping = Mapping::default();
    ImageMap { picture, mapping, wrap: Wrap::Clamp, top_down, scale: 1.0, invert: false }
}
