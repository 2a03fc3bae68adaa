//! Colours and spectra of parameters, and the ColorSpace directive.

use super::SceneError;
use super::params::{Param, Params, Values};
use super::sample_files::{SampleFile, check_visible};
use petzval_base::io::{ReadError, hint};
use petzval_spectrum::{
    BandSpectrum, Colour, ColourSpace, Spectrum, blackbody, named_spectrum, spectrum_names,
    srgb_from_xyz,
};

/// The physical role of a colour, which decides how a spectrum becomes RGB (pbrt-v4's
/// `SpectrumType`).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum ColourRole {
    /// The emission of a light: (1, 1, 1) is the white of the colour space, spectra have luminance
    /// 1. [`Spectrum::light`] states the whole rule.
    Light,
    /// The fraction of light that a surface reflects: spectra are illuminated by daylight (D65).
    Albedo,
    /// Any other quantity by wavelength, such as a refractive index. It becomes RGB as an albedo
    /// does, without an upper limit.
    Unbounded,
}

impl ColourRole {
    /// Returns the values of a spectrum in bands.
    fn split(self, spectrum: &Spectrum) -> BandSpectrum {
        match self {
            Self::Light => spectrum.light_by_wavelength(),
            Self::Albedo => BandSpectrum::of(|nm| spectrum.at(nm).min(1.0)),
            Self::Unbounded => BandSpectrum::of(|nm| spectrum.at(nm)),
        }
    }
}

/// The types of parameters that are colours.
const KINDS: [&str; 5] = ["rgb", "xyz", "spectrum", "blackbody", "float"];

impl Params {
    /// Returns the linear sRGB of a colour, if it is given; 0 or more.
    pub(super) fn colour(
        &self,
        name: &str,
        role: ColourRole,
    ) -> Result<Option<[f32; 3]>, SceneError> {
        Ok(self.spectral_colour(name, role)?.map(|colour| colour.rgb))
    }

    /// Returns a colour, if it is given, with its spectrum if that is given.
    pub(super) fn spectral_colour(
        &self,
        name: &str,
        role: ColourRole,
    ) -> Result<Option<Colour>, SceneError> {
        let Some(param) = self.find(name) else { return Ok(None) };
        let mut known = None;
        let rgb = match (&param.values, param.kind.as_str()) {
            (Values::Numbers(v), "rgb") => match v[..] {
                [r, g, b] if [r, g, b].into_iter().any(|c| c < 0.0) => {
                    let found = format!("a colour below 0 for \"{name}\"");
                    return Err(self.refuse(name, found, "expected 0 or more"));
                }
                [r, g, b] => match role {
                    ColourRole::Light => self.space.light([r, g, b]),
                    ColourRole::Albedo | ColourRole::Unbounded => self.space.surface([r, g, b]),
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
                    return Err(param.wrong_type(&KINDS));
                };
                let colour = match role {
                    ColourRole::Light => spectrum.light(),
                    ColourRole::Albedo | ColourRole::Unbounded => spectrum.reflectance(),
                };
                known = Some((spectrum, scale as f32));
                colour.map(|c| scale * f64::from(c))
            }
        };
        let colour = rgb.map(|c| c.max(0.0) as f32);
        match colour.iter().all(|c| c.is_finite()) {
            true => Ok(Some(match known {
                None => colour.into(),
                Some((spectrum, scale)) => {
                    Colour::new(colour, move || role.split(&spectrum).scaled(scale))
                }
            })),
            false => Err(self.refuse(
                name,
                format!("a colour that is not finite for \"{name}\""),
                "expected at most 3.4e38",
            )),
        }
    }

