//! Defaults that the file sets for parameters to come, and options of the whole render.

use std::sync::Arc;

use super::SceneError;
use super::params::Params;
use super::reader::Reader;
use super::vocabulary::Entry;
use crate::source::hint;

/// What Attribute can set defaults for.
pub(super) const TARGETS: [&str; 5] = ["shape", "light", "material", "medium", "texture"];

/// Options of pbrt-v4 that cannot change the mean of any pixel here.
const HARMLESS: &[&str] = &[
    "rendercoordsys",
    "displacementedgescale",
    "msereferenceimage",
    "msereferenceout",
    "pixelstats",
    "wavefront",
    "disablewavelengthjitter",
];

/// Options of pbrt-v4 that would, and what happens instead.
const LEFT: &[(&str, &str)] = &[
    ("disablepixeljitter", "samples are spread over their pixels"),
    ("disabletexturefiltering", "textures are looked up as always"),
    ("forcediffuse", "surfaces stay as they are"),
];

impl Reader {
    pub(super) fn attribute(&mut self) -> Result<(), SceneError> {
        let target = self.string()?;
        let params = self.params()?;
        let Some(place) = TARGETS.iter().position(|known| *known == target) else {
            let hint = hint(&target, TARGETS);
            let expected = format!("expected one of {}", TARGETS.join(", "));
            return self.refuse(format!("attributes of \"{target}\"{hint}"), &expected);
        };
        let defaults = Arc::make_mut(&mut self.state.attributes[place]);
        defaults.retain(|param| params.find(&param.name).is_none());
        defaults.extend(params.all);
        Ok(())
    }

    /// Adds the defaults that a kind of a directive understands to what it was given.
    pub(super) fn defaults(&self, entry: &Entry, params: &mut Params) {
        let target = match entry.directive {
            "Shape" => 0,
            "LightSource" | "AreaLightSource" => 1,
            "Material" => 2,
            "Texture" => 4,
            _ => return,
        };
        // The last of a name counts.
        for param in self.state.attributes[target].iter().rev() {
            if params.find(&param.name).is_none() && entry.names().any(|name| name == param.name) {
                params.all.push(param.clone());
            }
        }
    }

    pub(super) fn option(&mut self) -> Result<(), SceneError> {
        let mut params = self.options()?;
        for param in &mut params.all {
            // As in pbrt-v4, "disable-pixel-jitter" and "disablePixelJitter" are one option.
            param.name = param.name.to_lowercase().replace(['-', '_'], "");
        }
        for param in &params.all {
            let name = param.name.as_str();
            if name == "seed" {
                self.seeds[1] = params.seed(name)?;
            } else if let Some((_, instead)) = LEFT.iter().find(|(left, _)| *left == name) {
                if params.truth(name)? == Some(true) {
                    let what = format!("the option \"{name}\"");
                    self.notices.instead(&param.at, &what, instead);
                }
            } else if !HARMLESS.contains(&name) {
                let names = HARMLESS.iter().copied().chain(LEFT.iter().map(|(left, _)| *left));
                let hint = hint(name, names.chain(["seed"]));
                let found = format!("unknown option \"{name}\"{hint}");
                return Err(SceneError::at(param.at.clone(), found, ""));
            }
        }
        Ok(())
    }
}
