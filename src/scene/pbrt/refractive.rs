//! Refractive indices of metals and glasses, by name or by number.

use super::SceneError;
use super::params::{Param, Values};
use super::surfaces::Recipe;
use crate::scene::{Metal, Texture};
use crate::source::hint;

/// Metals that pbrt-v4 knows by name: real and imaginary part of the refractive index for
/// red, green and blue, from the measurements that refractiveindex.info collects (Johnson &
/// Christy 1972, Rakic 1995, Palik 1985).
const METALS: &[(&str, [f32; 3], [f32; 3])] = &[
    ("Ag", [0.155_265, 0.116_723, 0.138_381], [4.828_37, 3.122_5, 2.147_03]),
    ("Al", [1.657_46, 0.880_369, 0.521_229], [9.223_87, 6.269_52, 4.837_01]),
    ("Au", [0.143_119, 0.374_957, 1.442_48], [3.983_16, 2.385_72, 1.603_21]),
    ("Cu", [0.200_438, 0.924_033, 1.102_21], [3.912_95, 2.452_85, 2.142_19]),
    ("CuZn", [0.444, 0.527, 1.094], [3.695, 2.765, 1.829]),
    ("MgO", [1.735, 1.741, 1.753], [0.0, 0.0, 0.0]),
    ("TiO2", [2.585, 2.659, 2.84], [0.0, 0.0, 0.0]),
];

/// Glasses that pbrt-v4 knows by name: index at the d line, 587.6 nm (Schott's catalogue).
const GLASSES: &[(&str, f32)] = &[
    ("glass-BK7", 1.516_8),
    ("glass-BAF10", 1.670_03),
    ("glass-FK51A", 1.486_56),
    ("glass-LASF9", 1.850_25),
    ("glass-F5", 1.672_7),
    ("glass-SF5", 1.672_7),
    ("glass-F10", 1.728_25),
    ("glass-SF10", 1.728_25),
    ("glass-F11", 1.784_72),
    ("glass-SF11", 1.784_72),
];

/// The d line of helium, nm.
const D_LINE: f64 = 587.56;

impl Recipe<'_> {
    /// The metal that these parameters describe; copper where nothing is given.
    pub(super) fn metal(&mut self, eta: &str, k: &str) -> Result<Metal, SceneError> {
        let indices = self.params.find(eta).or(self.params.find(k));
        if let Some(reflectance) =
            self.library.colour_or_texture(self.params, "reflectance", self.notices)?
        {
            if indices.is_some() {
                let found = format!("a metal with reflectance and with {eta} or {k}");
                return Err(self.params.refuse("reflectance", found, "expected one or the other"));
            }
            return Ok(Metal::Reflectance(reflectance));
        }
        Ok(Metal::Index { eta: self.part(eta, "eta")?, k: self.part(k, "k")? })
    }

    /// One part of a metal's index: a name such as "metal-Cu-eta", a colour or a texture.
    fn part(&mut self, name: &str, part: &str) -> Result<Texture, SceneError> {
        let of = |metal: &str| {
            let (_, eta, k) = METALS.iter().find(|(known, ..)| *known == metal)?;
            Some(Texture::Constant(if part == "eta" { *eta } else { *k }))
        };
        if let Some(word) = self.params.find(name).and_then(named) {
            let metal = word.strip_prefix("metal-").and_then(|rest| {
                let (metal, suffix) = rest.rsplit_once('-')?;
                (suffix == part).then_some(metal)
            });
            if let Some(texture) = metal.and_then(of) {
                return Ok(texture);
            }
        }
        let given = self.library.colour_or_texture(self.params, name, self.notices)?;
        Ok(given.or_else(|| of("Cu")).unwrap_or(Texture::Constant([1.0; 3])))
    }

    /// The index of a dielectric: the first of these parameters that is given, or 1.5.
    pub(super) fn index(&mut self, names: &[&str]) -> Result<f32, SceneError> {
        let Some(param) = names.iter().find_map(|name| self.params.find(name)) else {
            return Ok(1.5);
        };
        if let Some(word) = named(param) {
            if let Some((_, index)) = GLASSES.iter().find(|(known, _)| *known == word) {
                return Ok(*index);
            }
            let hint = hint(word, GLASSES.iter().map(|(known, _)| *known));
            let found = format!("no glass \"{word}\"{hint}");
            return Err(self.params.refuse(&param.name, found, "expected a name or a number"));
        }
        let index = match (&param.values, param.kind.as_str()) {
            (Values::Numbers(numbers), "spectrum") => spectrum_at(numbers, D_LINE),
            (Values::Texts(_), "texture") => {
                let what = format!("a texture for \"{}\"", param.name);
                self.notices.instead(&param.at, &what, "1.5 is used");
                return Ok(1.5);
            }
            _ => self.params.float(&param.name, 1.5)?,
        };
        if index > 0.0 {
            return Ok(index as f32);
        }
        let found = format!("a refractive index of {index}");
        Err(self.params.refuse(&param.name, found, "expected more than 0"))
    }
}

/// The name of a spectrum, where a parameter gives one.
fn named(param: &Param) -> Option<&str> {
    match (&param.values, param.kind.as_str()) {
        (Values::Texts(texts), "spectrum") => texts.first().map(String::as_str),
        _ => None,
    }
}

/// A spectrum of pairs, wavelength in nm and value, at a wavelength; linear between them.
fn spectrum_at(numbers: &[f64], wavelength: f64) -> f64 {
    let pairs = numbers.as_chunks::<2>().0;
    let after = pairs.partition_point(|[at, _]| *at < wavelength);
    match (after.checked_sub(1).and_then(|i| pairs.get(i)), pairs.get(after)) {
        (Some([x0, y0]), Some([x1, y1])) => y0 + (y1 - y0) * (wavelength - x0) / (x1 - x0),
        (Some([_, value]), None) | (None, Some([_, value])) => *value,
        (None, None) => f64::NAN,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn spectra_are_linear_between_their_points_and_flat_beyond() {
        let spectrum = [400.0, 1.6, 500.0, 1.5, 700.0, 1.4];
        for (wavelength, expected) in [(300.0, 1.6), (450.0, 1.55), (600.0, 1.45), (900.0, 1.4)] {
            let found = spectrum_at(&spectrum, wavelength);
            assert!((found - expected).abs() < 1e-12, "{wavelength}: {found}");
        }
        assert!(spectrum_at(&[], 500.0).is_nan());
    }
}
