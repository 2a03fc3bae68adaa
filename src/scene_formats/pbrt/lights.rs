//! The LightSource directive, with the units of pbrt-v4: colours are relative to luminance 1,
//! `scale` multiplies them, `power` is in lumens and `illuminance` in lux.

use std::f32::consts::PI;
use std::path::Path;
use std::sync::Arc;

use glam::{DAffine3, DMat3, DVec3};

use super::attributes::Target;
use super::colour::ColourRole;
use super::directive_kinds::{Directive, SILENT, Selected, known};
use super::params::Params;
use super::portals::{portal, portal_corners};
use super::reader::SceneReader;
use super::{Dialect, SceneError, goniometric, resolve};
use petzval_base::io::path_excerpt;
use petzval_image::{Picture, Transfer};
use petzval_scene::{
    ImageMap, IntensityDistribution, Light, Mapping, PointLight, Sky, SkyImage, SkyLayout, Wrap,
};
use petzval_spectrum::Colour;

/// The kinds of lights that are not shapes.
#[derive(Clone, Copy)]
enum LightKind {
    Infinite,
    Distant,
    Local(LocalLight),
}

/// The kinds of lights at a point.
#[derive(Clone, Copy)]
enum LocalLight {
    Point,
    Spot,
    Goniometric,
    Projection,
}

static LIGHT_SOURCE: Directive<LightKind> = Directive {
    name: "LightSource",
    target: Some(Target::Light),
    shared: &[],
    kinds: &[
        known(
            "infinite",
            LightKind::Infinite,
            &["L", "scale", "filename", "mapname", "illuminance", "portal"],
            &[("nsamples", SILENT), ("samples", SILENT)],
        ),
        known("distant", LightKind::Distant, &["L", "from", "to", "scale", "illuminance"], &[]),
        known("point", LightKind::Local(LocalLight::Point), &["I", "from", "scale", "power"], &[]),
        known(
            "spot",
            LightKind::Local(LocalLight::Spot),
            &["I", "from", "to", "coneangle", "conedeltaangle", "scale", "power"],
            &[],
        ),
        known(
            "goniometric",
            LightKind::Local(LocalLight::Goniometric),
            &["I", "filename", "mapname", "scale", "power"],
            &[],
        ),
        known(
            "projection",
            LightKind::Local(LocalLight::Projection),
            &["I", "filename", "mapname", "fov", "scale", "power"],
            &[],
        ),
    ],
};

impl SceneReader {
    pub(super) fn light_source(&mut self) -> Result<(), SceneError> {
        self.require_in_world("LightSource")?;
        let (name, params) = (self.string()?, self.params()?);
        self.add_light_source(&name, params)
    }

    pub(super) fn add_light_source(
        &mut self,
        name: &str,
        params: Params,
    ) -> Result<(), SceneError> {
        let Selected { name, kind: Some(kind), params } =
            self.check_kind(&LIGHT_SOURCE, name, params)?
        else {
            return Ok(());
        };
        let ctm = self.fixed_transform(&format!("a {name} light"));
        let light = self.light(kind, name, &params, &ctm)?;
        self.builder.add_light(light);
        Ok(())
    }

    fn light(
        &mut self,
        kind: LightKind,
        name: &str,
        params: &Params,
        ctm: &DAffine3,
    ) -> Result<Light, SceneError> {
        let light_from_world = ctm.matrix3.inverse();
        if !light_from_world.is_finite() {
            let found = format!("a {name} light that its transform flattens");
            return Err(SceneError::at(params.at.clone(), found, "check the transform"));
        }
        let colour = match kind {
            LightKind::Infinite | LightKind::Distant => "L",
            LightKind::Local(_) => "I",
        };
        let colour = params.spectral_colour(colour, ColourRole::Light)?;
        let strength = colour.unwrap_or([1.0; 3].into()).scaled(params.scale()?);
        match kind {
            LightKind::Distant => distant(params, ctm, strength),
            LightKind::Infinite => self.sky(params, light_from_world, strength),
            LightKind::Local(kind) => self.local_light(kind, name, params, ctm, strength),
        }
    }

    fn sky(
        &mut self,
        params: &Params,
        light_from_world: DMat3,
        strength: Colour,
    ) -> Result<Light, SceneError> {
        let picture = self.light_image(params)?;
        if let Some(corners) = portal_corners(params)? {
            return portal(params, corners, picture, light_from_world.as_mat3(), strength);
        }
        let image = match picture {
            None => None,
            Some(picture) => {
                let square = picture.size[0] == picture.size[1];
                let layout = match self.dialect {
                    Dialect::V4 | Dialect::V3 if square => SkyLayout::EqualArea,
                    Dialect::V4 | Dialect::V3 | Dialect::V2 => SkyLayout::Equirectangular,
                };
                let picture = unframed(picture, true);
                let image = SkyImage::new(picture, light_from_world.as_mat3(), layout);
                let found = "a sky that its transform flattens";
                Some(image.ok_or_else(|| {
                    SceneError::at(params.at.clone(), found, "check the transform")
                })?)
            }
        };
        let image = image.map(Arc::new);
        let illuminance = || image.as_deref().map_or(PI, SkyImage::illuminance);
        let radiance = sky_radiance(params, strength, illuminance)?;
        Ok(Light::Infinite(Sky { radiance, image, uplift: None }))
    }