    /// Returns the spectrum of a parameter, and a factor, which scenes before pbrt-v4 give behind
    /// the temperature of a black body. Returns `None` for a parameter that is not a spectrum.
    pub(super) fn scaled_spectrum(
        &self,
        param: &Param,
    ) -> Result<Option<(Spectrum, f64)>, SceneError> {
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
            (Values::Numbers(v), "spectrum") => match sampled_spectrum(v) {
                Ok(spectrum) => (spectrum, 1.0),
                Err(found) => return refuse(found, EXPECTED_SAMPLES),
            },
            (Values::Texts(v), "spectrum") => match &v[..] {
                [word] => (self.known_spectrum(param, word)?, 1.0),
                _ => return refuse(format!("{} names", v.len()), "expected one"),
            },
            _ => return Ok(None),
        }))
    }

    /// Returns a named spectrum, or reads one from a file.
    fn known_spectrum(&self, param: &Param, word: &str) -> Result<Spectrum, SceneError> {
        if let Some(spectrum) = named_spectrum(word) {
            return Ok(spectrum);
        }
        let unknown = |source: ReadError| {
            let names = spectrum_names();
            let found = match hint(word, names.iter().map(String::as_str)) {
                none if none.is_empty() => source.to_string(),
                hint => format!("no spectrum \"{word}\"{hint}"),
            };
            (found, "expected the name of a spectrum or of a file".to_owned())
        };
        let file = SampleFile::read(self, param.at.clone(), word, unknown)?;
        let numbers: Result<Vec<f64>, _> =
            file.lines().flatten().map(|word| word.number()).collect();
        let spectrum = numbers.and_then(|numbers| {
            sampled_spectrum(&numbers).map_err(|found| file.fault_at_end(found))
        });
        spectrum.map_err(|fault| file.refuse(fault, EXPECTED_SAMPLES))
    }

    /// Returns the `scale` of a light by channel: a number in pbrt-v4, a colour in pbrt-v2.
    pub(super) fn scale(&self) -> Result<[f32; 3], SceneError> {
        Ok(self.colour("scale", ColourRole::Unbounded)?.unwrap_or([1.0; 3]))
    }
}

const EXPECTED_SAMPLES: &str =
    "expected at least two pairs of a wavelength [nm] and a value of 0 or more, in ascending order";

/// Makes a spectrum of alternating wavelengths and values, or returns the fault.
fn sampled_spectrum(numbers: &[f64]) -> Result<Spectrum, String> {
    let (pairs, rest) = numbers.as_chunks::<2>();
    if pairs.len() < 2 || !rest.is_empty() {
        return Err(format!("{} numbers", numbers.len()));
    }
    if let Some([nm, value]) = pairs.iter().find(|[_, value]| *value < 0.0) {
        return Err(format!("the value {value} at {nm} nm, below 0"));
    }
    let [[first, _], .., [last, _]] = pairs else {
        return Err(format!("{} numbers", numbers.len()));
    };
    check_visible(*first, *last)?;
    Spectrum::samples(pairs.to_vec()).map_err(|disorder| disorder.to_string())
}

impl super::reader::SceneReader {
    pub(super) fn colour_space(&mut self) -> Result<(), SceneError> {
        let name = self.string()?;
        match ColourSpace::from_name(&name) {
            Some(space) => {
                self.state.colour_space = space;
                Ok(())
            }
            None => {
                let hint = hint(&name, ColourSpace::NAMES);
                let expected = format!("expected one of {}", ColourSpace::NAMES.join(", "));
                self.refuse(format!("unknown colour space \"{name}\"{hint}"), &expected)
            }
        }
    }
}

#[cfg(test)]
pub(super) mod tests {
    use std::path::Path;
    use std::sync::Arc;

    use super::*;
    use petzval_base::io::{Location, ReadContext};

    fn params(kind: &str, values: Values, space: ColourSpace, folder: &Path) -> Params {
        Params { space, ..given_in("L", kind, values, folder) }
    }

    pub(in super::super) fn given_in(
        name: &str,
        kind: &str,
        values: Values,
        folder: &Path,
    ) -> Params {
        let at = Location { file: Arc::from(Path::new("test.pbrt")), line: 2, column: 3 };
        let param = Param { kind: kind.to_owned(), name: name.to_owned(), values, at: at.clone() };
        let (folder, context) = (Arc::from(folder), ReadContext::default());
        Params { all: vec![param], at, space: ColourSpace::Srgb, folder, context }
    }

    pub(in super::super) fn given(kind: &str, values: Values) -> Params {
        params(kind, values, ColourSpace::Srgb, Path::new(""))
    }

    pub(in super::super) fn word(word: &str) -> Values {
        Values::Texts(vec![word.to_owned()])
    }

    fn colour(params: &Params, role: ColourRole) -> [f32; 3] {
        params.colour("L", role).unwrap().unwrap()
    }

    fn refusal(params: &Params) -> String {
        params.colour("L", ColourRole::Albedo).unwrap_err().to_string()
    }

