//! Colours and spectra from parameters.

use super::params::{Param, Params, Values};
use super::{Notices, SceneError, resolve};
use crate::lens::D_LINE;
use crate::source::{bytes, hint, shown};
use crate::spectrum::{
    ChannelMetal, ColourSpace, Spectrum, blackbody, metal, named, names, srgb_from_xyz,
};

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

    /// Index and extinction coefficient of a metal by channel, from parameters that are spectra or
    /// colours; those of copper where one is not given or is a texture.
    pub(super) fn metal(&self, eta: &str, k: &str) -> Result<ChannelMetal, SceneError> {
        let spectrum = |name: &str, default: &str| -> Result<_, SceneError> {
            match self.find(name).filter(|param| param.kind != "texture") {
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
        let (eta, k) = (colour(eta, spectral_eta)?, colour(k, spectral_k)?);
        Ok(ChannelMetal { eta, k, tint: [1.0; 3] })
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
        let path = resolve(&self.folder, word);
        let text = match bytes(&path) {
            Ok(bytes) if bytes.len() <= MOST_TEXT => String::from_utf8_lossy(&bytes).into_owned(),
            Ok(_) => {
                let found = format!("the spectrum file {} is too long", shown(&path));
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
            let found = format!("{}:{line}: {found}", shown(&path));
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

#[cfg(test)]
mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;
    use crate::source::Location;

    fn params(kind: &str, values: Values, space: ColourSpace, folder: &Path) -> Params {
        let at = Location { file: Arc::from(Path::new("test.pbrt")), line: 2, column: 3 };
        let param = Param { kind: kind.to_owned(), name: "L".to_owned(), values, at: at.clone() };
        Params { all: vec![param], at, space, folder: Arc::from(folder) }
    }

    fn given(kind: &str, values: Values) -> Params {
        params(kind, values, ColourSpace::Srgb, Path::new(""))
    }

    fn word(word: &str) -> Values {
        Values::Texts(vec![word.to_owned()])
    }

    fn colour(params: &Params, meaning: Meaning) -> [f32; 3] {
        params.colour("L", meaning).unwrap().unwrap()
    }

    fn said(params: &Params) -> String {
        params.colour("L", Meaning::Albedo).unwrap_err().to_string()
    }

    fn assert_near(found: [f32; 3], expected: [f32; 3], within: f32) {
        let off = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f32::max);
        assert!(off < within, "{found:?}, expected {expected:?}");
    }

    #[test]
    fn what_a_spectrum_means_depends_on_what_it_is_of() {
        let flat = given("spectrum", Values::Numbers(vec![360.0, 0.5, 830.0, 0.5]));
        assert_near(colour(&flat, Meaning::Albedo), [0.5; 3], 1e-5);
        // Equal energy, with luminance 1, is redder than daylight.
        assert_near(colour(&flat, Meaning::Light), [1.2048, 0.9483, 0.9087], 2e-3);
        let lamp = given("blackbody", Values::Numbers(vec![6504.0]));
        let [r, g, b] = colour(&lamp, Meaning::Light);
        assert!((0.2126 * r + 0.7152 * g + 0.0722 * b - 1.0).abs() < 1e-3);
        // A little more purple than daylight.
        assert!(r > 1.0 && g < 1.0 && b > 1.0, "{r} {g} {b}");
        let day = given("spectrum", word("stdillum-D65"));
        assert_near(colour(&day, Meaning::Light), [1.0; 3], 1e-4);
    }

    #[test]
    fn a_white_of_another_space_is_white_on_a_surface_and_its_own_in_a_light() {
        let white = Values::Numbers(vec![1.0, 1.0, 1.0]);
        let aces = params("rgb", white, ColourSpace::Aces2065, Path::new(""));
        assert_near(colour(&aces, Meaning::Albedo), [1.0; 3], 1e-5);
        assert!(colour(&aces, Meaning::Light)[0] > 1.03);
    }

    #[test]
    fn spectra_are_read_from_files_and_their_faults_are_named() {
        let folder = tempfile::tempdir().unwrap();
        let file = |text: &str| {
            std::fs::write(folder.path().join("a.spd"), text).unwrap();
            params("spectrum", word("a.spd"), ColourSpace::Srgb, folder.path())
        };
        let grey = file("# grey\n360 0.25\n500 0.25 # and on\n830 0.25\n");
        assert_near(colour(&grey, Meaning::Albedo), [0.25; 3], 1e-5);
        let fault = said(&file("400 1\nabc 2\n"));
        assert!(
            fault.contains("test.pbrt:2:3") && fault.contains("a.spd:2: found \"abc\""),
            "{fault}"
        );
        assert!(said(&file("500 1 400 2")).contains("the wavelength 400 nm after 500 nm"));
        assert!(said(&file("500 1 600")).contains("3 numbers"));
        assert!(said(&file("400 NaN 500 1")).contains("found \"NaN\""));
        let missing = params("spectrum", word("b.spd"), ColourSpace::Srgb, folder.path());
        assert!(said(&missing).contains("b.spd"));
    }

    #[test]
    fn a_name_that_is_none_brings_the_nearest_one() {
        let fault = said(&given("spectrum", word("metal-Cu-et")));
        assert!(fault.contains("did you mean \"metal-Cu-eta\"?"), "{fault}");
    }

    #[test]
    fn faulty_colours_are_refused() {
        for (kind, numbers) in [
            ("rgb", vec![0.1, 0.2]),
            ("rgb", vec![0.1, -0.2, 0.3]),
            ("rgb", vec![0.1, 1e300, 0.3]),
            ("blackbody", vec![0.0]),
            ("blackbody", vec![1.0, 2.0, 3.0]),
            ("spectrum", vec![400.0, 1.0]),
            ("spectrum", vec![400.0, 1.0, 390.0, 1.0]),
            ("spectrum", vec![400.0, 1.0, 500.0]),
            ("float", vec![-1.0]),
            ("point3", vec![1.0, 2.0, 3.0]),
        ] {
            let fault = said(&given(kind, Values::Numbers(numbers.clone())));
            assert!(fault.starts_with("test.pbrt:2:3: "), "{kind} {numbers:?}: {fault}");
        }
    }

    #[test]
    fn metals_and_glasses_come_from_spectra_or_numbers() {
        let at = given("spectrum", word("glass-BK7"));
        let index = at.index("L", 1.5, &mut Notices::default()).unwrap();
        assert!((index - 1.5168).abs() < 1e-4);
        let constant = given("float", Values::Numbers(vec![1.33]));
        assert!((constant.index("L", 1.5, &mut Notices::default()).unwrap() - 1.33).abs() < 1e-6);
        assert!(
            given("float", Values::Numbers(vec![0.0]))
                .index("L", 1.5, &mut Notices::default())
                .is_err()
        );
        // Neither is given: copper.
        let ChannelMetal { eta, k, .. } = constant.metal("eta", "k").unwrap();
        assert!((eta[0] - 0.154).abs() < 0.02 && (k[2] - 2.36).abs() < 0.02, "{eta:?} {k:?}");
        let rgb = given("rgb", Values::Numbers(vec![0.2, 0.9, 1.1]));
        let plain = rgb.metal("L", "L").unwrap();
        assert_eq!((plain.eta, plain.k, plain.tint), ([0.2, 0.9, 1.1], [0.2, 0.9, 1.1], [1.0; 3]));
    }
}
