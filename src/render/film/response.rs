//! Film response: the conversion of a sample's light to the value that its pixel adds up.

use std::sync::Arc;

use glam::{DMat3, DVec3};

use crate::sensor::ColourFilters;
use petzval_scene::filter::PixelFilter;
use petzval_spectrum::{
    BucketShares, CameraSensor, WAVELENGTH_SETS, bands_of_set, wavelength_bands, xyz_from_srgb,
};

/// Response of a film. By default it passes all samples on unchanged, with equal weights.
#[derive(Clone, Debug, Default)]
pub struct Response {
    /// Pixel filter, which sets the positions and weights of samples.
    pub filter: PixelFilter,
    /// Largest channel of a sample in the sensor. Brighter samples are scaled down to it, which
    /// removes fireflies but also energy (pbrt-v4's `maxcomponentvalue`).
    pub max_component: Option<f64>,
    /// Measured camera, if the sensor is that of one.
    pub camera: Option<CameraSensor>,
    /// Matrix from linear sRGB to the channels of the sensor. An ideal sensor has X, Y and Z.
    pub sensor_from_srgb: Option<DMat3>,
    /// Matrix from linear sRGB to linear sRGB: the colours as the sensor sees them, with its white
    /// balance.
    pub colour: Option<DMat3>,
    /// Colour filters in front of the photosites of a measured camera.
    pub filters: Option<ColourFilters>,
    /// Matrix from the values at the wavelengths of each set to linear sRGB, if paths carry spectra.
    pub rgb_from_set: Option<Arc<[DMat3]>>,
    /// Buckets of wavelength that the film has beside its colours, if paths carry spectra. They receive
    /// the light that reaches the film, whatever the sensor and its white balance are.
    pub buckets: Option<Arc<BucketShares>>,
}

impl Response {
    /// Lets the film receive paths that carry the wavelengths of a set. A measured camera responds to
    /// wavelengths by itself: the values are then the linear sRGB that the matrix of the camera turns into
    /// its channels.
    pub fn receive_spectra(&mut self) {
        let bands = wavelength_bands();
        let of_camera = self
            .camera
            .as_ref()
            .zip(self.sensor_from_srgb)
            .map(|(camera, matrix)| (camera.band_responses(), matrix.inverse()));
        let response = |band: usize| match &of_camera {
            None => DVec3::from_array(bands[band].response),
            Some((channels, to_srgb)) => {
                *to_srgb * DVec3::from_array(channels.each_ref().map(|channel| channel[band]))
            }
        };
        let of_set = |set: usize| {
            // A path stands for those of all sets.
            let [first, second, third] =
                bands_of_set(set).map(|band| response(band) * WAVELENGTH_SETS as f64);
            DMat3::from_cols(first, second, third)
        };
        self.rgb_from_set = Some((0..WAVELENGTH_SETS).map(of_set).collect());
    }

    /// Returns the linear sRGB of the light of a sample, whose channels are the wavelengths of a set if
    /// paths carry spectra.
    #[inline(always)]
    pub fn to_rgb(&self, set: usize, light: [f64; 3]) -> [f64; 3] {
        match &self.rgb_from_set {
            None => light,
            Some(matrices) => (matrices[set] * DVec3::from_array(light)).to_array(),
        }
    }

    /// Returns the value that a sample of this light adds to its pixel.
    #[inline(always)]
    pub(super) fn apply(&self, light: [f64; 3]) -> [f64; 3] {
        self.apply_colour(self.limit(light, light))
    }

    /// Returns values of a sample, scaled down as much as its light, linear sRGB, is to be at most
    /// [`Self::max_component`].
    #[inline(always)]
    pub(super) fn limit(&self, light: [f64; 3], values: [f64; 3]) -> [f64; 3] {
        let Some(limit) = self.max_component else { return values };
        let channels = match &self.sensor_from_srgb {
            Some(matrix) => (*matrix * DVec3::from_array(light)).to_array(),
            None => xyz_from_srgb(light),
        };
        let most = channels.into_iter().fold(0.0, f64::max);
        match most > limit {
            true => values.map(|value| value * limit / most),
            false => values,
        }
    }

    /// Returns light as the sensor sees it. Light that belongs to no single sample takes only this
    /// step.
    pub fn apply_colour(&self, light: [f64; 3]) -> [f64; 3] {
        match &self.colour {
            Some(colour) => (*colour * DVec3::from_array(light)).to_array(),
            None => light,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use petzval_spectrum::{ColourSpace, white_balance};

    #[test]
    fn samples_above_the_maximum_keep_their_colour() {
        let film = Response { max_component: Some(2.0), ..Response::default() };
        assert_eq!(film.apply([0.5, 0.25, 0.125]), [0.5, 0.25, 0.125]);
        let [r, g, b] = film.apply([100.0, 50.0, 25.0]);
        assert!((r / g - 2.0).abs() < 1e-12 && (g / b - 2.0).abs() < 1e-12);
        let most = xyz_from_srgb([r, g, b]).into_iter().fold(0.0, f64::max);
        assert!((most - 2.0).abs() < 1e-12);
    }

    #[test]
    fn white_balance_makes_the_illuminant_white() {
        // Daylight of 9000 K is bluish, so the balance strengthens red.
        let balance = |kelvin| Response {
            colour: Some(white_balance(kelvin, ColourSpace::Srgb)),
            ..Response::default()
        };
        let film = balance(9000.0);
        let [r, g, b] = film.apply([1.0; 3]);
        assert!(r > 1.05 && b < 0.9, "{r} {g} {b}");
        let neutral = balance(6500.0);
        assert!(
            neutral
                .apply([1.0, 0.5, 0.2])
                .into_iter()
                .zip([1.0, 0.5, 0.2])
                .all(|(a, b)| (a - b).abs() < 1e-9)
        );
    }
}
