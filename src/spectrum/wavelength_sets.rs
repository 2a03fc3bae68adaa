//! Sets of wavelengths that share a path.
//!
//! The visible range is divided into [`WAVELENGTHS`] bands. A path carries one value for each band of its
//! set: three of them, far apart in the spectrum, in the columns that hold red, green and blue otherwise.
//! The bands are narrow where the film is sensitive to daylight, so that all sets are nearly white: the
//! relative variance of the film's response to white over the sets is 0.03 in red, 0.04 in green and 0.03
//! in blue. Four bands at even distances have 0.03, 0.003 and 0.09.

use std::sync::LazyLock;

use super::bands::{BAND_RANGE, LightBand};
use super::observer::{VISIBLE, colour_matching, daylight_at};
use super::{LUMINOSITY, Spectrum, neighbours, srgb_from_xyz};

/// Number of wavelengths that share a path.
pub const WAVELENGTHS_PER_PATH: usize = 3;

/// Number of sets. As many consecutive samples of a pixel, well distributed, take each set once.
///
/// A picture is a sum over all bands, within which spectra have their means. With 64 sets, pigments whose
/// reflectance rises by 2 % in a nanometre have the right colour under fluorescent lamps within 0.5 % in
/// every channel; with 32 within 2.6 %.
pub const WAVELENGTH_SETS: usize = 64;

/// Number of bands of all sets.
pub const WAVELENGTHS: usize = WAVELENGTHS_PER_PATH * WAVELENGTH_SETS;

/// Steps of a nanometre at which bands may end.
const STEPS_PER_NM: u32 = 16;

/// Weight of the range as a whole, beside the film's sensitivity, in the density of bands: light that
/// daylight has little of has bands too.
const EVEN_SHARE: f64 = 0.2;

/// A band of the visible range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WavelengthBand {
    /// Shortest and longest wavelength (nm).
    pub range: [f64; 2],
    /// Linear sRGB of the daylight (D65) in the band; the sum over all bands is white.
    pub response: [f64; 3],
    /// Mean wavelength (nm), by the size of the response.
    pub centre: f64,
}

/// Returns the bands of a set, in ascending order.
#[inline]
pub fn bands_of_set(set: usize) -> [usize; WAVELENGTHS_PER_PATH] {
    std::array::from_fn(|i| set + i * WAVELENGTH_SETS)
}

/// Returns the set of a sample from a number in [0, 1).
#[inline]
pub fn wavelength_set(u: f32) -> usize {
    ((u * WAVELENGTH_SETS as f32) as usize).min(WAVELENGTH_SETS - 1)
}

/// Returns all bands, in ascending order.
pub fn wavelength_bands() -> &'static [WavelengthBand] {
    &TABLE.bands
}

/// Returns the bands as those of a lens with dispersion. It is traced at no wavelength beyond
/// [`BAND_RANGE`], where many catalogues of glass end.
pub fn lens_bands() -> Vec<LightBand> {
    let of = |band: &WavelengthBand| LightBand {
        wavelength: band.centre.clamp(BAND_RANGE[0], BAND_RANGE[1]),
        response: band.response.map(|r| r * WAVELENGTHS as f64),
    };
    wavelength_bands().iter().map(of).collect()
}

/// Values of a quantity in all bands.
#[derive(Clone, Debug, PartialEq)]
pub struct BandSpectrum(Box<[f32; WAVELENGTHS]>);

impl BandSpectrum {
    /// The means of a quantity over the bands, weighted by daylight. It counts by its values at whole
    /// nanometres, linear between them.
    pub fn of(value: impl Fn(f64) -> f64) -> Self {
        Self::ratios(|share| value(share.nm) * share.daylight)
    }

    /// The light of a spectrum relative to daylight, whose value is 1 in every band.
    pub fn light(spectrum: &Spectrum) -> Self {
        Self::ratios(|share| spectrum.at(share.nm) / *LUMINOSITY * share.width)
    }

    /// The sums of a quantity over the bands, divided by that of daylight.
    fn ratios(quantity: impl Fn(&Share) -> f64) -> Self {
        let mut sums = [[0.0; 2]; WAVELENGTHS];
        for share in &TABLE.shares {
            sums[share.band][0] += quantity(share);
            sums[share.band][1] += share.daylight;
        }
        Self(Box::new(sums.map(|[sum, daylight]| (sum / daylight) as f32)))
    }

    /// The values of a function of the band.
    pub fn from_bands(value: impl Fn(usize) -> f32) -> Self {
        Self(Box::new(std::array::from_fn(value)))
    }

    /// The values times a factor.
    pub fn scaled(&self, factor: f32) -> Self {
        self.map(|value| factor * value)
    }

    /// The product with other values.
    pub fn times(&self, other: &Self) -> Self {
        Self(Box::new(std::array::from_fn(|band| self.0[band] * other.0[band])))
    }

    /// A function of the values.
    pub fn map(&self, function: impl Fn(f32) -> f32) -> Self {
        Self(Box::new(self.0.map(function)))
    }