    fn local_light(
        &mut self,
        kind: LocalLight,
        name: &str,
        params: &Params,
        ctm: &DAffine3,
        strength: Colour,
    ) -> Result<Light, SceneError> {
        let from = triple(params, "from", DVec3::ZERO)?;
        let mut light_from_world = ctm.matrix3.inverse();
        let distribution = match kind {
            LocalLight::Point => IntensityDistribution::Isotropic,
            LocalLight::Spot => {
                let axis = (triple(params, "to", DVec3::Z)? - from).try_normalize();
                let axis = axis.ok_or_else(|| {
                    params.refuse("to", "a spot light without direction", "from and to must differ")
                })?;
                let (x, y) = axis.any_orthonormal_pair();
                light_from_world = DMat3::from_cols(x, y, axis).transpose() * light_from_world;
                IntensityDistribution::Spot { cosines: spot_cosines(params)? }
            }
            LocalLight::Projection => {
                let picture = self.required_image(name, params)?;
                let fov = angle(params, "fov", 90.0)?;
                let tangent = (fov.to_radians() / 2.0).tan() as f32;
                IntensityDistribution::Projection { picture, uplift: None, tangent }
            }
            LocalLight::Goniometric => {
                let swap = DMat3::from_cols(DVec3::X, DVec3::Z, DVec3::Y);
                light_from_world = swap * light_from_world;
                self.goniometric(name, params)?
            }
        };
        let factor = match requested(params, "power")? {
            Some(power) => power / distribution.power(),
            None => 1.0,
        };
        if !factor.is_finite() {
            let found = "a power for a light whose image is black";
            return Err(params.refuse("power", found, "leave it out"));
        }
        let intensity = scaled(params, strength, factor, "power")?;
        let position = ctm.transform_point3(from).as_vec3();
        let light_from_world = light_from_world.as_mat3();
        Ok(Light::Point(PointLight { position, light_from_world, intensity, distribution }))
    }

    fn goniometric(
        &mut self,
        name: &str,
        params: &Params,
    ) -> Result<IntensityDistribution, SceneError> {
        let is_ies = |file: &str| {
            let extension = Path::new(file).extension();
            extension.is_some_and(|extension| extension.eq_ignore_ascii_case("ies"))
        };
        if let Some(file) = params.text(image_name(params))?.filter(|file| is_ies(file)) {
            let path = resolve(&params.folder, file);
            let refuse = |found: String| {
                params.refuse(image_name(params), found, "expected an IES file (LM-63) of type C")
            };
            let bytes = self.context.bytes(&path).map_err(|error| refuse(error.to_string()))?;
            let picture = goniometric::from_ies(&bytes)
                .map_err(|found| refuse(format!("{}: {found}", path_excerpt(&path))))?;
            return Ok(IntensityDistribution::Goniometric(picture));
        }
        if self.dialect.is_older() {
            // A light without a picture shines alike in all directions.
            let picture = self.light_image(params)?;
            return Ok(picture.map_or(IntensityDistribution::Isotropic, |picture| {
                let picture = goniometric::from_longitude_latitude(&picture);
                IntensityDistribution::Goniometric(picture)
            }));
        }
        let picture = self.required_image(name, params)?;
        let [width, height] = picture.size;
        if width != height {
            let found = format!("a goniometric diagram of {width} x {height} pixels");
            let expected = "expected a square of all directions (equal-area octahedral)";
            return Err(params.refuse("filename", found, expected));
        }
        Ok(IntensityDistribution::Goniometric(picture))
    }

    fn required_image(&mut self, name: &str, params: &Params) -> Result<Arc<Picture>, SceneError> {
        self.light_image(params)?.ok_or_else(|| {
            let found = format!("a {name} light without \"string filename\"");
            params.refuse("filename", found, "expected the name of a picture")
        })
    }

    /// Returns the image of a light, if it has one: `filename`, or `mapname` in pbrt-v2.
    pub(super) fn light_image(
        &mut self,
        params: &Params,
    ) -> Result<Option<Arc<Picture>>, SceneError> {
        let name = image_name(params);
        let picture = self.library.whole_image(params, name, Transfer::Srgb)?;
        if let Some(picture) = &picture
            && !picture.pixels.iter().flatten().all(|v| v.is_finite())
        {
            let found = "an image with pixels that are not finite numbers";
            return Err(params.refuse(name, found, "expected finite ones in a light"));
        }
        Ok(picture)
    }
}

