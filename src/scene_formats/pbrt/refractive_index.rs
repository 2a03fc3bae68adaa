//! Refractive indices of metals and glasses, from names, spectra, colours or numbers.

use super::colour::ColourRole;
use super::material_builder::MaterialBuilder;
use super::params::Params;
use super::{SceneError, WarningLog};
use petzval_scene::{Metal, Texture};
use petzval_spectrum::D_LINE;
use petzval_spectrum::{ChannelMetal, Spectrum, fit_metal, named_spectrum};

impl Params {
    /// Returns the refractive index of a glass at the d line, 587.6 nm: the renderer carries no
    /// wavelengths through a scene.
    fn refractive_index(
        &self,
        name: &str,
        default: f64,
        warnings: &mut WarningLog,
    ) -> Result<f64, SceneError> {
        let Some(param) = self.find(name) else { return Ok(default) };
        let index = match self.scaled_spectrum(param)? {
            Some((spectrum, _)) => {
                let feature = format!("dispersion, a spectrum for \"{name}\"");
                warnings.unsupported(&param.at, &feature, "its value at 587.6 nm is used");
                spectrum.index_at(D_LINE)
            }
            None => match self.colour(name, ColourRole::Unbounded)? {
                Some(rgb) => rgb.iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0,
                None => default,
            },
        };
        match index > 0.0 && index.is_finite() {
            true => Ok(index),
            false => {
                Err(self.refuse(name, format!("\"{name}\" is {index}"), "expected more than 0"))
            }
        }
    }

    /// Returns the index and extinction coefficient of a metal by channel, from parameters that are
    /// spectra or colours. A parameter that is not given, or is a texture, counts as copper's.
    fn channel_metal(&self, eta: &str, k: &str) -> Result<ChannelMetal, SceneError> {
        let spectrum = |name: &str, default: &str| -> Result<_, SceneError> {
            match self.find(name).filter(|param| param.kind != "texture") {
                None => Ok(named_spectrum(default)),
                Some(param) => Ok(self.scaled_spectrum(param)?.map(|(spectrum, _)| spectrum)),
            }
        };
        let spectra = [spectrum(eta, "metal-Cu-eta")?, spectrum(k, "metal-Cu-k")?];
        if let [Some(eta), Some(k)] = &spectra {
            return Ok(fit_metal(eta, k));
        }
        let [eta_spectrum, k_spectrum] = spectra;
        let colour = |name: &str, spectrum: Option<Spectrum>| -> Result<_, SceneError> {
            match spectrum {
                Some(spectrum) => Ok(spectrum.reflectance()),
                None => Ok(self.colour(name, ColourRole::Unbounded)?.unwrap_or([1.0; 3])),
            }
        };
        let (eta, k) = (colour(eta, eta_spectrum)?, colour(k, k_spectrum)?);
        Ok(ChannelMetal { eta, k, tint: [1.0; 3] })
    }
}

impl MaterialBuilder<'_> {
    /// Returns the metal of these parameters, or copper if none is given.
    pub(super) fn metal(&mut self, eta: &str, k: &str) -> Result<Metal, SceneError> {
        let indices = self.params.find(eta).or(self.params.find(k));
        let reflectance =
            self.library.colour_or_texture(self.params, "reflectance", ColourRole::Albedo)?;
        if let Some(reflectance) = reflectance {
            if indices.is_some() {
                let found = format!("a metal with reflectance and with {eta} or {k}");
                return Err(self.params.refuse("reflectance", found, "expected one or the other"));
            }
            return Ok(Metal::Reflectance(reflectance));
        }
        let texture = |name: &str| {
            Ok::<_, SceneError>(match self.params.texture(name)? {
                Some(_) => {
                    self.library.colour_or_texture(self.params, name, ColourRole::Unbounded)?
                }
                None => None,
            })
        };
        let (eta_texture, k_texture) = (texture(eta)?, texture(k)?);
        if eta_texture.is_none() && k_texture.is_none() {
            let ChannelMetal { eta, k, tint } = self.params.channel_metal(eta, k)?;
            let [eta, k] = [eta, k].map(Texture::Constant);
            return Ok(Metal::Index { eta, k, tint });
        }
        // The parameter beside a texture is looked up by channel, too.
        let constant = self.params.channel_metal(eta, k)?;
        Ok(Metal::Index {
            eta: eta_texture.unwrap_or(Texture::Constant(constant.eta)),
            k: k_texture.unwrap_or(Texture::Constant(constant.k)),
            tint: [1.0; 3],
        })
    }

    /// Returns the index of a dielectric: the first of these parameters that is given, or 1.5.
    pub(super) fn index(&mut self, names: &[&str]) -> Result<f32, SceneError> {
        let Some(param) = names.iter().find_map(|name| self.params.find(name)) else {
            return Ok(1.5);
        };
        if param.kind == "texture" {
            let feature = format!("a texture for \"{}\"", param.name);
            self.warnings.unsupported(&param.at, &feature, "1.5 is used");
            return Ok(1.5);
        }
        Ok(self.params.refractive_index(&param.name, 1.5, self.warnings)? as f32)
    }
}

#[cfg(test)]
mod tests {
    use super::super::colour::tests::{given, word};
    use super::super::params::Values;
    use super::*;

    fn index(params: &Params) -> Result<f64, SceneError> {
        params.refractive_index("L", 1.5, &mut WarningLog::default())
    }

    #[test]
    fn the_index_of_a_glass_comes_from_a_spectrum_or_a_number() {
        assert!((index(&given("spectrum", word("glass-BK7"))).unwrap() - 1.5168).abs() < 1e-4);
        let constant = given("float", Values::Numbers(vec![1.33]));
        assert!((index(&constant).unwrap() - 1.33).abs() < 1e-6);
        assert!(index(&given("float", Values::Numbers(vec![0.0]))).is_err());
    }

    #[test]
    fn a_metal_comes_from_colours_and_is_copper_by_default() {
        let neither = given("float", Values::Numbers(vec![1.33]));
        let ChannelMetal { eta, k, .. } = neither.channel_metal("eta", "k").unwrap();
        assert!((eta[0] - 0.154).abs() < 0.02 && (k[2] - 2.36).abs() < 0.02, "{eta:?} {k:?}");
        let rgb = given("rgb", Values::Numbers(vec![0.2, 0.9, 1.1]));
        let found = rgb.channel_metal("L", "L").unwrap();
        assert_eq!((found.eta, found.k, found.tint), ([0.2, 0.9, 1.1], [0.2, 0.9, 1.1], [1.0; 3]));
    }
}
