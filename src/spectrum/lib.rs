//! Spectra and their colours.
//!
//! Without the effect `spectra`, the renderer carries linear sRGB. This crate converts the spectra of a
//! scene by the CIE's standard observer of 1931: reflectances are illuminated by daylight (D65), lights
//! have their own colour. Integrals are sums over whole nanometres from 360 to 830, as in pbrt-v4. With
//! the effect, paths carry the wavelengths of a [set](WAVELENGTH_SETS), and colours become spectra.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

mod primaries;

mod bands;
mod blackbody;
mod buckets;
mod camera_matrices;
mod camera_sensor;
mod camera_tables;
mod colour;
mod colour_checker;
mod colour_difference;
mod colour_space;
mod fluorescent;
mod glass;
mod illuminant;
mod index_tables;
mod metal;
mod named;
mod observer;
mod uplift;
mod wavelength_sets;

use std::sync::Arc;

pub use bands::{
    BAND_RANGE, BANDS, BANDS_PER_RAY, LightBand, Passband, bands, bands_of_ray, hero_band,
};
pub use blackbody::blackbody;
pub use buckets::{BucketShares, Buckets};
pub use camera_sensor::{CameraResponse, CameraSensor, CameraTableError};
pub use colour::Colour;
pub use colour_checker::colour_checker;
pub use colour_difference::{VISIBLE_DIFFERENCE, ciede2000, lab_from_srgb};
pub use colour_space::{ColourSpace, srgb_from_xyz, white_balance, xyz_from_srgb};
pub use glass::{
    Absorption, C_LINE, CatalogueGlass, D_LINE, F_LINE, Formula, Glass, GlassError, GlassLibrary,
    GlassMatch, IndexRangeError, InternalTransmittance, find_glass, likely_glass, parse_agf,
    suggest_glass,
};
pub use illuminant::{D50, d_illuminant, d65, daylight};
pub use metal::{ChannelMetal, fit_metal, fresnel, metal_reflectance};
pub use named::{named_spectrum, spectrum_names};
pub use observer::{VISIBLE, colour_matching};
pub use primaries::{Primaries, adapt};
pub use uplift::{uplift_matrix, uplift_reflectance, uplift_unbounded};
pub use wavelength_sets::{
    BandSpectrum, WAVELENGTH_SETS, WAVELENGTHS, WAVELENGTHS_PER_PATH, WavelengthBand, band_shares,
    bands_of_set, lens_bands, wavelength_bands, wavelength_set,
};

use observer::{LUMINOSITY, daylight_at, integrate};

/// A quantity as a function of wavelength.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same value at every wavelength.
    Constant(f64),
    /// Pairs of a wavelength (nm), ascending, and a value; linear between them, 0 beyond.
    Samples(Arc<[[f64; 2]]>),
    /// Radiance of a black body; its maximum is 1.
    Blackbody {
        /// Temperature (K).
        kelvin: f64,
    },
}

/// Error of samples whose wavelengths do not ascend.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the wavelength {after} nm after {before} nm")]
pub struct UnorderedWavelengths {
    /// A wavelength (nm).
    pub before: f64,
    /// The next wavelength (nm), which is not longer.
    pub after: f64,
}

/// Returns the integral of the luminosity function over the wavelength (nm).
pub fn luminosity_integral() -> f64 {
    *LUMINOSITY
}

impl Spectrum {
    /// Creates a spectrum from pairs of a wavelength (nm) and a value.
    ///
    /// # Errors
    /// Returns an error if the wavelengths do not ascend.
    pub fn samples(samples: Vec<[f64; 2]>) -> Result<Self, UnorderedWavelengths> {
        let pair = samples.array_windows().find(|[[before, _], [after, _]]| {
            // A NaN is out of order, too.
            !matches!(before.partial_cmp(after), Some(std::cmp::Ordering::Less))
        });
        match pair {
            Some(&[[before, _], [after, _]]) => Err(UnorderedWavelengths { before, after }),
            None => Ok(Self::Samples(samples.into())),
        }
    }

    /// Creates a spectrum from entries that are known to be in order.
    fn tabulated(entries: impl Iterator<Item = [f64; 2]>) -> Self {
        Self::Samples(entries.collect())
    }