    /// Returns the values at the wavelengths of a set.
    pub fn in_set(&self, set: usize) -> [f32; WAVELENGTHS_PER_PATH] {
        bands_of_set(set).map(|band| self.0[band])
    }

    /// Returns the values of all bands.
    pub fn values(&self) -> &[f32; WAVELENGTHS] {
        &self.0
    }

    /// Returns linear sRGB of light with these values relative to daylight, or of daylight that a surface
    /// of this reflectance reflects.
    pub fn to_rgb(&self) -> [f64; 3] {
        let mut rgb = [0.0; 3];
        for (value, band) in self.0.iter().zip(wavelength_bands()) {
            for (sum, response) in rgb.iter_mut().zip(band.response) {
                *sum += f64::from(*value) * response;
            }
        }
        rgb
    }
}

/// Returns for each band which of some ascending wavelengths (nm) count in its mean, by their index, and their
/// shares. A quantity is linear between them and constant beyond.
pub fn band_shares(wavelengths: &[f64]) -> Vec<Vec<(usize, f64)>> {
    let mut sums = vec![Vec::new(); WAVELENGTHS];
    for Share { nm, band, daylight, .. } in &TABLE.shares {
        for (i, share) in neighbours(wavelengths, *nm) {
            let known: &mut Vec<(usize, f64)> = &mut sums[*band];
            match known.iter_mut().find(|(other, _)| *other == i) {
                Some((_, sum)) => *sum += share * daylight,
                None => known.push((i, share * daylight)),
            }
        }
    }
    for shares in &mut sums {
        let all: f64 = shares.iter().map(|(_, share)| share).sum();
        shares.iter_mut().for_each(|(_, share)| *share /= all);
    }
    sums
}

/// Returns the integrals of a sensitivity at whole nanometres times daylight of luminance 1 over the bands.
pub(super) fn daylight_in_bands(sensitivity: impl Fn(f64) -> f64) -> Vec<f64> {
    let mut sums = vec![0.0; WAVELENGTHS];
    for Share { nm, band, daylight, .. } in &TABLE.shares {
        sums[*band] += sensitivity(*nm) * daylight;
    }
    sums
}

/// Share of the value at a whole nanometre in the integral over a band.
#[derive(Clone, Copy, Debug)]
struct Share {
    /// The wavelength (nm).
    nm: f64,
    /// Index of the band.
    band: usize,
    /// Weight of the value in the integral (nm).
    width: f64,
    /// The same of the value times daylight.
    daylight: f64,
}

/// A step of the visible range.
struct Step {
    /// Its middle (nm).
    nm: f64,
    /// Daylight there.
    daylight: f64,
    /// Index of the band.
    band: usize,
}

struct Table {
    bands: Vec<WavelengthBand>,
    shares: Vec<Share>,
}

static TABLE: LazyLock<Table> = LazyLock::new(|| {
    let count = (VISIBLE[1] - VISIBLE[0]) * STEPS_PER_NM;
    let width = 1.0 / f64::from(STEPS_PER_NM);
    let middle = |i: u32| f64::from(VISIBLE[0]) + width * (f64::from(i) + 0.5);
    let sensitivity =
        |i: u32| srgb_from_xyz(colour_matching(middle(i)).map(|v| v * daylight_between(middle(i))));
    let total = |channel: usize| (0..count).map(|i| sensitivity(i)[channel].abs()).sum::<f64>();
    let totals = [0, 1, 2].map(total);
    // Weights of red, green and blue that give the sets the least variance.
    let weighted = |i: u32| {
        let channels = [1.0, 0.5, 1.0].into_iter().zip(sensitivity(i)).zip(totals);
        channels.map(|((weight, channel), total)| weight * channel.abs() / total).sum::<f64>()
    };
    let wanted: Vec<f64> = (0..count).map(weighted).collect();
    let all: f64 = wanted.iter().sum();
    let even = EVEN_SHARE / f64::from(count);
    let (mut steps, mut reached) = (Vec::new(), 0.0);
    for (i, share) in (0..count).zip(&wanted) {
        let part = share / all + even;
        let band = ((reached + part / 2.0) / (1.0 + EVEN_SHARE) * WAVELENGTHS as f64) as usize;
        reached += part;
        let nm = middle(i);
        steps.push(Step { nm, daylight: daylight_between(nm), band: band.min(WAVELENGTHS - 1) });
    }
    Table { bands: bands_of(&steps), shares: shares_of(&steps) }
});

/// Returns the shares of whole nanometres in the integrals over these steps.
fn shares_of(steps: &[Step]) -> Vec<Share> {
    let step = 1.0 / f64::from(STEPS_PER_NM);
    let mut shares: Vec<Share> = Vec::new();
    for Step { nm, daylight, band } in steps {
        let t = nm - nm.floor();
        for (nm, weight) in [(nm.floor(), (1.0 - t) * step), (nm.floor() + 1.0, t * step)] {
            // Those of the last steps are at the end.
            let known = shares.iter_mut().rev().take(4).find(|s| s.nm == nm && s.band == *band);
            match known {
                Some(share) => {
                    share.width += weight;
                    share.daylight += weight * daylight;
                }
                None => {
                    let share =
                        Share { nm, band: *band, width: weight, daylight: weight * daylight };
                    shares.push(share);
                }
            }
        }
    }
    shares
}

