//! Makes scattering models from the parameters of materials.

use std::sync::Arc;

use super::colour::ColourRole;
use super::params::{Params, Values};
use super::subsurface::subsurface;
use super::texture_library::{TextureLibrary, TextureType};
use super::{SceneError, WarningLog, resolve};
use petzval_base::io::path_excerpt;
use petzval_scene::{
    DielectricCoat, HairColour, HairFibre, MaterialModel, MeasuredSurface, Roughness, Texture,
};

/// The names of the parameters of a subsurface material.
#[derive(Clone, Copy)]
pub(super) struct SubsurfaceNames {
    /// Colours, each with its name in pbrt-v4.
    colours: &'static [(&'static str, &'static str)],
    /// Refractive index.
    eta: &'static [&'static str],
    /// The reflectance if none is given; `None` is that of a measured medium.
    reflectance: Option<f32>,
}

pub(super) const SUBSURFACE: SubsurfaceNames = SubsurfaceNames {
    colours: &[
        ("sigma_a", "sigma_a"),
        ("sigma_s", "sigma_s"),
        ("reflectance", "reflectance"),
        ("mfp", "mfp"),
    ],
    eta: &["eta"],
    reflectance: None,
};

/// The names in pbrt-v2 and v3 of what `pbrt --upgrade` makes a `subsurface`.
pub(super) const KD_SUBSURFACE: SubsurfaceNames = SubsurfaceNames {
    colours: &[("Kd", "reflectance"), ("mfp", "mfp"), ("meanfreepath", "mfp")],
    eta: &["eta", "index"],
    reflectance: Some(0.5),
};

/// Extensions of the files of measured surfaces of pbrt-v2: tables of samples, and those of MERL.
const OLD_MEASURED: [&str; 3] = ["brdf", "binary", "merl"];

/// The parameters of a material and the textures that they name.
pub(super) struct MaterialBuilder<'a> {
    pub(super) params: &'a Params,
    pub(super) library: &'a TextureLibrary,
    pub(super) warnings: &'a mut WarningLog,
}

/// Returns a texture of the same number in every channel.
fn grey(value: f32) -> Texture {
    Texture::Constant([value; 3])
}

