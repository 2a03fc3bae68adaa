//! Uplift: spectra of colours that a file gives as linear sRGB.

mod basis;
mod sigmoid;

use super::BandSpectrum;
use super::wavelength_sets::{WAVELENGTHS_PER_PATH, bands_of_set};
use basis::BASIS;
use sigmoid::fitted;

/// Returns the reflectance of a colour in daylight: a smooth spectrum between 0 and 1 (Jakob & Hanika
/// 2019, "A low-dimensional function space for efficient spectral upsampling"). Channels above 1 scale it.
pub fn uplift_reflectance(rgb: [f32; 3]) -> BandSpectrum {
    let brightest = rgb.into_iter().fold(0.0, f32::max);
    if brightest <= 1.0 { fitted(rgb) } else { scaled_fit(rgb, brightest) }
}

/// Returns the spectrum of a quantity without an upper limit, such as the radiance of a light relative
/// to daylight: a multiple of the reflectance whose brightest channel is one half, as in pbrt-v4.
pub fn uplift_unbounded(rgb: [f32; 3]) -> BandSpectrum {
    scaled_fit(rgb, 2.0 * rgb.into_iter().fold(0.0, f32::max))
}

fn scaled_fit(rgb: [f32; 3], scale: f32) -> BandSpectrum {
    match scale > 0.0 {
        true => fitted(rgb.map(|c| c / scale)).scaled(scale),
        false => BandSpectrum::of(|_| 0.0),
    }
}

/// Returns the matrix from linear sRGB to the values at the wavelengths of a set. It is linear, so that
/// filtered texels keep their mean, and maps [0, 1] into [0, 1] (Mallett & Yuksel 2019, "Spectral primary
/// decomposition for rendering with sRGB reflectance").
pub fn uplift_matrix(set: usize) -> [[f32; 3]; WAVELENGTHS_PER_PATH] {
    bands_of_set(set).map(|band| [0, 1, 2].map(|channel| BASIS[channel].values()[band]))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::WAVELENGTH_SETS;

    /// Colours of paints, and of the corners and edges of the gamut, drawn in a little.
    fn colours() -> Vec<[f32; 3]> {
        let steps = [0.02, 0.2, 0.5, 0.8, 0.95];
        let pairs = steps.into_iter().flat_map(|r| steps.map(|g| [r, g]));
        pairs.flat_map(|[r, g]| steps.map(|b| [r, g, b])).collect()
    }

    #[test]
    fn spectra_have_the_colours_that_they_are_made_of() {
        for rgb in colours() {
            let spectrum = uplift_reflectance(rgb);
            assert!(spectrum.values().iter().all(|v| (0.0..=1.0).contains(v)), "{rgb:?}");
            for (found, wanted) in spectrum.to_rgb().into_iter().zip(rgb) {
                assert!((found - f64::from(wanted)).abs() < 2e-3, "{found} of {rgb:?}");
            }
            let strong = uplift_unbounded(rgb.map(|c| 1e6 * c));
            for (found, wanted) in strong.to_rgb().into_iter().zip(rgb) {
                assert!((found / 1e6 - f64::from(wanted)).abs() < 2e-3, "{found} of {rgb:?}");
            }
        }
    }

    #[test]
    fn pure_primaries_are_nearly_reached_and_never_exceeded() {
        for corner in 0..8 {
            let rgb = [0, 1, 2].map(|c| f32::from(u8::from(corner >> c & 1 == 1)));
            let spectrum = uplift_reflectance(rgb);
            assert!(spectrum.values().iter().all(|v| (0.0..=1.0).contains(v)), "{rgb:?}");
            for (found, wanted) in spectrum.to_rgb().into_iter().zip(rgb) {
                assert!((found - f64::from(wanted)).abs() < 0.05, "{found} of {rgb:?}");
            }
        }
    }

    #[test]
    fn greys_are_constant() {
        for grey in [0.0, 1e-3, 0.18, 1.0, 3.0] {
            for spectrum in [uplift_reflectance([grey; 3]), uplift_unbounded([grey; 3])] {
                assert!(spectrum.values().iter().all(|v| (v - grey).abs() <= 1e-6 * grey));
            }
        }
    }

    #[test]
    fn the_basis_is_linear_white_and_has_the_colours_of_its_texels() {
        for rgb in colours() {
            let mut found = [0.0; 3];
            for set in 0..WAVELENGTH_SETS {
                let matrix = uplift_matrix(set);
                for (row, band) in matrix.into_iter().zip(bands_of_set(set)) {
                    assert!((row.iter().sum::<f32>() - 1.0).abs() < 1e-5 && row[0] >= 0.0);
                    let value: f32 = (0..3).map(|c| row[c] * rgb[c]).sum();
                    let response = crate::wavelength_bands()[band].response;
                    (0..3).for_each(|c| found[c] += f64::from(value) * response[c]);
                }
            }
            for (found, wanted) in found.into_iter().zip(rgb) {
                assert!((found - f64::from(wanted)).abs() < 2e-3, "{found} of {rgb:?}");
            }
        }
    }
}
