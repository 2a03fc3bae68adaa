//! Radiation of black bodies.

use super::Spectrum;

/// Returns the spectrum of a black body of a temperature (K).
pub fn blackbody(kelvin: f64) -> Spectrum {
    Spectrum::Blackbody { kelvin }
}

/// Returns the spectral radiance [W / (m^2 sr m)] at a wavelength (nm) and a temperature (K), by
/// Planck's law.
fn planck(nm: f64, kelvin: f64) -> f64 {
    // Constants of CODATA 2010, as in pbrt-v4.
    let (c, h, k) = (299_792_458.0, 6.626_069_57e-34, 1.380_648_8e-23);
    let m = nm * 1e-9;
    2.0 * h * c * c / (m.powi(5) * (h * c / (m * k * kelvin)).exp_m1())
}

/// Returns the radiance at a wavelength (nm) relative to its maximum, or 0 for a temperature (K)
/// that is not above 0.
pub(super) fn relative_radiance(nm: f64, kelvin: f64) -> f64 {
    if kelvin > 0.0 {
        // Wien's displacement law gives the wavelength of the maximum.
        planck(nm, kelvin) / planck(2.897_772_1e-3 / kelvin * 1e9, kelvin)
    } else {
        0.0
    }
}

#[cfg(test)]
mod tests {
    use super::super::observer::tests::assert_chromaticity;
    use super::*;

    #[test]
    fn black_bodies_are_on_the_planckian_locus() {
        // Wyszecki & Stiles 1982, table 1(3.11), whose second constant is 14388 um K.
        let published =
            [(2000.0, [0.5267, 0.4133]), (3000.0, [0.4369, 0.4041]), (6500.0, [0.3135, 0.3236])];
        for (kelvin, xy) in published {
            assert_chromaticity(&blackbody(kelvin), xy, 2e-4, "a black body");
        }
        assert_chromaticity(&blackbody(6504.0), [0.3134, 0.3235], 2e-4, "a black body of 6504 K");
        assert!((blackbody(5000.0).at(2.897_772_1e6 / 5000.0) - 1.0).abs() < 1e-12);
        assert!(blackbody(5000.0).at(500.0) < 1.0 && blackbody(5000.0).at(650.0) < 1.0);
        assert_eq!(blackbody(0.0).at(500.0), 0.0);
    }
}