impl MaterialBuilder<'_> {
    /// Reads the file of a measured surface. Those of pbrt-v2 have a substitute.
    pub(super) fn measured(&mut self) -> Result<MaterialModel, SceneError> {
        let Some(file) = self.params.text("filename")? else {
            let found = "a measured material without \"string filename\"";
            return Err(self.params.refuse("filename", found, "expected the name of a .bsdf file"));
        };
        let path = resolve(&self.params.folder, file);
        let extension = path.extension().and_then(|extension| extension.to_str()).unwrap_or("");
        if OLD_MEASURED.iter().any(|old| extension.eq_ignore_ascii_case(old)) {
            let feature = format!("a measured material of a .{} file", extension.to_lowercase());
            let instead = "a diffuse surface of its reflectance, Kd or color, or of 0.5, is used";
            self.warnings.unsupported(&self.params.location("filename"), &feature, instead);
            return Ok(self.substitute());
        }
        let refuse = |found: String| {
            let expected = "expected a .bsdf file of the RGL's material database";
            self.params.refuse("filename", found, expected)
        };
        let bytes = self.params.context.bytes(&path).map_err(|error| refuse(error.to_string()))?;
        let read = MeasuredSurface::read(&bytes);
        read.map(|surface| MaterialModel::Measured(Arc::new(surface)))
            .map_err(|found| refuse(format!("{}: {found}", path_excerpt(&path))))
    }

    /// Reads a surface over a medium, whose coefficients must be the same everywhere. `names` are its
    /// parameters.
    pub(super) fn subsurface(
        &mut self,
        names: SubsurfaceNames,
    ) -> Result<MaterialModel, SceneError> {
        let index = match names.eta.iter().any(|name| self.params.find(name).is_some()) {
            true => self.index(names.eta)?,
            false => (1.33, None),
        };
        let (library, params) = (&self.library, self.params);
        let texture = |wanted: &str, role| -> Result<Option<Texture>, SceneError> {
            let given = names.colours.iter().filter(|(_, meaning)| *meaning == wanted);
            let mut found = None;
            for (name, _) in given {
                found = found.or(library.colour_or_texture(params, name, role)?);
            }
            let is_missing = found.is_none() && wanted == "reflectance";
            Ok(if is_missing { names.reflectance.map(grey) } else { found })
        };
        for (name, meaning) in names.colours {
            let found = texture(meaning, ColourRole::Unbounded)?;
            if found.is_some_and(|texture| texture.constant().is_none()) {
                let feature = "a texture in a subsurface material";
                let instead = "a diffuse surface of its reflectance, or of 0.5, is used";
                self.warnings.unsupported(&params.location(name), feature, instead);
                return Ok(self.substitute());
            }
        }
        let colour = |name: &str, role| {
            Ok(texture(name, role)?.and_then(|texture| texture.constant_colour()))
        };
        let interior = subsurface(params, index, colour)?;
        Ok(MaterialModel::Subsurface { interior, roughness: self.roughness("", 0.0)? })
    }

    /// Returns whether a colour is 0 in all channels.
    pub(super) fn is_black(&self, name: &str) -> bool {
        let values = self.params.find(name).map(|param| &param.values);
        matches!(values, Some(Values::Numbers(v)) if !v.is_empty() && v.iter().all(|&c| c == 0.0))
    }

    /// Returns the amount of a mix: a number, or before pbrt-v4 a colour, which counts by its mean.
    pub(super) fn amount(&mut self) -> Result<Texture, SceneError> {
        let given = self.params.find("amount").map(|param| param.kind.as_str());
        let old = self.params.find("namedmaterial1").is_some();
        if !matches!(given, None | Some("float" | "integer" | "texture")) {
            let rgb = self.params.colour("amount", ColourRole::Unbounded)?.unwrap_or([0.5; 3]);
            return Ok(grey(rgb.iter().sum::<f32>() / 3.0));
        }
        if old && let Some(name) = self.params.texture("amount")? {
            let key = (TextureType::Spectrum, name.to_owned());
            if let Some(texture) = self.library.textures.get(&key) {
                return Ok(texture.clone());
            }
        }
        self.number("amount", 0.5)
    }

    /// Returns the substitute for a kind that is not supported. A parameter that is not a colour is
    /// not an error: its name may have another meaning there.
    pub(super) fn substitute(&self) -> MaterialModel {
        let mut reflectance = None;
        for name in ["Kd", "reflectance", "color"] {
            let colour = self.library.colour_or_texture(self.params, name, ColourRole::Albedo);
            reflectance = reflectance.or(colour.unwrap_or(None));
        }
        MaterialModel::Diffuse { reflectance: reflectance.unwrap_or_else(|| grey(0.5)) }
    }

    /// Reads a hair. Of several colours, the first in pbrt-v4's order counts.
    pub(super) fn hair(&mut self) -> Result<HairFibre, SceneError> {
        let colour = |name: &str, role| self.library.colour_or_texture(self.params, name, role);
        let absorption = colour("sigma_a", ColourRole::Unbounded)?;
        let reflectance = match colour("reflectance", ColourRole::Albedo)? {
            None => colour("color", ColourRole::Albedo)?,
            some => some,
        };
        let [eumelanin, pheomelanin] =
            [self.maybe_number("eumelanin")?, self.maybe_number("pheomelanin")?];
        let colour = match (absorption, reflectance) {
            (Some(absorption), _) => HairColour::Absorption(absorption),
            (None, Some(reflectance)) => HairColour::Reflectance(reflectance),
            (None, None) => {
                // Brown if nothing is given.
                let default = if pheomelanin.is_some() { 0.0 } else { 1.3 };
                HairColour::melanin(
                    eumelanin.unwrap_or_else(|| grey(default)),
                    pheomelanin.unwrap_or_else(|| grey(0.0)),
                )
            }
        };
        Ok(HairFibre {
            colour,
            eta: self.number("eta", 1.55)?,
            beta_m: self.number("beta_m", 0.3)?,
            beta_n: self.number("beta_n", 0.3)?,
            alpha: self.number("alpha", 2.0)?,
        })
    }

    /// Reads the layer over a coated surface, whose roughness has the given prefix and default.
    pub(super) fn coat(
        &mut self,
        prefix: &str,
        eta: &[&str],
        roughness: f32,
    ) -> Result<Box<DielectricCoat>, SceneError> {
        let (eta, dispersion) = self.index(eta)?;
        Ok(Box::new(DielectricCoat {
            eta,
            dispersion,
            roughness: self.roughness(prefix, roughness)?,
            thickness: self.number("thickness", 0.01)?,
            albedo: self.colour("albedo", 0.0)?,
            g: self.number("g", 0.0)?,
            max_depth: self.params.count("maxdepth", 10_000)?.unwrap_or(10),
            samples: self.params.count("nsamples", 10_000)?.unwrap_or(1),
        }))
    }

    pub(super) fn roughness(
        &mut self,
        prefix: &str,
        default: f32,
    ) -> Result<Roughness, SceneError> {
        let both = self.number(&format!("{prefix}roughness"), default)?;
        let mut along = |axis: &str| -> Result<Texture, SceneError> {
            let own = self.maybe_number(&format!("{prefix}{axis}roughness"))?;
            Ok(own.unwrap_or_else(|| both.clone()))
        };
        let uv = [along("u")?, along("v")?];
        Ok(Roughness { uv, remap: self.params.boolean("remaproughness")?.unwrap_or(true) })
    }

    /// Returns a colour or a texture of colours.
    pub(super) fn colour(&mut self, name: &str, default: f32) -> Result<Texture, SceneError> {
        let found = self.library.colour_or_texture(self.params, name, ColourRole::Albedo)?;
        Ok(found.unwrap_or_else(|| grey(default)))
    }

    /// Returns a number or a texture of numbers.
    fn number(&mut self, name: &str, default: f32) -> Result<Texture, SceneError> {
        Ok(self.maybe_number(name)?.unwrap_or_else(|| grey(default)))
    }

    /// Returns a number or a texture of numbers, if it is given.
    pub(super) fn maybe_number(&mut self, name: &str) -> Result<Option<Texture>, SceneError> {
        self.library.number_or_texture(self.params, name)
    }
}