/// Returns the bands that these steps are in.
fn bands_of(steps: &[Step]) -> Vec<WavelengthBand> {
    let half = 0.5 / f64::from(STEPS_PER_NM);
    let empty = WavelengthBand { range: [f64::INFINITY, 0.0], response: [0.0; 3], centre: 0.0 };
    let mut bands = vec![empty; WAVELENGTHS];
    let mut sizes = [0.0; WAVELENGTHS];
    for Step { nm, daylight, band } in steps {
        let WavelengthBand { range, response, centre } = &mut bands[*band];
        *range = [range[0].min(nm - half), range[1].max(nm + half)];
        let rgb = srgb_from_xyz(colour_matching(*nm).map(|v| v * daylight));
        (0..3).for_each(|c| response[c] += rgb[c]);
        let size: f64 = rgb.iter().map(|c| c.abs()).sum();
        *centre += size * nm;
        sizes[*band] += size;
    }
    for (band, size) in bands.iter_mut().zip(sizes) {
        band.centre /= size;
    }
    for channel in 0..3 {
        let sum: f64 = bands.iter().map(|band| band.response[channel]).sum();
        bands.iter_mut().for_each(|band| band.response[channel] /= sum);
    }
    bands
}

/// Returns daylight, linear between whole nanometres.
pub(super) fn daylight_between(nm: f64) -> f64 {
    let low = nm.floor();
    let high = (low + 1.0).min(f64::from(VISIBLE[1]));
    let t = nm - low;
    (1.0 - t) * daylight_at(low) + t * daylight_at(high)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::observer::integrate;
    use crate::{blackbody, named_spectrum};

    #[test]
    fn the_bands_cover_the_visible_range_and_daylight_is_white() {
        let bands = wavelength_bands();
        assert_eq!(bands.len(), WAVELENGTHS);
        assert_eq!([bands[0].range[0], bands[WAVELENGTHS - 1].range[1]], [360.0, 830.0]);
        for [before, after] in bands.array_windows() {
            assert_eq!(before.range[1], after.range[0]);
            assert!(before.range[0] < before.centre && before.centre < before.range[1]);
        }
        let day = BandSpectrum::light(&named_spectrum("stdillum-D65").expect("it is known"));
        for value in day.values() {
            assert!((value - 1.0).abs() < 2e-3, "{value}");
        }
        for channel in BandSpectrum::of(|_| 0.25).to_rgb() {
            assert!((channel - 0.25).abs() < 1e-6, "{channel}");
        }
    }

    #[test]
    fn each_set_is_nearly_white() {
        let bands = wavelength_bands();
        let mut variance = [0.0; 3];
        for set in 0..WAVELENGTH_SETS {
            for channel in 0..3 {
                let of_set = bands_of_set(set).map(|band| bands[band].response[channel]);
                let response = of_set.iter().sum::<f64>() * WAVELENGTH_SETS as f64;
                variance[channel] += (response - 1.0).powi(2) / WAVELENGTH_SETS as f64;
            }
        }
        assert!(variance[0] < 0.028 && variance[1] < 0.046 && variance[2] < 0.027, "{variance:?}");
    }

    /// The colours of lights, and of reflectances in daylight, are those of integrals over the spectrum.
    #[test]
    fn colours_are_those_of_integrals() {
        let lights = ["stdillum-A", "stdillum-F2", "stdillum-F7", "stdillum-F11"];
        let named = lights.map(|name| named_spectrum(name).expect("it is known"));
        for spectrum in named.into_iter().chain([2000.0, 6500.0, 20_000.0].map(blackbody)) {
            let luminance = spectrum.to_xyz()[1];
            let found = BandSpectrum::light(&spectrum).to_rgb().map(|c| c / luminance);
            let exact = srgb_from_xyz(spectrum.to_xyz()).map(|c| c / luminance);
            for (found, exact) in found.into_iter().zip(exact) {
                assert!((found / exact - 1.0).abs() < 1e-3, "{spectrum:?}: {found} for {exact}");
            }
        }
        let steep = |nm: f64| 1.0 / (1.0 + ((600.0 - nm) / 4.0).exp());
        let white = srgb_from_xyz(integrate(daylight_at));
        let exact = srgb_from_xyz(integrate(|nm| steep(nm) * daylight_at(nm)));
        let found = BandSpectrum::of(steep).to_rgb();
        for c in 0..3 {
            assert!((found[c] - exact[c] / white[c]).abs() < 1e-3, "{found:?} for {exact:?}");
        }
    }

    #[test]
    fn numbers_in_the_unit_interval_select_all_sets() {
        assert_eq!([0.0, 0.5, 1.0 - f32::EPSILON].map(wavelength_set), [0, 32, 63]);
    }
}
