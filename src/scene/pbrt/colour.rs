//! Colours and spectra from parameters.

use super::blocks::load;
use super::params::{Param, Params, Values};
use super::{Notices, SceneError};
use crate::lens::D_LINE;
use crate::source::hint;
use crate::spectrum::{ColourSpace, Spectrum, blackbody, metal, named, names, srgb_from_xyz};

/// What a colour is the colour of (pbrt-v4's `SpectrumType`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Meaning {
    /// A light: (1, 1, 1) is the white of the colour space, spectra have luminance 1. See
    /// [`Spectrum::light`] for the whole rule.
    Light,
    /// The share of light that a surface reflects: spectra are seen in daylight.
    Albedo,
    /// Anything else by wavelength, such as a refractive index. It turns to RGB as an albedo does,
    /// and knows no upper limit.
    Unbounded,
}

/// The types of parameters that are colours.
const KINDS: [&str; 5] = ["rgb", "xyz", "spectrum", "blackbody", "float"];

/// A spectrum file may hold so much text, bytes.
const MOST_TEXT: usize = 1 << 24;

impl Params {
    /// A colour, if one is given: linear sRGB, 0 or more.
    pub(super) fn colour(
        &self,
        name: &str,
        meaning: Meaning,
    ) -> Result<Option<[f32; 3]>, SceneError> {
        let Some(param) = self.find(name) else { return Ok(None) };
        let rgb = match (&param.values, param.kind.as_str()) {
            (Values::Numbers(v), "rgb") => match v[..] {
                [r, g, b] if [r, g, b].into_iter().any(|c| c < 0.0) => {
                    let found = format!("a colour below 0 for \"{name}\"");
                    return Err(self.refuse(name, found, "expected 0 or more"));
                }
                [r, g, b] => match meaning {
                    Meaning::Light => self.space.light([r, g, b]),
                    Meaning::Albedo | Meaning::Unbounded => self.space.surface([r, g, b]),
                },
                _ => return Err(self.wrong_count(name, v.len(), "three numbers")),
            },
            (Values::Numbers(v), "float") => match v[..] {
                [v] if v < 0.0 => {
                    let found = format!("\"{name}\" is {v}");
                    return Err(self.refuse(name, found, "expected 0 or more"));
                }
                [v] => [v; 3],
                _ => return Err(self.wrong_count(name, v.len(), "one number")),
            },
            (Values::Numbers(v), "xyz") => match v[..] {
                [x, y, z] => srgb_from_xyz([x, y, z]),
                _ => return Err(self.wrong_count(name, v.len(), "three numbers")),
            },
            _ => {
                let Some((spectrum, scale)) = self.scaled_spectrum(param)? else {
                    return Err(param.wrong(&KINDS));
                };
                let colour = match meaning {
                    Meaning::Light => spectrum.light(),
                    Meaning::Albedo | Meaning::Unbounded => spectrum.reflectance(),
                };
                colour.map(|c| scale * f64::from(c))
            }
        };
        let colour = rgb.map(|c| c.max(0.0) as f32);
        match colour.iter().all(|c| c.is_finite()) {
            true => Ok(Some(colour)),
            false => Err(self.refuse(name, format!("a colour without bound for \"{name}\""), "")),
        }
    }

