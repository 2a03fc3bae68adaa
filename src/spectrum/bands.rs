//! Bands of visible light, for lenses with dispersion.

use glam::{DMat3, DVec3};

use super::observer::{daylight_at, integrate_over};
use super::{WAVELENGTHS, WAVELENGTHS_PER_PATH, srgb_from_xyz};

/// Number of bands of dispersed light: neighbouring images lie so near to each other that no step
/// is visible.
pub const BANDS: usize = 32;

/// Shortest and longest wavelength (nm); the eye sees less than 0.5 % of daylight beyond.
pub const BAND_RANGE: [f64; 2] = [400.0, 704.0];

/// Number of bands that share a ray: the hero, for which it is traced, and others at even distances
/// around the spectrum (Wilkie, Nawaz, Droske, Weidlich & Hanika 2014, "Hero wavelength spectral
/// sampling").
pub const BANDS_PER_RAY: usize = 4;

/// Returns the bands that share the ray of a hero, the hero first. Each of them as hero gives the
/// same set. They are [`BANDS_PER_RAY`], or those of its set of [`WAVELENGTHS`]. Returns none if the
/// number of bands is 1 or not a multiple of their number.
#[inline]
pub fn bands_of_ray(hero: usize, bands: usize) -> impl ExactSizeIterator<Item = usize> + Clone {
    let count = match bands_per_ray(bands) {
        count if bands > 1 && bands.is_multiple_of(count) => count,
        _ => 0,
    };
    (0..count).map(move |i| (hero + i * (bands / count)) % bands)
}

#[inline]
fn bands_per_ray(bands: usize) -> usize {
    if bands == WAVELENGTHS { WAVELENGTHS_PER_PATH } else { BANDS_PER_RAY }
}

/// Returns the hero of a sample from two random numbers in [0, 1): `u` selects the set of bands
/// that share its ray, `v` the hero among them. Few samples that are well distributed over both
/// cover the bands evenly.
#[inline]
pub fn hero_band([u, v]: [f32; 2], bands: usize) -> usize {
    let select = |u: f32, count: usize| ((u * count as f32) as usize).min(count - 1);
    match bands_of_ray(0, bands).len() {
        0 => select(u, bands),
        shared => select(u, bands / shared) + bands / shared * select(v, shared),
    }
}

/// A band of wavelengths of white light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBand {
    /// Central wavelength (nm).
    pub wavelength: f64,
    /// Contribution to linear red, green and blue; 1 on average over all bands.
    pub response: [f64; 3],
}

/// Returns the bands of visible light, which have the same width.
///
/// Each channel is a sensor of its own. Its sensitivity is sRGB's matching function in daylight,
/// with negative values set to 0. So white stays white, and no channel mixes into another: without
/// dispersion every colour is preserved. The image of each dispersed band has the hue of its
/// wavelength, less saturated than monochromatic light.
pub fn bands() -> [LightBand; BANDS] {
    let width = (BAND_RANGE[1] - BAND_RANGE[0]) / BANDS as f64;
    let edge = |i: usize| BAND_RANGE[0] + width * i as f64;
    let mut bands: [LightBand; BANDS] = std::array::from_fn(|i| {
        let xyz = integrate_over([edge(i), edge(i + 1)], daylight_at);
        let response = srgb_from_xyz(xyz).map(|c| c.max(0.0));
        LightBand { wavelength: (edge(i) + edge(i + 1)) / 2.0, response }
    });
    for channel in 0..3 {
        let mean = bands.iter().map(|band| band.response[channel]).sum::<f64>() / BANDS as f64;
        for band in &mut bands {
            band.response[channel] /= mean;
        }
    }
    bands
}

/// The range of wavelengths of a narrow-band film or filter, whose picture is grey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passband {
    /// Shortest and longest wavelength (nm).
    pub range: [f64; 2],
}

