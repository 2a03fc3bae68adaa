//! Fixed patterns of a sensor: response and dark signal differ from photosite to photosite, in the same way in
//! every picture.
//!
//! The terms are those of EMVA 1288 (release 4.0, 2021): non-uniformity of the dark signal (DSNU) and of the
//! response (PRNU). Each has a part for the photosite, one for its row and one for its column.

use super::deviations::{Components, Deviations};
use super::photosite_rng::PhotositeRng;
use petzval_base::sampler::hash;

/// Separates the patterns from the noise of pictures.
const SALT: u32 = 0x1288_f1ed;

/// Photosites of a large dark current.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HotPixels {
    /// Share of the photosites, 0 to 1.
    pub share: f64,
    /// Their mean dark current (electrons a second), distributed exponentially.
    pub dark_current: f64,
}

/// The fixed patterns of a sensor.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FixedPattern {
    /// Seed: another seed is another sensor of the same make.
    pub seed: u32,
    /// Non-uniformity of the dark signal, DSNU (electrons).
    pub dark_signal: Components,
    /// Non-uniformity of the response, PRNU, relative to it.
    pub response: Components,
    /// Hot pixels.
    pub hot: HotPixels,
}

/// The fixed patterns over a picture.
pub(super) struct PatternSamples {
    dark_signal: Deviations,
    response: Deviations,
    hot: HotPixels,
    hot_seed: u32,
}

/// Response and dark signal of one photosite.
pub(super) struct PhotositePattern {
    /// Response relative to the mean, at least 0.
    pub response: f64,
    /// Dark signal (electrons) that is added to the mean one.
    pub dark_signal: f64,
    /// Dark current (electrons a second) that is added to the mean one.
    pub dark_current: f64,
}

impl PhotositePattern {
    /// That of all photosites of a sensor without patterns.
    pub(super) const NONE: Self = Self { response: 1.0, dark_signal: 0.0, dark_current: 0.0 };
}

impl FixedPattern {
    /// Returns whether all photosites are alike.
    pub fn is_uniform(&self) -> bool {
        *self == Self { seed: self.seed, ..Self::default() }
    }

    /// Samples the patterns over a picture, or returns `None` if all photosites are alike. `origin` is the
    /// position of the picture's first pixel in the frame.
    pub(super) fn samples(&self, origin: [u32; 2], size: [usize; 2]) -> Option<PatternSamples> {
        if self.is_uniform() {
            return None;
        }
        // Hashed twice, so that the fields of one sensor are not those of another.
        let own = hash(self.seed ^ SALT);
        let [dark_signal, response, hot_seed] = [1, 2, 3].map(|field| hash(own ^ field));
        Some(PatternSamples {
            dark_signal: Deviations::new(&self.dark_signal, origin, size, dark_signal),
            response: Deviations::new(&self.response, origin, size, response),
            hot: self.hot,
            hot_seed,
        })
    }
}

impl PatternSamples {
    /// Returns the pattern of a photosite.
    pub(super) fn at(&self, pixel: [u32; 2], channel: u32) -> PhotositePattern {
        PhotositePattern {
            response: (1.0 + self.response.at(pixel, channel)).max(0.0),
            dark_signal: self.dark_signal.at(pixel, channel),
            dark_current: self.hot_dark_current(pixel, channel),
        }
    }

    fn hot_dark_current(&self, pixel: [u32; 2], channel: u32) -> f64 {
        let HotPixels { share, dark_current } = self.hot;
        if share == 0.0 {
            return 0.0;
        }
        let mut rng = PhotositeRng::new(pixel, channel, self.hot_seed);
        let is_hot = rng.uniform() < share;
        if is_hot { -dark_current * rng.uniform().ln() } else { 0.0 }
    }
}
