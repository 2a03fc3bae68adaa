//! Fixed patterns of a sensor: what differs from photosite to photosite, and is the same in every picture.
//!
//! The terms are those of EMVA 1288 (release 4.0, 2021): the dark signal is non-uniform (DSNU), and so is
//! the response (PRNU). Each has a part for the photosite, one for its row and one for its column.

use super::photosite_rng::PhotositeRng;
use petzval_base::sampler::hash;

/// Separates the patterns from the noise of pictures.
const SALT: u32 = 0x1288_f1ed;

/// Stands for the coordinate that a row or a column does not have. No frame is so large.
const NONE: u32 = u32::MAX;

/// Standard deviations of what is random by photosite, by row and by column.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Components {
    /// By photosite.
    pub pixel: f64,
    /// By row.
    pub row: f64,
    /// By column.
    pub column: f64,
}

impl Components {
    /// Returns the variance of the sum.
    pub fn variance(&self) -> f64 {
        let Self { pixel, row, column } = self;
        pixel * pixel + row * row + column * column
    }

    /// Returns a sample of the sum for a photosite. All channels of a row or a column have the same.
    pub(super) fn sample(&self, [x, y]: [u32; 2], channel: u32, seed: u32) -> f64 {
        let part = |deviation: f64, place: [u32; 2], channel| match deviation > 0.0 {
            true => deviation * PhotositeRng::new(place, channel, seed).normal(),
            false => 0.0,
        };
        part(self.pixel, [x, y], channel)
            + part(self.row, [NONE, y], 0)
            + part(self.column, [x, NONE], 0)
    }
}

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

/// What a fixed pattern makes of one photosite.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct PhotositePattern {
    /// Dark signal (electrons) that the pattern adds.
    pub dark_signal: f64,
    /// Response relative to the mean, at least 0.
    pub response: f64,
    /// Dark current (electrons a second) that the pattern adds.
    pub dark_current: f64,
}

impl FixedPattern {
    /// Returns the pattern of a photosite.
    pub(super) fn at(&self, pixel: [u32; 2], channel: u32) -> PhotositePattern {
        let [dark_signal, response, hot] = [1, 2, 3].map(|kind| hash(self.seed ^ SALT ^ kind));
        PhotositePattern {
            dark_signal: self.dark_signal.sample(pixel, channel, dark_signal),
            response: (1.0 + self.response.sample(pixel, channel, response)).max(0.0),
            dark_current: self.hot.dark_current(pixel, channel, hot),
        }
    }
}

impl HotPixels {
    fn dark_current(&self, pixel: [u32; 2], channel: u32, seed: u32) -> f64 {
        if self.share == 0.0 {
            return 0.0;
        }
        let mut rng = PhotositeRng::new(pixel, channel, seed);
        let is_hot = rng.uniform() < self.share;
        if is_hot { -self.dark_current * rng.uniform().ln() } else { 0.0 }
    }
}
