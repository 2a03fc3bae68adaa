//! Spectra, and the colours that they are.
//!
//! The renderer carries linear sRGB. What a scene says in spectra becomes such a colour here, under
//! the CIE's standard observer of 1931: what reflects as it looks in daylight (D65), what shines
//! as it looks by itself. Integrals are sums over whole nanometres from 360 to 830, as pbrt-v4's.

mod bands;
mod cie;
mod fluorescent;
mod illuminant;
mod material;
mod metal;
mod named;
mod rgb;

use std::sync::{Arc, LazyLock};

pub use bands::{BANDS, LightBand, Passband, RANGE, SHARING, bands, hero, sharing};
pub use cie::{VISIBLE, matching};
pub use illuminant::{d_illuminant, d65, daylight};
pub use metal::{ChannelMetal, fresnel, metal, metal_reflectance};
pub use named::{named, names};
pub use rgb::{ColourSpace, srgb_from_xyz, white_balance, xyz_from_srgb};

/// Some quantity at every wavelength.
#[derive(Clone, Debug, PartialEq)]
pub enum Spectrum {
    /// The same everywhere.
    Constant(f64),
    /// Wavelengths, nm, ascending, with their values; linear between them, 0 beyond.
    Samples(Arc<[[f64; 2]]>),
    /// Radiance of a black body, 1 where it is greatest.
    Blackbody {
        /// Temperature, K.
        kelvin: f64,
    },
}

/// Wavelengths that do not ascend.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("the wavelength {after} nm after {before} nm")]
pub struct Disorder {
    /// A wavelength, nm.
    pub before: f64,
    /// The next one, which is not longer.
    pub after: f64,
}

/// A black body of a temperature, K.
pub fn blackbody(kelvin: f64) -> Spectrum {
    Spectrum::Blackbody { kelvin }
}

/// Planck's law: spectral radiance, W / (m^2 sr m), at a wavelength, nm, and a temperature, K.
fn planck(nm: f64, kelvin: f64) -> f64 {
    // CODATA 2010, as pbrt-v4 has them.
    let (c, h, k) = (299_792_458.0, 6.626_069_57e-34, 1.380_648_8e-23);
    let m = nm * 1e-9;
    2.0 * h * c * c / (m.powi(5) * (h * c / (m * k * kelvin)).exp_m1())
}

/// The sum over the visible wavelengths of a quantity times the three matching functions.
fn integrate(quantity: impl Fn(f64) -> f64) -> [f64; 3] {
    integrate_over([0.0, f64::INFINITY], quantity)
}

/// The same over wavelengths from the first of two to before the second, nm.
fn integrate_over([first, end]: [f64; 2], quantity: impl Fn(f64) -> f64) -> [f64; 3] {
    let mut sums = [0.0; 3];
    let within = |nm: &f64| (first..end).contains(nm);
    for nm in (VISIBLE[0]..=VISIBLE[1]).map(f64::from).filter(within) {
        let value = quantity(nm);
        for (sum, weight) in sums.iter_mut().zip(matching(nm)) {
            *sum += value * weight;
        }
    }
    sums
}

/// The integral of the observer's luminosity, nm: 106.857.
static LUMINOSITY: LazyLock<f64> = LazyLock::new(|| integrate(|_| 1.0)[1]);

/// Daylight, nanometre by nanometre, such that a perfect reflector has luminance 1.
static DAYLIGHT: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let d65 = d65();
    let luminance = integrate(|nm| d65.at(nm))[1];
    (VISIBLE[0]..=VISIBLE[1]).map(|nm| d65.at(f64::from(nm)) / luminance).collect()
});

/// Daylight at a visible wavelength.
fn daylight_at(nm: f64) -> f64 {
    DAYLIGHT[(nm as u32 - VISIBLE[0]) as usize]
}

impl Spectrum {
    /// A spectrum of samples: wavelengths, nm, and values.
    ///
    /// # Errors
    /// Where the wavelengths do not ascend.
    pub fn samples(samples: Vec<[f64; 2]>) -> Result<Self, Disorder> {
        let pair = samples.array_windows().find(|[[before, _], [after, _]]| {
            // A NaN ascends neither.
            !matches!(before.partial_cmp(after), Some(std::cmp::Ordering::Less))
        });
        match pair {
            Some(&[[before, _], [after, _]]) => Err(Disorder { before, after }),
            None => Ok(Self::Samples(samples.into())),
        }
    }

