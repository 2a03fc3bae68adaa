//! The visible light in bands, for lenses that take colours apart.

use super::{daylight_at, integrate_over, srgb_from_xyz};

/// Into how many bands the light is taken apart: the images of neighbours lie so near to each
/// other that no step is seen.
pub const BANDS: usize = 32;

/// Shortest and longest wavelength, nm; beyond, the eye sees less than 0.5 % of the light.
const RANGE: [u32; 2] = [400, 704];

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
    let width = (RANGE[1] - RANGE[0]) as f64 / BANDS as f64;
    let edge = |i: usize| f64::from(RANGE[0]) + width * i as f64;
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

#[cfg(test)]
mod tests {
    use super::*;

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
