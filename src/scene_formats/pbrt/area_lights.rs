//! The AreaLightSource directive: the light that the shapes after it emit.

use std::f32::consts::PI;
use std::sync::Arc;

use super::SceneError;
use super::attributes::Target;
use super::colour::ColourRole;
use super::directive_kinds::{Directive, Ignored, SILENT, Selected, known};
use super::lights::{requested, scaled, unframed};
use super::params::Params;
use super::reader::SceneReader;
use petzval_scene::{Emission, luminance};

const READS: &[&str] = &["L", "scale", "twosided", "power", "filename"];
const IGNORES: &[Ignored] = &[("nsamples", SILENT), ("samples", SILENT)];

static AREA_LIGHT_SOURCE: Directive<()> = Directive {
    name: "AreaLightSource",
    target: Some(Target::Light),
    shared: &[],
    kinds: &[known("area", (), READS, IGNORES), known("diffuse", (), READS, IGNORES)],
};

impl SceneReader {
    pub(super) fn area_light_source(&mut self) -> Result<(), SceneError> {
        self.require_in_world("AreaLightSource")?;
        let Selected { params, .. } = self.select(&AREA_LIGHT_SOURCE)?;
        self.state.area_light = Some(self.emission(&params)?);
        Ok(())
    }

    pub(super) fn emission(&mut self, params: &Params) -> Result<Emission, SceneError> {
        let radiance = params.spectral_colour("L", ColourRole::Light)?;
        let scale = params.scale()?;
        let two_sided = params.boolean("twosided")?.unwrap_or(false);
        let image = self.light_image(params)?;
        if radiance.is_some() && image.is_some() {
            let found = "an area light with both \"L\" and \"filename\"";
            return Err(params.refuse("filename", found, "give only one of them"));
        }
        let mut factor = 1.0;
        let power = requested(params, "power")?;
        if let Some(power) = power {
            let mean_luminance = image.as_ref().map_or(1.0, |picture| {
                let sum: f64 = picture.pixels.iter().map(|&p| f64::from(luminance(p))).sum();
                (sum / picture.pixels.len() as f64) as f32
            });
            factor = power / (PI * mean_luminance * if two_sided { 2.0 } else { 1.0 });
            if !factor.is_finite() {
                let found = "a power for an image that is black";
                return Err(params.refuse("power", found, "leave it out"));
            }
        }
        let strength = radiance.unwrap_or([1.0; 3].into()).scaled(scale);
        Ok(Emission {
            radiance: scaled(params, strength, factor, "power")?,
            two_sided,
            image: image.map(|picture| Arc::new(unframed(picture, false))),
            uplift: None,
            normalize_by_area: power.is_some(),
        })
    }
}
