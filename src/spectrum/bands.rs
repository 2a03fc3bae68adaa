//! The visible light in bands, for lenses that take colours apart.

use glam::{DMat3, DVec3};

use super::{daylight_at, integrate_over, srgb_from_xyz};

/// Into how many bands the light is taken apart: the images of neighbours lie so near to each
/// other that no step is seen.
pub const BANDS: usize = 32;

/// Shortest and longest wavelength, nm; beyond, the eye sees less than 0.5 % of the light.
pub const RANGE: [f64; 2] = [400.0, 704.0];

/// How many bands share a ray: the hero that it was traced for, and those that lie evenly around the
/// spectrum from it (Wilkie, Nawaz, Droske, Weidlich & Hanika 2014, "Hero wavelength spectral
/// sampling").
pub const SHARING: usize = 4;

/// The bands that share the rays of one of so many, that one first; `None` where so many bands cannot
/// be shared out, or the light is not taken apart. Whichever of them is the hero, they are the same.
pub fn sharing(hero: usize, bands: usize) -> Option<[usize; SHARING]> {
    let apart = bands / SHARING;
    let even = bands > 1 && bands.is_multiple_of(SHARING);
    even.then(|| std::array::from_fn(|i| (hero + i * apart) % bands))
}

/// The hero of a sample, by two numbers in [0, 1): which bands share its ray, and which of those it
/// is. So a few samples that spread evenly over both are of all bands as evenly as can be.
pub fn hero([u, v]: [f32; 2], bands: usize) -> usize {
    let share = |u: f32, count: usize| ((u * count as f32) as usize).min(count - 1);
    match sharing(0, bands) {
        Some([_, apart, ..]) => share(u, apart) + apart * share(v, SHARING),
        None => share(u, bands),
    }
}

/// A band of wavelengths of white light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightBand {
    /// Its middle, nm.
    pub wavelength: f64,
    /// What it adds to linear red, green and blue; 1 on average over all bands.
    pub response: [f64; 3],
}

/// The visible light in bands of the same width.
///
/// Each channel is a sensor of its own, as sensitive as sRGB's matching function where that is
/// above 0, in daylight: so white stays white, every colour stays what it is, and no colour
/// mixes into another. What lies side by side in the picture of a lens that takes colours apart
/// has the hue of its wavelength, less saturated than a monochromator's.
pub fn bands() -> [LightBand; BANDS] {
    let width = (RANGE[1] - RANGE[0]) / BANDS as f64;
    let edge = |i: usize| RANGE[0] + width * i as f64;
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

/// A film, or a filter before it, for a part of the visible light: it sees grey.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Passband {
    /// Shortest and longest wavelength, nm.
    pub range: [f64; 2],
}

impl Passband {
    /// The light that it sees, in bands of the same width that count the same.
    pub fn bands(&self) -> [LightBand; BANDS] {
        let [low, high] = self.range;
        let width = (high - low) / BANDS as f64;
        std::array::from_fn(|i| LightBand {
            wavelength: low + width * (i as f64 + 0.5),
            response: [1.0; 3],
        })
    }

    /// All of it as one band.
    pub fn whole(&self) -> LightBand {
        let [low, high] = self.range;
        LightBand { wavelength: (low + high) / 2.0, response: [1.0; 3] }
    }

    /// Linear sRGB to the same grey in all channels. A channel counts by how sensitive it is to
    /// this light; what is white stays white.
    pub fn grey(&self) -> DMat3 {
        let [low, high] = self.range;
        let share = |band: &LightBand| {
            // Of a band of `bands`, the part that is in the range.
            let half = (RANGE[1] - RANGE[0]) / BANDS as f64 / 2.0;
            let [from, to] = [band.wavelength - half, band.wavelength + half];
            (to.min(high) - from.max(low)).max(0.0)
        };
        let mut sum = DVec3::ZERO;
        for band in bands() {
            sum += DVec3::from_array(band.response) * share(&band);
        }
        let row = sum / (sum.x + sum.y + sum.z);
        DMat3::from_cols(row, row, row).transpose()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn heroes_are_of_all_bands_and_share_with_the_same() {
        let mut counts = [0; BANDS];
        let key = crate::sampler::pixel_key(3, 5, 0);
        for sample in 0..BANDS as u32 {
            let numbers = crate::sampler::pair(key, sample, crate::sampler::Dimension::Wavelength);
            counts[hero(numbers, BANDS)] += 1;
        }
        assert_eq!(counts, [1; BANDS], "as many samples as bands are one of each");
        for band in 0..BANDS {
            let shared = sharing(band, BANDS).expect("32 bands share");
            assert_eq!(shared[0], band);
            for other in shared {
                let mut others = sharing(other, BANDS).expect("32 bands share");
                let mut shared = shared;
                others.sort_unstable();
                shared.sort_unstable();
                assert_eq!(others, shared);
            }
        }
        assert_eq!([1, 2, 33].map(|bands| sharing(0, bands)), [None; 3]);
        assert_eq!([hero([0.999; 2], 33), hero([0.5; 2], 1)], [32, 0]);
    }

    #[test]
    fn a_passband_sees_grey_by_the_channels_that_share_its_light() {
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
    fn channels_see_their_colours() {
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
