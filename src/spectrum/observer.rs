//! The CIE's standard observer of 1931, and integrals weighted by it.

use std::sync::LazyLock;

use super::d65;

/// Shortest and longest wavelength of the integrals (nm).
pub const VISIBLE: [u32; 2] = [360, 830];

/// Step of the wavelengths of [`MATCHING`] (nm).
const STEP: u32 = 5;

/// Returns the colour-matching functions x, y, z of the standard observer of 1931 for 2 degrees at
/// a wavelength (nm): linear between the entries of the table, 0 beyond it.
pub fn colour_matching(nm: f64) -> [f64; 3] {
    let [first, last] = VISIBLE.map(f64::from);
    if !(first..=last).contains(&nm) {
        return [0.0; 3];
    }
    let x = (nm - first) / f64::from(STEP);
    let below = (x as usize).min(MATCHING.len() - 2);
    let fraction = x - below as f64;
    [0, 1, 2].map(|i| MATCHING[below][i] + fraction * (MATCHING[below + 1][i] - MATCHING[below][i]))
}

/// Returns the integrals of a quantity times the three matching functions over the visible
/// wavelengths, by steps of 1 nm.
pub(super) fn integrate(quantity: impl Fn(f64) -> f64) -> [f64; 3] {
    integrate_over([0.0, f64::INFINITY], quantity)
}

/// Returns the same integrals over the wavelengths from `first` to before `end` (nm).
pub(super) fn integrate_over([first, end]: [f64; 2], quantity: impl Fn(f64) -> f64) -> [f64; 3] {
    let mut sums = [0.0; 3];
    let within = |nm: &f64| (first..end).contains(nm);
    for nm in (VISIBLE[0]..=VISIBLE[1]).map(f64::from).filter(within) {
        let value = quantity(nm);
        for (sum, weight) in sums.iter_mut().zip(colour_matching(nm)) {
            *sum += value * weight;
        }
    }
    sums
}

/// The integral of the luminosity function [nm]: 106.857.
pub(super) static LUMINOSITY: LazyLock<f64> = LazyLock::new(|| integrate(|_| 1.0)[1]);

/// Daylight (D65) by steps of 1 nm, scaled so that a perfect reflector has luminance 1.
static DAYLIGHT: LazyLock<Vec<f64>> = LazyLock::new(|| {
    let d65 = d65();
    let luminance = integrate(|nm| d65.at(nm))[1];
    (VISIBLE[0]..=VISIBLE[1]).map(|nm| d65.at(f64::from(nm)) / luminance).collect()
});

/// Returns daylight at a visible wavelength (nm), which is rounded down.
pub(super) fn daylight_at(nm: f64) -> f64 {
    DAYLIGHT[(nm as u32 - VISIBLE[0]) as usize]
}

