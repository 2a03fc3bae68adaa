//! Refractive indices of metals and glasses, from names, spectra, colours or numbers.

use std::sync::Arc;

use super::SceneError;
use super::colour::ColourRole;
use super::material_builder::MaterialBuilder;
use super::params::Params;
use petzval_scene::{Dispersion, Metal, Texture};
use petzval_spectrum::D_LINE;
use petzval_spectrum::{BandSpectrum, ChannelMetal, Colour, Spectrum, fit_metal, named_spectrum};

impl Params {
    /// Returns the refractive index of a glass at the d line, 587.6 nm, and by wavelength if it is a
    /// spectrum.
    fn refractive_index(
        &self,
        name: &str,
        default: f64,
    ) -> Result<(f64, Option<Spectrum>), SceneError> {
        let Some(param) = self.find(name) else { return Ok((default, None)) };
        let (index, spectrum) = match self.scaled_spectrum(param)? {
            Some((spectrum, _)) => (spectrum.index_at(D_LINE), Some(spectrum)),
            None => match self.colour(name, ColourRole::Unbounded)? {
                Some(rgb) => (rgb.iter().map(|&c| f64::from(c)).sum::<f64>() / 3.0, None),
                None => (default, None),
            },
        };
        match index > 0.0 && index.is_finite() {
            true => Ok((index, spectrum)),
            false => {
                Err(self.refuse(name, format!("\"{name}\" is {index}"), "expected more than 0"))
            }
        }
    }

    /// Returns the index and the extinction coefficient of a metal, from parameters that are spectra or
    /// colours. A parameter that is not given, or is a texture, counts as copper's.
    fn metal_indices(&self, eta: &str, k: &str) -> Result<MetalIndices, SceneError> {
        let spectrum = |name: &str, default: &str| -> Result<_, SceneError> {
            match self.find(name).filter(|param| param.kind != "texture") {
                None => Ok(named_spectrum(default)),
                Some(param) => Ok(self.scaled_spectrum(param)?.map(|(spectrum, _)| spectrum)),
            }
        };
        let spectra = [spectrum(eta, "metal-Cu-eta")?, spectrum(k, "metal-Cu-k")?];
        let by_wavelength = |rgb: [f32; 3], s: &Spectrum| {
            let s = s.clone();
            Colour::new(rgb, move || BandSpectrum::of(|nm| s.index_at(nm)))
        };
        if let [Some(eta), Some(k)] = &spectra {
            let ChannelMetal { eta: n, k: extinction, tint } = fit_metal(eta, k);
            // By wavelength, no channel is more saturated than the metal.
            let tint = Colour::new(tint, || BandSpectrum::of(|_| 1.0));
            let (eta, k) = (by_wavelength(n, eta), by_wavelength(extinction, k));
            return Ok(MetalIndices { eta, k, tint });
        }
        let [eta_spectrum, k_spectrum] = spectra;
        let colour = |name: &str, spectrum: Option<Spectrum>| -> Result<Colour, SceneError> {
            match spectrum {
                Some(spectrum) => Ok(by_wavelength(spectrum.reflectance(), &spectrum)),
                None => {
                    let colour = self.spectral_colour(name, ColourRole::Unbounded)?;
                    Ok(colour.unwrap_or([1.0; 3].into()))
                }
            }
        };
        let (eta, k) = (colour(eta, eta_spectrum)?, colour(k, k_spectrum)?);
        Ok(MetalIndices { eta, k, tint: [1.0; 3].into() })
    }
}

/// Refractive index of a metal.
#[derive(Clone, Debug)]
struct MetalIndices {
    /// Real part.
    eta: Colour,
    /// Extinction coefficient.
    k: Colour,
    /// Factor of the reflectance, as in [`ChannelMetal`].
    tint: Colour,
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
            let MetalIndices { eta, k, tint } = self.params.metal_indices(eta, k)?;
            return Ok(Metal::Index { eta: eta.into(), k: k.into(), tint: tint.into() });
        }
        // The parameter beside a texture is looked up by channel, too.
        let constant = self.params.metal_indices(eta, k)?;
        Ok(Metal::Index {
            eta: eta_texture.unwrap_or(constant.eta.into()),
            k: k_texture.unwrap_or(constant.k.into()),
            tint: Texture::Constant([1.0; 3]),
        })
    }

    /// Returns the index of a dielectric at the d line, of the first of these parameters that is given, or
    /// 1.5; and by wavelength.
    pub(super) fn index(&mut self, names: &[&str]) -> Result<(f32, Dispersion), SceneError> {
        let (index, spectrum) = self.index_and_spectrum(names)?;
        let values = spectrum.map(|spectrum| BandSpectrum::of(|nm| spectrum.index_at(nm)));
        let varies = |spectrum: &BandSpectrum| {
            let [first, rest @ ..] = spectrum.values();
            rest.iter().any(|value| value != first)
        };
        Ok((index, values.filter(varies).map(Arc::new)))
    }

    fn index_and_spectrum(
        &mut self,
        names: &[&str],
    ) -> Result<(f32, Option<Spectrum>), SceneError> {
        let Some(param) = names.iter().find_map(|name| self.params.find(name)) else {
            return Ok((1.5, None));
        };
        if param.kind == "texture" {
            let feature = format!("a texture for \"{}\"", param.name);
            self.warnings.unsupported(&param.at, &feature, "1.5 is used");
            return Ok((1.5, None));
        }
        let (index, spectrum) = self.params.refractive_index(&param.name, 1.5)?;
        Ok((index as f32, spectrum))
    }
}

#[cfg(test)]
mod tests {
    use super::super::colour::tests::{given, word};
    use super::super::params::Values;
    use super::*;

    fn index(params: &Params) -> Result<f64, SceneError> {
        params.refractive_index("L", 1.5).map(|(index, _)| index)
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
        let MetalIndices { eta, k, .. } = neither.metal_indices("eta", "k").unwrap();
        let (n, extinction) = (eta.rgb[0], k.rgb[2]);
        assert!((n - 0.154).abs() < 0.02 && (extinction - 2.36).abs() < 0.02, "{eta:?} {k:?}");
        let rgb = given("rgb", Values::Numbers(vec![0.2, 0.9, 1.1]));
        let found = rgb.metal_indices("L", "L").unwrap();
        let found = [found.eta, found.k, found.tint].map(|colour| colour.rgb);
        assert_eq!(found, [[0.2, 0.9, 1.1], [0.2, 0.9, 1.1], [1.0; 3]]);
    }
}
