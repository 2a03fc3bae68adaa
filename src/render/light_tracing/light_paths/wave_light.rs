//! Light of a wave of light paths: its wavelengths, and the bands of the lens that share its paths.

use super::LightPathInput;
use crate::film::LightSplit;
use petzval_base::sampler::{Dimension, pixel_key, sample_2d};
use petzval_spectrum::{bands_of_ray, bands_of_set};

/// Light that a wave of light paths carries.
#[derive(Clone, Copy, Debug)]
pub(crate) struct WaveLight<'a> {
    /// The input, with the scene at the wavelengths of the wave.
    pub input: LightPathInput<'a>,
    /// Band of the lens for which the wave was chosen.
    band: usize,
    /// Set of its wavelengths, if paths carry spectra.
    pub set: usize,
}

/// A band of the lens in which light paths are traced.
#[derive(Clone, Copy, Debug)]
pub(crate) struct PathBand {
    /// Index of the band.
    pub band: usize,
    /// Weights of the light of a path in this band, by channel of the path: red, green and blue, or the
    /// wavelengths of its set.
    pub weights: [f64; 3],
}

impl<'a> LightPathInput<'a> {
    /// Returns the light of a wave, given by its number among the waves of all sample numbers.
    /// Consecutive waves take the sets of wavelengths, and those of bands, evenly.
    pub(crate) fn wave_light(&self, number: u32) -> WaveLight<'a> {
        let [band, set, hero] = choose(self.split, self.seed, number);
        let scene = self.spectral.map_or(self.scene, |spectral| spectral.at(set, hero));
        WaveLight { input: Self { scene, ..*self }, band, set }
    }

    /// Returns one band of the lens in which the paths of a wave are traced.
    pub(crate) fn band_of_wave(&self, number: u32) -> usize {
        choose(self.split, self.seed, number)[0]
    }
}

/// Returns the band of the lens of a wave, and the set and the hero of its wavelengths.
fn choose(split: LightSplit, seed: u32, number: u32) -> [usize; 3] {
    let key = pixel_key(u32::MAX, u32::MAX - 6, seed);
    split.light_of(sample_2d(key, number, Dimension::Wavelength))
}

impl WaveLight<'_> {
    /// Returns the bands of the lens in which the paths of the wave are traced: those that share a
    /// camera ray. `response` returns the linear sRGB of a band, whose mean over all bands is 1.
    pub fn bands(&self, response: impl Fn(usize) -> [f64; 3]) -> Vec<PathBand> {
        let shared = shared_bands(self.band, self.input.split.bands);
        let share = 1.0 / shared.len() as f64;
        match (self.is_spectral(), shared.len()) {
            (true, 1) => vec![PathBand { band: self.band, weights: [1.0; 3] }],
            (true, _) => self.wavelengths(),
            (false, _) => {
                let weights = |band| response(band).map(|c| c * share);
                shared.into_iter().map(|band| PathBand { band, weights: weights(band) }).collect()
            }
        }
    }

    /// Returns whether the paths of the wave carry the wavelengths of a set.
    pub fn is_spectral(&self) -> bool {
        self.input.spectral.is_some()
    }

    /// Returns the bands of the wavelengths of the wave, each for the channel of its own.
    pub fn wavelengths(&self) -> Vec<PathBand> {
        let of_channel = |(channel, band): (usize, usize)| {
            let mut weights = [0.0; 3];
            weights[channel] = 1.0;
            PathBand { band, weights }
        };
        bands_of_set(self.set).into_iter().enumerate().map(of_channel).collect()
    }
}

/// Returns the bands that share the paths of a band, out of this number of bands.
fn shared_bands(band: usize, count: usize) -> Vec<usize> {
    let shared: Vec<usize> = bands_of_ray(band, count).collect();
    if shared.is_empty() { vec![band] } else { shared }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::film::SpectralSplit;
    use petzval_spectrum::{WAVELENGTH_SETS, WAVELENGTHS};

    /// Returns what a wave carries: the bands of the lens, the set and the hero.
    fn light(
        bands: usize,
        spectra: SpectralSplit,
        seed: u32,
        number: u32,
    ) -> (Vec<usize>, usize, usize) {
        let [band, set, hero] = choose(LightSplit { bands, spectra }, seed, number);
        (shared_bands(band, bands), set, hero)
    }

    #[test]
    fn consecutive_waves_take_every_band_once() {
        let bands = |bands, seed, number| light(bands, SpectralSplit::Rgb, seed, number).0;
        for seed in 0..9 {
            for first in [0, 8, 800] {
                let mut all: Vec<usize> =
                    (first..first + 8).flat_map(|number| bands(32, seed, number)).collect();
                all.sort_unstable();
                assert_eq!(all, (0..32).collect::<Vec<_>>());
            }
        }
        assert_eq!(bands(1, 3, 5), [0]);
        let mut alone: Vec<usize> = (0..64).flat_map(|i| bands(3, 1, i)).collect();
        assert_eq!(alone.len(), 64);
        alone.sort_unstable();
        alone.dedup();
        assert_eq!(alone, [0, 1, 2], "bands that share no rays");
    }

    #[test]
    fn consecutive_waves_take_every_set_once() {
        for bands in [1, WAVELENGTHS] {
            for spectra in [SpectralSplit::Sets, SpectralSplit::Heroes] {
                let mut sets: Vec<usize> =
                    (640..640 + 64).map(|number| light(bands, spectra, 7, number).1).collect();
                sets.sort_unstable();
                assert_eq!(sets, (0..WAVELENGTH_SETS).collect::<Vec<_>>());
            }
        }
        let mut counts = [0; WAVELENGTHS];
        for number in 0..64 * WAVELENGTHS as u32 {
            let (_, set, hero) = light(1, SpectralSplit::Heroes, 7, number);
            counts[set + hero * WAVELENGTH_SETS] += 1;
        }
        assert!(counts.iter().all(|count| (60..=68).contains(count)), "{counts:?}");
    }
}