/// CIE 018:2019, table 6: x, y and z from 360 to 830 nm in steps of 5 nm.
#[rustfmt::skip]
const MATCHING: [[f64; 3]; 95] = [
    [0.0001299, 0.000003917, 0.0006061],
    [0.0002321, 0.000006965, 0.001086],
    [0.0004149, 0.00001239, 0.001946],
    [0.0007416, 0.00002202, 0.003486],
    [0.001368, 0.000039, 0.006450001],
    [0.002236, 0.000064, 0.01054999],
    [0.004243, 0.00012, 0.02005001],
    [0.00765, 0.000217, 0.03621],
    [0.01431, 0.000396, 0.06785001],
    [0.02319, 0.00064, 0.1102],
    [0.04351, 0.00121, 0.2074],
    [0.07763, 0.00218, 0.3713],
    [0.13438, 0.004, 0.6456],
    [0.21477, 0.0073, 1.0390501],
    [0.2839, 0.0116, 1.3856],
    [0.3285, 0.01684, 1.62296],
    [0.34828, 0.023, 1.74706],
    [0.34806, 0.0298, 1.7826],
    [0.3362, 0.038, 1.77211],
    [0.3187, 0.048, 1.7441],
    [0.2908, 0.06, 1.6692],
    [0.2511, 0.0739, 1.5281],
    [0.19536, 0.09098, 1.28764],
    [0.1421, 0.1126, 1.0419],
    [0.09564, 0.13902, 0.8129501],
    [0.05795001, 0.1693, 0.6162],
    [0.03201, 0.20802, 0.46518],
    [0.0147, 0.2586, 0.3533],
    [0.0049, 0.323, 0.272],
    [0.0024, 0.4073, 0.2123],
    [0.0093, 0.503, 0.1582],
    [0.0291, 0.6082, 0.1117],
    [0.06327, 0.71, 0.07824999],
    [0.1096, 0.7932, 0.05725001],
    [0.1655, 0.862, 0.04216],
    [0.2257499, 0.9148501, 0.02984],
    [0.2904, 0.954, 0.0203],
    [0.3597, 0.9803, 0.0134],
    [0.4334499, 0.9949501, 0.008749999],
    [0.5120501, 1.0, 0.005749999],
    [0.5945, 0.995, 0.0039],
    [0.6784, 0.9786, 0.002749999],
    [0.7621, 0.952, 0.0021],
    [0.8425, 0.9154, 0.0018],
    [0.9163, 0.87, 0.001650001],
    [0.9786, 0.8163, 0.0014],
    [1.0263, 0.757, 0.0011],
    [1.0567, 0.6949, 0.001],
    [1.0622, 0.631, 0.0008],
    [1.0456, 0.5668, 0.0006],
    [1.0026, 0.503, 0.00034],
    [0.9384, 0.4412, 0.00024],
    [0.8544499, 0.381, 0.00019],
    [0.7514, 0.321, 0.0001],
    [0.6424, 0.265, 0.00005],
    [0.5419, 0.217, 0.00003],
    [0.4479, 0.175, 0.00002],
    [0.3608, 0.1382, 0.00001],
    [0.2835, 0.107, 0.0],
    [0.2187, 0.0816, 0.0],
    [0.1649, 0.061, 0.0],
    [0.1212, 0.04458, 0.0],
    [0.0874, 0.032, 0.0],
    [0.0636, 0.0232, 0.0],
    [0.04677, 0.017, 0.0],
    [0.0329, 0.01192, 0.0],
    [0.0227, 0.00821, 0.0],
    [0.01584, 0.005723, 0.0],
    [0.01135916, 0.004102, 0.0],
    [0.008110916, 0.002929, 0.0],
    [0.005790346, 0.002091, 0.0],
    [0.004109457, 0.001484, 0.0],
    [0.002899327, 0.001047, 0.0],
    [0.00204919, 0.00074, 0.0],
    [0.001439971, 0.00052, 0.0],
    [0.000999949, 0.0003611, 0.0],
    [0.000690079, 0.0002492, 0.0],
    [0.000476021, 0.0001719, 0.0],
    [0.000332301, 0.00012, 0.0],
    [0.000234826, 0.0000848, 0.0],
    [0.000166151, 0.00006, 0.0],
    [0.000117413, 0.0000424, 0.0],
    [0.0000830753, 0.00003, 0.0],
    [0.0000587065, 0.0000212, 0.0],
    [0.0000415099, 0.00001499, 0.0],
    [0.0000293533, 0.0000106, 0.0],
    [0.0000206738, 0.0000074657, 0.0],
    [0.0000145598, 0.0000052578, 0.0],
    [0.000010254, 0.0000037029, 0.0],
    [0.0000072215, 0.0000026078, 0.0],
    [0.0000050859, 0.0000018366, 0.0],
    [0.0000035817, 0.0000012934, 0.0],
    [0.0000025225, 0.0000009109, 0.0],
    [0.0000017765, 0.0000006415, 0.0],
    [0.0000012511, 0.0000004518, 0.0],
];

#[cfg(test)]
pub(super) mod tests {
    use super::*;
    use crate::Spectrum;

    fn chromaticity(spectrum: &Spectrum) -> [f64; 2] {
        let [x, y, z] = spectrum.to_xyz();
        [x / (x + y + z), y / (x + y + z)]
    }

    pub(crate) fn assert_chromaticity(
        spectrum: &Spectrum,
        [x, y]: [f64; 2],
        within: f64,
        what: &str,
    ) {
        let found = chromaticity(spectrum);
        let off = (found[0] - x).abs().max((found[1] - y).abs());
        assert!(off < within, "{what}: {found:?}, published {x} {y}");
    }

    #[test]
    fn the_observer_has_its_published_luminosity() {
        // pbrt-v4's constant, from the table in steps of 1 nm.
        assert!((*LUMINOSITY - 106.856895).abs() < 3e-4, "{}", *LUMINOSITY);
        assert_eq!(colour_matching(359.9), [0.0; 3]);
        for (found, published) in colour_matching(555.0).into_iter().zip([0.5120501, 1.0, 0.00575])
        {
            assert!((found - published).abs() < 1e-8);
        }
    }
}