    fn assert_near(found: [f32; 3], expected: [f32; 3], within: f32) {
        let off = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f32::max);
        assert!(off < within, "{found:?}, expected {expected:?}");
    }

    #[test]
    fn a_spectrum_becomes_rgb_by_its_role() {
        let flat = given("spectrum", Values::Numbers(vec![360.0, 0.5, 830.0, 0.5]));
        assert_near(colour(&flat, ColourRole::Albedo), [0.5; 3], 1e-5);
        // Equal energy of luminance 1 is redder than daylight.
        assert_near(colour(&flat, ColourRole::Light), [1.2048, 0.9483, 0.9087], 2e-3);
        let black_body = given("blackbody", Values::Numbers(vec![6504.0]));
        let [r, g, b] = colour(&black_body, ColourRole::Light);
        assert!((0.2126 * r + 0.7152 * g + 0.0722 * b - 1.0).abs() < 1e-3);
        // A little more purple than daylight.
        assert!(r > 1.0 && g < 1.0 && b > 1.0, "{r} {g} {b}");
        let day = given("spectrum", word("stdillum-D65"));
        assert_near(colour(&day, ColourRole::Light), [1.0; 3], 1e-4);
    }

    #[test]
    fn the_white_of_a_space_is_white_on_a_surface_and_keeps_its_hue_in_a_light() {
        let white = Values::Numbers(vec![1.0, 1.0, 1.0]);
        let aces = params("rgb", white, ColourSpace::Aces2065, Path::new(""));
        assert_near(colour(&aces, ColourRole::Albedo), [1.0; 3], 1e-5);
        assert!(colour(&aces, ColourRole::Light)[0] > 1.03);
    }

    #[test]
    fn spectrum_files_are_read_and_their_faults_have_locations() {
        let folder = tempfile::tempdir().unwrap();
        let file = |text: &str| {
            std::fs::write(folder.path().join("a.spd"), text).unwrap();
            params("spectrum", word("a.spd"), ColourSpace::Srgb, folder.path())
        };
        let grey = file("# grey\n360 0.25\n500 0.25 # and on\n830 0.25\n");
        assert_near(colour(&grey, ColourRole::Albedo), [0.25; 3], 1e-5);
        let fault = refusal(&file("400 1\nabc 2\n"));
        assert!(
            fault.contains("test.pbrt:2:3") && fault.contains("a.spd:2:1: found \"abc\""),
            "{fault}"
        );
        assert!(refusal(&file("500 1 400 2")).contains("the wavelength 400 nm after 500 nm"));
        assert!(refusal(&file("500 1 600")).contains("3 numbers"));
        assert!(refusal(&file("400 NaN 500 1")).contains("found \"NaN\""));
        let missing = params("spectrum", word("b.spd"), ColourSpace::Srgb, folder.path());
        assert!(refusal(&missing).contains("b.spd"));
    }

    #[test]
    fn an_unknown_name_brings_a_suggestion() {
        let fault = refusal(&given("spectrum", word("metal-Cu-et")));
        assert!(fault.contains("did you mean \"metal-Cu-eta\"?"), "{fault}");
    }

    #[test]
    fn invalid_colours_are_refused() {
        for (kind, numbers) in [
            ("rgb", vec![0.1, 0.2]),
            ("rgb", vec![0.1, -0.2, 0.3]),
            ("rgb", vec![0.1, 1e300, 0.3]),
            ("blackbody", vec![0.0]),
            ("blackbody", vec![1.0, 2.0, 3.0]),
            ("spectrum", vec![400.0, 1.0]),
            ("spectrum", vec![400.0, 1.0, 390.0, 1.0]),
            ("spectrum", vec![400.0, 1.0, 500.0, -0.1]),
            ("spectrum", vec![900.0, 1.0, 1000.0, 1.0]),
            ("spectrum", vec![0.4, 1.0, 0.7, 1.0]),
            ("spectrum", vec![400.0, 1.0, 500.0]),
            ("float", vec![-1.0]),
            ("point3", vec![1.0, 2.0, 3.0]),
        ] {
            let fault = refusal(&given(kind, Values::Numbers(numbers.clone())));
            assert!(fault.starts_with("test.pbrt:2:3: "), "{kind} {numbers:?}: {fault}");
        }
    }
}