    /// The refractive index of a glass at the d line, 587.6 nm: the renderer carries no
    /// wavelengths.
    #[allow(dead_code, reason = "for the readers of materials")]
    pub(super) fn index(
        &self,
        name: &str,
        default: f64,
        notices: &mut Notices,
    ) -> Result<f64, SceneError> {
        let Some(param) = self.find(name) else { return Ok(default) };
        let index = match self.scaled_spectrum(param)? {
            Some((spectrum, _)) => {
                let what = format!("dispersion, a spectrum for \"{name}\"");
                notices.instead(&param.at, &what, "its value at 587.6 nm is used");
                spectrum.index_at(D_LINE)
            }
            None => match self.colour(name, Meaning::Unbounded)? {
                Some([r, g, b]) => f64::from(r + g + b) / 3.0,
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

    /// Index and extinction coefficient of a metal by channel, from parameters that are spectra or
    /// colours; those of copper where one is not given.
    #[allow(dead_code, reason = "for the readers of materials")]
    pub(super) fn metal(&self, eta: &str, k: &str) -> Result<[[f32; 3]; 2], SceneError> {
        let spectrum = |name: &str, default: &str| -> Result<_, SceneError> {
            match self.find(name) {
                None => Ok(named(default)),
                Some(param) => Ok(self.scaled_spectrum(param)?.map(|(spectrum, _)| spectrum)),
            }
        };
        let spectra = [spectrum(eta, "metal-Cu-eta")?, spectrum(k, "metal-Cu-k")?];
        if let [Some(eta), Some(k)] = &spectra {
            return Ok(metal(eta, k));
        }
        let [spectral_eta, spectral_k] = spectra;
        let colour = |name: &str, spectrum: Option<Spectrum>| -> Result<_, SceneError> {
            match spectrum {
                Some(spectrum) => Ok(spectrum.reflectance()),
                None => Ok(self.colour(name, Meaning::Unbounded)?.unwrap_or([1.0; 3])),
            }
        };
        Ok([colour(eta, spectral_eta)?, colour(k, spectral_k)?])
    }

    /// A spectrum and, behind the temperature of a black body in scenes before pbrt-v4, a factor.
    fn scaled_spectrum(&self, param: &Param) -> Result<Option<(Spectrum, f64)>, SceneError> {
        let refuse = |found: String, expected: &str| {
            Err(SceneError::at(
                param.at.clone(),
                format!("{found} for \"{}\"", param.name),
                expected,
            ))
        };
        Ok(Some(match (&param.values, param.kind.as_str()) {
            (Values::Numbers(v), "blackbody") => {
                let (kelvin, scale) = match v[..] {
                    [kelvin] => (kelvin, 1.0),
                    [kelvin, scale] => (kelvin, scale),
                    _ => {
                        return refuse(format!("{} numbers", v.len()), "expected a temperature, K");
                    }
                };
                if !(kelvin > 0.0 && scale >= 0.0) {
                    return refuse(format!("{kelvin} K"), "expected more than 0");
                }
                (blackbody(kelvin), scale)
            }
            (Values::Numbers(v), "spectrum") => match pairs(v) {
                Ok(spectrum) => (spectrum, 1.0),
                Err(found) => return refuse(found, PAIRS),
            },
            (Values::Texts(v), "spectrum") => match &v[..] {
                [word] => (self.known_spectrum(param, word)?, 1.0),
                _ => return refuse(format!("{} names", v.len()), "expected one"),
            },
            _ => return Ok(None),
        }))
    }

    /// A spectrum by its name, or that of a file beside the scene.
    fn known_spectrum(&self, param: &Param, word: &str) -> Result<Spectrum, SceneError> {
        if let Some(spectrum) = named(word) {
            return Ok(spectrum);
        }
        let path = self.folder.join(word);
        let text = match load(&path) {
            Ok(bytes) if bytes.len() <= MOST_TEXT => String::from_utf8_lossy(&bytes).into_owned(),
            Ok(_) => {
                let found = format!("the spectrum file {} is too long", path.display());
                return Err(SceneError::at(param.at.clone(), found, "expected at most 16 MiB"));
            }
            Err(source) => {
                let names = names();
                let found = match hint(word, names.iter().map(String::as_str)) {
                    none if none.is_empty() => source.to_string(),
                    hint => format!("no spectrum \"{word}\"{hint}"),
                };
                let expected = "expected the name of a spectrum or of a file";
                return Err(SceneError::at(param.at.clone(), found, expected));
            }
        };
        let refuse = |line: usize, found: String| {
            let found = format!("{}:{line}: {found}", path.display());
            SceneError::at(param.at.clone(), found, PAIRS)
        };
        let mut numbers = Vec::new();
        for (i, line) in text.lines().enumerate() {
            let data = line.split('#').next().unwrap_or_default();
            for word in data.split_whitespace() {
                let number = word.parse().ok().filter(|number: &f64| number.is_finite());
                numbers.push(number.ok_or_else(|| refuse(i + 1, format!("found {word:?}")))?);
            }
        }
        pairs(&numbers).map_err(|found| refuse(text.lines().count(), found))
    }

    /// The `scale` of a light, by channel: pbrt-v4 gives a number, pbrt-v2 a colour.
    pub(super) fn scale(&self) -> Result<[f32; 3], SceneError> {
        Ok(self.colour("scale", Meaning::Unbounded)?.unwrap_or([1.0; 3]))
    }
}

const PAIRS: &str =
    "expected at least two pairs of wavelength, nm, and value, wavelengths ascending";

/// A spectrum of wavelengths and values in turn, or what is wrong with it.
fn pairs(numbers: &[f64]) -> Result<Spectrum, String> {
    let (pairs, rest) = numbers.as_chunks::<2>();
    if pairs.len() < 2 || !rest.is_empty() {
        return Err(format!("{} numbers", numbers.len()));
    }
    Spectrum::samples(pairs.to_vec()).map_err(|disorder| disorder.to_string())
}

impl super::reader::Reader {
    pub(super) fn colour_space(&mut self) -> Result<(), SceneError> {
        let name = self.string()?;
        match ColourSpace::named(&name) {
            Some(space) => {
                self.state.space = space;
                Ok(())
            }
            None => {
                let hint = hint(&name, ColourSpace::NAMES);
                let expected = format!("expected one of {}", ColourSpace::NAMES.join(", "));
                self.refuse(format!("the colour space \"{name}\"{hint}"), &expected)
            }
        }
    }
}