    /// A spectrum from a table of this program.
    fn tabulated(entries: impl Iterator<Item = [f64; 2]>) -> Self {
        Self::Samples(entries.collect())
    }

    /// The value at a wavelength, nm.
    pub fn at(&self, nm: f64) -> f64 {
        match self {
            Self::Constant(value) => *value,
            Self::Samples(samples) => match samples[..] {
                [[first, _], .., [last, _]] if nm < first || nm > last => 0.0,
                _ => interpolate(samples, nm),
            },
            Self::Blackbody { kelvin } if *kelvin > 0.0 => {
                // Wien's displacement law.
                planck(nm, *kelvin) / planck(2.897_772_1e-3 / kelvin * 1e9, *kelvin)
            }
            Self::Blackbody { .. } => 0.0,
        }
    }

    /// The value at a wavelength, nm, where samples go on with their first and last value. It is
    /// what is meant by the refractive index of a medium.
    pub fn index_at(&self, nm: f64) -> f64 {
        match self {
            Self::Samples(samples) => interpolate(samples, nm),
            other => other.at(nm),
        }
    }

    /// The tristimulus values X, Y, Z; the constant 1 has Y = 1.
    pub fn to_xyz(&self) -> [f64; 3] {
        integrate(|nm| self.at(nm)).map(|sum| sum / *LUMINOSITY)
    }

    /// The linear sRGB of a surface that reflects this share of the light, in daylight (D65): a
    /// constant is grey of that constant. What the gamut of sRGB cannot hold has channels of 0.
    pub fn reflectance(&self) -> [f32; 3] {
        let xyz = integrate(|nm| self.at(nm) * daylight_at(nm));
        srgb_from_xyz(xyz).map(|c| c.max(0.0) as f32)
    }