    /// Returns the value at a wavelength (nm).
    pub fn at(&self, nm: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Samples(samples) => match samples[..] {
                [[first, _], .., [last, _]] if nm < first || nm > last => 0.0,
                _ => interpolate(samples, nm),
            },
            Self::Blackbody { kelvin } => blackbody::relative_radiance(nm, *kelvin),
        }
    }

    /// Returns the value at a wavelength (nm), with the first and last sample beyond the ends: the
    /// rule for refractive indices.
    pub fn index_at(&self, nm: f64) -> f64 {
        match self {
            Self::Samples(samples) => interpolate(samples, nm),
            other => other.at(nm),
        }
    }

    /// Returns the tristimulus values X, Y, Z; the constant 1 has Y = 1.
    pub fn to_xyz(&self) -> [f64; 3] {
        integrate(|nm| self.at(nm)).map(|sum| sum / *LUMINOSITY)
    }

    /// Returns linear sRGB of the integral over wavelengths in nm, weighted by the colour-matching
    /// functions: that of [`Self::to_xyz`] times [`luminosity_integral`].
    pub fn integrated_rgb(&self) -> [f64; 3] {
        srgb_from_xyz(integrate(|nm| self.at(nm)))
    }

    /// Returns the linear sRGB of a surface with this reflectance, in daylight (D65): a constant
    /// becomes a grey of that value. Channels below 0, outside the gamut, become 0.
    pub fn reflectance(&self) -> [f32; 3] {
        self.in_daylight().map(|c| c.max(0.0) as f32)
    }

    /// Returns the linear sRGB of a surface with this reflectance, in daylight (D65), with channels below 0 outside the
    /// gamut.
    pub fn in_daylight(&self) -> [f64; 3] {
        srgb_from_xyz(integrate(|nm| self.at(nm) * daylight_at(nm)))
    }

    /// Returns the linear sRGB of a light of this spectrum, scaled to luminance 1.
    ///
    /// This is pbrt-v4's rule for every `L` and `I`. A light divides its spectrum by its luminance
    /// (`SpectrumToPhotometric`), and a film with the default sensor records the luminance of the
    /// incident light, without a constant:
    ///
    /// - `spectrum` and `blackbody`: only the chromaticity counts; the luminance is 1 times
    ///   `scale`. This function computes it.
    /// - `rgb`: the divisor is the luminance of the colour space's white alone, so that (1, 1, 1)
    ///   is the white of the space: [`ColourSpace::light`].
    /// - neither: the white of the colour space: [`ColourSpace::light`] of (1, 1, 1).
    /// - an image: its colours, unchanged.
    ///
    /// Then `scale` multiplies the colour, and after it the following factors, if their parameters
    /// are above 0:
    ///
    /// - `power` of a point, spot or goniometric light: power / (power of a light of intensity 1):
    ///   4 pi; 2 pi ((1 - cos s) + (cos s - cos e) / 2) with the falloff from s to e; 4 pi times
    ///   the mean of the image. The colour is NOT divided by its own luminance again, except for
    ///   projection lights, for which the luminance of the image counts.
    /// - `power` of an area light: power / (pi x area x sides); the mean luminance of an image is a
    ///   further divisor.
    /// - `illuminance` of a distant light: illuminance; of an infinite light without an image:
    ///   illuminance / pi; with one: illuminance / (illuminance by the image's upper half, z > 0).
    ///
    /// Channels below 0, outside the gamut, become 0.
    pub fn light(&self) -> [f32; 3] {
        let xyz = self.to_xyz();
        // Light outside the visible range has no chromaticity.
        if !(xyz[1] > 0.0 && xyz[1].is_finite()) {
            return [0.0; 3];
        }
        srgb_from_xyz(xyz.map(|v| v / xyz[1])).map(|c| c.max(0.0) as f32)
    }

    /// Returns the values of a light of this spectrum by wavelength, relative to daylight; its luminance
    /// is that of [`Self::light`].
    pub fn light_by_wavelength(&self) -> BandSpectrum {
        let luminance = self.to_xyz()[1];
        match luminance > 0.0 && luminance.is_finite() {
            true => BandSpectrum::light(self).scaled((1.0 / luminance) as f32),
            false => BandSpectrum::of(|_| 0.0),
        }
    }

    fn with_luminance_one(self) -> Self {
        let luminance = self.to_xyz()[1];
        match self {
            Self::Samples(samples) => {
                Self::tabulated(samples.iter().map(|[nm, value]| [*nm, value / luminance]))
            }
            other => other,
        }
    }
}

/// Returns the linear sRGB of one unit of reflectance at each of some ascending wavelengths (nm),
/// linear between them and constant beyond, in daylight (D65). Their sum is white.
pub fn daylight_weights(wavelengths: &[f64]) -> Vec<[f64; 3]> {
    let mut weights = vec![[0.0; 3]; wavelengths.len()];
    for nm in (VISIBLE[0]..=VISIBLE[1]).map(f64::from) {
        let daylight = daylight_at(nm);
        let light = srgb_from_xyz(colour_matching(nm).map(|v| v * daylight));
        for (i, share) in neighbours(wavelengths, nm) {
            (0..3).for_each(|c| weights[i][c] += share * light[c]);
        }
    }
    weights
}