impl Passband {
    /// Returns bands of the same width and weight over the range.
    pub fn bands(&self) -> [LightBand; BANDS] {
        let [low, high] = self.range;
        let width = (high - low) / BANDS as f64;
        std::array::from_fn(|i| LightBand {
            wavelength: low + width * (i as f64 + 0.5),
            response: [1.0; 3],
        })
    }

    /// Returns the range as one band.
    pub fn whole(&self) -> LightBand {
        let [low, high] = self.range;
        LightBand { wavelength: (low + high) / 2.0, response: [1.0; 3] }
    }

    /// Returns the matrix from linear sRGB to the same grey in all channels. The weight of a
    /// channel is its sensitivity in the range; white stays white.
    pub fn grey(&self) -> DMat3 {
        let [low, high] = self.range;
        // Overlap of a band of `bands` with the range (nm).
        let overlap = |band: &LightBand| {
            let half = (BAND_RANGE[1] - BAND_RANGE[0]) / BANDS as f64 / 2.0;
            let [first, last] = [band.wavelength - half, band.wavelength + half];
            (last.min(high) - first.max(low)).max(0.0)
        };
        let mut sum = DVec3::ZERO;
        for band in bands() {
            sum += DVec3::from_array(band.response) * overlap(&band);
        }
        let row = sum / (sum.x + sum.y + sum.z);
        DMat3::from_cols(row, row, row).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heroes_cover_all_bands_and_their_sets_agree() {
        let mut counts = [0; BANDS];
        let key = petzval_base::sampler::pixel_key(3, 5, 0);
        for sample in 0..BANDS as u32 {
            let numbers = petzval_base::sampler::sample_2d(
                key,
                sample,
                petzval_base::sampler::Dimension::Wavelength,
            );
            counts[hero_band(numbers, BANDS)] += 1;
        }
        assert_eq!(counts, [1; BANDS], "as many samples as bands have one hero each");
        for band in 0..BANDS {
            let shared: Vec<usize> = bands_of_ray(band, BANDS).collect();
            assert_eq!((shared.len(), shared[0]), (4, band));
            for &other in &shared {
                let mut others: Vec<usize> = bands_of_ray(other, BANDS).collect();
                let mut shared = shared.clone();
                others.sort_unstable();
                shared.sort_unstable();
                assert_eq!(others, shared);
            }
        }
        assert_eq!([1, 2, 33].map(|bands| bands_of_ray(0, bands).len()), [0; 3]);
        assert_eq!([hero_band([0.999; 2], 33), hero_band([0.5; 2], 1)], [32, 0]);
    }

    #[test]
    fn a_passband_is_grey_by_the_channels_that_are_sensitive_to_it() {
        for (range, channel) in [([440.0, 460.0], 2), ([530.0, 550.0], 1), ([630.0, 650.0], 0)] {
            let film = Passband { range };
            let white = film.grey() * DVec3::ONE;
            assert!((white - DVec3::ONE).abs().max_element() < 1e-12);
            let mut light = DVec3::ZERO;
            light[channel] = 1.0;
            let seen = film.grey() * light;
            assert!(seen.x > 0.6 && seen.x == seen.y && seen.y == seen.z, "{range:?}: {seen}");
            let bands = film.bands();
            assert!(bands.iter().all(|b| range[0] < b.wavelength && b.wavelength < range[1]));
        }
    }

    #[test]
    fn white_stays_white() {
        let bands = bands();
        for channel in 0..3 {
            let mean = bands.iter().map(|band| band.response[channel]).sum::<f64>() / BANDS as f64;
            assert!((mean - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn each_channel_is_most_sensitive_to_its_colour() {
        let bands = bands();
        let peak = |channel: usize| {
            let by = |a: &&LightBand, b: &&LightBand| {
                a.response[channel].total_cmp(&b.response[channel])
            };
            bands.iter().max_by(by).map_or(0.0, |band| band.wavelength)
        };
        assert!((590.0..620.0).contains(&peak(0)), "{}", peak(0));
        assert!((520.0..560.0).contains(&peak(1)), "{}", peak(1));
        assert!((440.0..465.0).contains(&peak(2)), "{}", peak(2));
    }
}