/// Returns the name of the parameter that names the image of a light.
fn image_name(params: &Params) -> &'static str {
    if params.find("mapname").is_some() { "mapname" } else { "filename" }
}

fn distant(params: &Params, ctm: &DAffine3, strength: Colour) -> Result<Light, SceneError> {
    let towards = triple(params, "from", DVec3::ZERO)? - triple(params, "to", DVec3::Z)?;
    let towards = ctm.transform_vector3(towards.normalize_or_zero()).try_normalize();
    let towards = towards.ok_or_else(|| {
        params.refuse("to", "a distant light without direction", "from and to must differ")
    })?;
    let factor = requested(params, "illuminance")?.unwrap_or(1.0);
    let irradiance = scaled(params, strength, factor, "illuminance")?;
    Ok(Light::Distant { towards: towards.as_vec3(), irradiance })
}

/// Returns the cosines of the angles from the axis at which a spot light ends and begins to fade.
fn spot_cosines(params: &Params) -> Result<[f32; 2], SceneError> {
    let end = angle(params, "coneangle", 30.0)?;
    let fade = params.float("conedeltaangle", 5.0)?;
    let given = params.find("conedeltaangle").is_some();
    if given && !(0.0..=2.0 * end).contains(&fade) {
        let found = format!("\"conedeltaangle\" is {fade}");
        let expected = format!("expected 0 to {}, twice the cone angle", 2.0 * end);
        return Err(params.refuse("conedeltaangle", found, expected));
    }
    // A start beyond the axis counts by its angle on the other side, as in pbrt-v4.
    let start = (end - fade).abs().min(end);
    Ok([end, start].map(|angle| angle.to_radians().cos() as f32))
}

/// Returns the power or illuminance that a scene requests. As in pbrt-v4, 0 and less request none.
pub(super) fn requested(params: &Params, name: &str) -> Result<Option<f32>, SceneError> {
    match params.maybe_float(name)?.filter(|&value| value > 0.0) {
        Some(value) if value > f64::from(f32::MAX) => Err(too_strong(params, name)),
        value => Ok(value.map(|value| value as f32)),
    }
}

/// Returns the radiance of an infinite light, or the factor of its image, scaled to the illuminance
/// that a scene requests. `illuminance` is that of the light with a factor of 1.
pub(super) fn sky_radiance(
    params: &Params,
    strength: Colour,
    illuminance: impl FnOnce() -> f32,
) -> Result<Colour, SceneError> {
    let factor = match requested(params, "illuminance")? {
        Some(wanted) => wanted / illuminance(),
        None => 1.0,
    };
    if !factor.is_finite() {
        let found = "an illuminance for an image that is black above the horizon";
        return Err(params.refuse("illuminance", found, "leave it out"));
    }
    scaled(params, strength, factor, "illuminance")
}

/// Returns the emission of a light times the factor that the parameter `request` causes.
pub(super) fn scaled(
    params: &Params,
    strength: Colour,
    factor: f32,
    request: &str,
) -> Result<Colour, SceneError> {
    let product = strength.scaled([factor; 3]);
    let at_fault = if params.find(request).is_some() { request } else { "scale" };
    match product.rgb.iter().all(|s| s.is_finite()) {
        true => Ok(product),
        false => Err(too_strong(params, at_fault)),
    }
}

/// Returns the error for a light whose emission is out of the range of f32.
fn too_strong(params: &Params, name: &str) -> SceneError {
    let found = format!("\"{name}\" makes this light too strong for a picture");
    params.refuse(name, found, "expected less than 3.4e38 in each channel")
}

/// Returns an angle above 0 and up to 180 degrees.
fn angle(params: &Params, name: &str, default: f64) -> Result<f64, SceneError> {
    let value = params.float(name, default)?;
    if value > 0.0 && value <= 180.0 {
        return Ok(value);
    }
    let expected = "expected more than 0 and at most 180 degrees";
    Err(params.refuse(name, format!("\"{name}\" is {value}"), expected))
}

fn triple(params: &Params, name: &str, default: DVec3) -> Result<DVec3, SceneError> {
    Ok(params.triple(name)?.map_or(default, DVec3::from_array))
}

/// Returns an image that covers the unit square, and is clamped beyond it.
pub(super) fn unframed(picture: Arc<Picture>, top_down: bool) -> ImageMap {
    let mapping = Mapping::default();
    ImageMap { picture, mapping, wrap: Wrap::Clamp, top_down, scale: 1.0, invert: false }
}