/// Returns the indices of the entries of an ascending list on both sides of a wavelength (nm), and their shares in
/// its value; the nearer end alone counts beyond.
fn neighbours(wavelengths: &[f64], nm: f64) -> impl Iterator<Item = (usize, f64)> {
    let after = wavelengths.partition_point(|&wavelength| wavelength <= nm);
    let last = wavelengths.len().checked_sub(1);
    let pair = last.map(|last| match after {
        0 => [(0, 1.0), (0, 0.0)],
        _ if after > last => [(last, 1.0), (last, 0.0)],
        _ => {
            let share =
                (nm - wavelengths[after - 1]) / (wavelengths[after] - wavelengths[after - 1]);
            [(after - 1, 1.0 - share), (after, share)]
        }
    });
    pair.into_iter().flatten().filter(|(_, share)| *share != 0.0)
}

fn interpolate(samples: &[[f64; 2]], nm: f64) -> f64 {
    let after = samples.partition_point(|[wavelength, _]| *wavelength <= nm);
    match (samples.get(after.wrapping_sub(1)), samples.get(after)) {
        (Some([low, value]), Some([high, next])) => {
            value + (nm - low) / (high - low) * (next - value)
        }
        (Some([_, value]), None) | (None, Some([_, value])) => *value,
        (None, None) => 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn daylight_is_white_and_a_grey_surface_is_grey() {
        for channel in d65().light() {
            assert!((channel - 1.0).abs() < 1e-6);
        }
        for grey in [0.0, 0.18, 1.0] {
            for channel in Spectrum::Constant(grey).reflectance() {
                assert!((f64::from(channel) - grey).abs() < 1e-6);
            }
        }
    }

    #[test]
    fn a_light_has_luminance_one_for_any_scale_of_its_spectrum() {
        let spectrum = |k: f64| Spectrum::tabulated([[400.0, k], [700.0, 3.0 * k]].into_iter());
        let [r, g, b] = spectrum(1.0).light().map(f64::from);
        assert!((0.2126 * r + 0.7152 * g + 0.0722 * b - 1.0).abs() < 1e-3);
        assert!(r > g && g > b);
        let strong = spectrum(1e3).light().map(f64::from);
        assert!((strong[0] - r).abs() < 1e-5 && (strong[2] - b).abs() < 1e-5);
        assert_eq!(Spectrum::Constant(0.0).light(), [0.0; 3]);
        assert_eq!(blackbody(1.0).light(), [0.0; 3]);
    }

    #[test]
    fn the_weights_of_wavelengths_are_those_of_a_spectrum() {
        let (wavelengths, values) = ([420.0, 500.0, 610.0, 700.0], [0.2, 0.9, 0.4, 0.6]);
        let weights = daylight_weights(&wavelengths);
        let sum = |values: &[f64]| {
            [0, 1, 2].map(|c| weights.iter().zip(values).map(|(w, v)| w[c] * v).sum::<f64>())
        };
        for channel in sum(&[1.0; 4]) {
            assert!((channel - 1.0).abs() < 1e-9);
        }
        let pairs = wavelengths.into_iter().zip(values);
        let ends = [[360.0, 0.2]].into_iter().chain(pairs.map(|(nm, v)| [nm, v]));
        let spectrum = Spectrum::tabulated(ends.chain([[830.0, 0.6]]));
        for (found, expected) in sum(&values).into_iter().zip(spectrum.reflectance()) {
            assert!((found - f64::from(expected)).abs() < 1e-5);
        }
    }

    #[test]
    fn samples_are_linear_between_and_zero_beyond() {
        let spectrum = Spectrum::samples(vec![[400.0, 1.0], [500.0, 3.0], [600.0, 2.0]]).unwrap();
        for (nm, value) in [(399.0, 0.0), (400.0, 1.0), (450.0, 2.0), (600.0, 2.0), (601.0, 0.0)] {
            assert_eq!(spectrum.at(nm), value);
        }
        assert_eq!([spectrum.index_at(300.0), spectrum.index_at(900.0)], [1.0, 2.0]);
        let disorder = Spectrum::samples(vec![[400.0, 1.0], [400.0, 2.0]]);
        assert_eq!(disorder, Err(UnorderedWavelengths { before: 400.0, after: 400.0 }));
        assert!(Spectrum::samples(vec![[400.0, 1.0], [f64::NAN, 2.0]]).is_err());
    }
}