    /// The linear sRGB of a light of this spectrum, of luminance 1 whatever the spectrum's own.
    ///
    /// This is pbrt-v4's rule for every `L` and `I`. A light divides its spectrum by its luminance
    /// (`SpectrumToPhotometric`), and a film with the default sensor records the luminance of what
    /// falls in, without a constant:
    ///
    /// - `spectrum` and `blackbody`: only the chromaticity counts; the luminance is 1 times `scale`.
    ///   This function.
    /// - `rgb`: divided by the luminance of the colour space's white alone, so the colour counts as
    ///   it is, (1, 1, 1) is the white of the space. [`ColourSpace::light`].
    /// - nothing: the white of the colour space: [`ColourSpace::light`] of (1, 1, 1).
    /// - an image: its colours as they are.
    ///
    /// Then `scale` multiplies, and after it, where they are given and above 0,
    ///
    /// - `power` of a point, spot, goniometric light: by power / (that of a light of intensity 1):
    ///   4 pi; 2 pi ((1 - cos s) + (cos s - cos e) / 2) with the falloff from s to e; 4 pi times
    ///   the mean of the image. The colour is NOT divided by its own luminance again, except for
    ///   projection lights, where the image's luminance counts.
    /// - `power` of an area light: by power / (pi x area x sides); with an image, its mean luminance
    ///   is a factor of the divisor.
    /// - `illuminance` of a distant light: by illuminance; of an infinite light without image: by
    ///   illuminance / pi; with one: by illuminance / (that of the image's upper half, z > 0).
    ///
    /// What the gamut of sRGB cannot hold has channels of 0.
    pub fn light(&self) -> [f32; 3] {
        let xyz = self.to_xyz();
        // Its own luminance must be visible at all.
        if !(xyz[1] > 0.0 && xyz[1].is_finite()) {
            return [0.0; 3];
        }
        srgb_from_xyz(xyz.map(|v| v / xyz[1])).map(|c| c.max(0.0) as f32)
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

    fn chromaticity(spectrum: &Spectrum) -> [f64; 2] {
        let [x, y, z] = spectrum.to_xyz();
        [x / (x + y + z), y / (x + y + z)]
    }

    fn assert_at(spectrum: &Spectrum, [x, y]: [f64; 2], within: f64, what: &str) {
        let found = chromaticity(spectrum);
        let off = (found[0] - x).abs().max((found[1] - y).abs());
        assert!(off < within, "{what}: {found:?}, published {x} {y}");
    }

    #[test]
    fn the_observer_has_his_published_luminosity() {
        // pbrt-v4's constant, from the table in steps of 1 nm.
        assert!((*LUMINOSITY - 106.856895).abs() < 3e-4, "{}", *LUMINOSITY);
        assert_eq!(matching(359.9), [0.0; 3]);
        for (found, published) in matching(555.0).into_iter().zip([0.5120501, 1.0, 0.00575]) {
            assert!((found - published).abs() < 1e-8);
        }
    }

    #[test]
    fn black_bodies_are_on_the_planckian_locus() {
        // Wyszecki & Stiles 1982, table 1(3.11), whose second constant is 14388 um K.
        let published =
            [(2000.0, [0.5267, 0.4133]), (3000.0, [0.4369, 0.4041]), (6500.0, [0.3135, 0.3236])];
        for (kelvin, xy) in published {
            assert_at(&blackbody(kelvin), xy, 2e-4, "a black body");
        }
        assert_at(&blackbody(6504.0), [0.3134, 0.3235], 2e-4, "a black body of 6504 K");
        assert!((blackbody(5000.0).at(2.897_772_1e6 / 5000.0) - 1.0).abs() < 1e-12);
        assert!(blackbody(5000.0).at(500.0) < 1.0 && blackbody(5000.0).at(650.0) < 1.0);
        assert_eq!(blackbody(0.0).at(500.0), 0.0);
    }

    #[test]
    fn illuminants_have_their_published_chromaticities() {
        // CIE 015:2018, tables 3 and 10.2; the Academy's white (SMPTE ST 2065-1).
        let published = [
            ("stdillum-A", [0.44758, 0.40745]),
            ("stdillum-D50", [0.34567, 0.35851]),
            ("stdillum-D65", [0.31272, 0.32903]),
            ("illum-acesD60", [0.32168, 0.33767]),
            ("stdillum-F1", [0.3131, 0.3371]),
            ("stdillum-F2", [0.3721, 0.3751]),
            ("stdillum-F3", [0.4091, 0.3941]),
            ("stdillum-F4", [0.4402, 0.4031]),
            ("stdillum-F5", [0.3138, 0.3452]),
            ("stdillum-F6", [0.3779, 0.3882]),
            ("stdillum-F7", [0.3129, 0.3292]),
            ("stdillum-F8", [0.3458, 0.3586]),
            ("stdillum-F9", [0.3741, 0.3727]),
            ("stdillum-F10", [0.3458, 0.3588]),
            ("stdillum-F11", [0.3805, 0.3769]),
            ("stdillum-F12", [0.4370, 0.4042]),
        ];
        for (name, xy) in published {
            let spectrum = named(name).unwrap();
            // The CIE sums the lamps in steps of 5 nm, and their lines make that a difference.
            let mut sums = [0.0; 3];
            for nm in (VISIBLE[0]..=VISIBLE[1]).step_by(5).map(f64::from) {
                let weights = matching(nm);
                (0..3).for_each(|i| sums[i] += weights[i] * spectrum.at(nm));
            }
            let off = |i: usize| (sums[i] / sums.iter().sum::<f64>() - xy[i]).abs();
            assert!(off(0).max(off(1)) < 2e-4, "{name}: {sums:?}");
            assert_at(&spectrum, xy, 1e-3, name);
            assert!((spectrum.to_xyz()[1] - 1.0).abs() < 1e-9, "{name}");
        }
    }

    #[test]
    fn d65_is_the_published_table() {
        // CIE 015:2018, table 5.
        for (nm, value) in
            [(400.0, 82.7549), (450.0, 117.008), (560.0, 100.0), (600.0, 90.0062), (700.0, 71.6091)]
        {
            assert!((d65().at(nm) - value).abs() < 1e-3, "{nm}: {}", d65().at(nm));
        }
    }

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
    fn a_light_has_luminance_one_however_strong_its_spectrum() {
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
    fn samples_are_linear_between_and_nothing_beyond() {
        let spectrum = Spectrum::samples(vec![[400.0, 1.0], [500.0, 3.0], [600.0, 2.0]]).unwrap();
        for (nm, value) in [(399.0, 0.0), (400.0, 1.0), (450.0, 2.0), (600.0, 2.0), (601.0, 0.0)] {
            assert_eq!(spectrum.at(nm), value);
        }
        assert_eq!([spectrum.index_at(300.0), spectrum.index_at(900.0)], [1.0, 2.0]);
        let disorder = Spectrum::samples(vec![[400.0, 1.0], [400.0, 2.0]]);
        assert_eq!(disorder, Err(Disorder { before: 400.0, after: 400.0 }));
        assert!(Spectrum::samples(vec![[400.0, 1.0], [f64::NAN, 2.0]]).is_err());
    }
}
