//! Colour filters of a measured camera: from the light of a picture to its photosites, and back.

use glam::{DMat3, DVec3};

use petzval_spectrum::xyz_from_srgb;

/// Limit of the light of a picture, so that sums of it are finite.
const MAX_LIGHT: f64 = 1e30;

/// The colour filters of a camera. Its channels are relative to the largest of white.
///
/// The white of the film's balance, at the value 1 in the picture, gives the most sensitive channel the
/// electrons of white, and the others less. ISO 12232:2019 defines the saturation-based speed by that
/// light, too: the exposure at which the first channel saturates.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ColourFilters {
    /// Matrix from linear sRGB of the picture to the channels.
    raw_from_picture: DMat3,
    /// Its inverse: white balance and colours at once.
    picture_from_raw: DMat3,
    /// The channels of white; the largest is 1.
    white: DVec3,
}

impl ColourFilters {
    /// Returns the filters of a camera, whose matrix maps its channels, in any unit, to linear sRGB of
    /// the picture. The picture's white has this linear sRGB.
    pub fn new(picture_from_raw: DMat3, white: [f64; 3]) -> Self {
        let raw_from_picture = picture_from_raw.inverse();
        let seen = raw_from_picture * DVec3::from_array(white);
        let largest = seen.max_element();
        Self {
            raw_from_picture: raw_from_picture * (1.0 / largest),
            picture_from_raw: picture_from_raw * largest,
            white: seen / largest,
        }
    }

    /// Returns the channels of white, relative to the largest. The white balance divides by them.
    pub fn white(&self) -> [f64; 3] {
        self.white.to_array()
    }

    /// Returns the matrix, in rows, from the channels to X, Y and Z; white has Y = 1.
    pub fn xyz_from_raw(&self) -> [[f64; 3]; 3] {
        let columns = self.picture_from_raw.to_cols_array_2d().map(xyz_from_srgb);
        DMat3::from_cols_array_2d(&columns).transpose().to_cols_array_2d()
    }

    /// Returns the channels of a pixel.
    pub(super) fn raw(&self, pixel: [f32; 3]) -> [f32; 3] {
        let light = pixel.map(|c| f64::from(c).clamp(-MAX_LIGHT, MAX_LIGHT));
        (self.raw_from_picture * DVec3::from_array(light)).as_vec3().to_array()
    }

    /// Returns the linear sRGB of readings. As in raw converters, a channel counts at most as in white, so that
    /// saturated light is white.
    pub(super) fn develop(&self, raw: [f32; 3]) -> [f32; 3] {
        let raw = DVec3::from_array(raw.map(f64::from)).min(self.white);
        (self.picture_from_raw * raw).as_vec3().to_array()
    }

    /// Returns the variances of the channels of a developed picture, from the variances of independent
    /// deviations of the readings and that of one which they have in common.
    pub(super) fn developed_variances(&self, independent: [f64; 3], common: f64) -> [f64; 3] {
        let columns = self.picture_from_raw.to_cols_array_2d();
        let squares = DMat3::from_cols_array_2d(&columns.map(|column| column.map(|m| m * m)));
        let sums = self.picture_from_raw * DVec3::ONE;
        (squares * DVec3::from_array(independent) + common * sums * sums).to_array()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Channels that see less red and blue, with cross-talk.
    const MATRIX: [f64; 9] = [3.0, -0.4, 0.1, -0.9, 1.5, -0.7, 0.0, -0.3, 2.2];

    #[test]
    fn white_fills_the_most_sensitive_channel() {
        for white in [[1.0; 3], [1.1, 0.97, 0.9]] {
            for unit in [1.0, 0.02] {
                let filters = ColourFilters::new(DMat3::from_cols_array(&MATRIX) * unit, white);
                let found = filters.white();
                assert!((found[1] - 1.0).abs() < 1e-12, "{found:?}");
                assert!(found[0] < 0.9 && found[2] < 0.9, "{found:?}");
                let raw = filters.raw(white.map(|c| c as f32));
                assert!((0..3).all(|c| (f64::from(raw[c]) - found[c]).abs() < 1e-6), "{raw:?}");
            }
        }
    }

    #[test]
    fn development_undoes_the_filters_up_to_white() {
        let filters = ColourFilters::new(DMat3::from_cols_array(&MATRIX), [1.0; 3]);
        for pixel in [[0.2, 0.5, 0.3], [0.9, 0.1, 0.05], [1.0, 1.0, 1.0]] {
            let found = filters.develop(filters.raw(pixel));
            assert!((0..3).all(|c| (found[c] - pixel[c]).abs() < 1e-5), "{pixel:?}: {found:?}");
        }
        let saturated = filters.develop([1.0; 3]);
        assert!(saturated.iter().all(|c| (c - 1.0).abs() < 1e-6), "white: {saturated:?}");
    }

    #[test]
    fn white_has_luminance_one() {
        let filters = ColourFilters::new(DMat3::from_cols_array(&MATRIX), [1.0; 3]);
        let white = DVec3::from_array(filters.white());
        let xyz = filters.xyz_from_raw().map(|row| DVec3::from_array(row).dot(white));
        let expected = xyz_from_srgb([1.0; 3]);
        assert!((0..3).all(|i| (xyz[i] - expected[i]).abs() < 1e-9), "{xyz:?}");
    }
}
