//! Fits of the channels of measured cameras to X, Y and Z, and the colour matrices of raw files.

use glam::{DMat3, DVec3};

use super::camera_sensor::{
    CameraSensor, Sensitivities, by_nanometre, integral, observer, product, response_to, tabulated,
};
use super::camera_tables::PATCHES;
use super::{Spectrum, d_illuminant};

impl CameraSensor {
    /// Returns the matrix from X, Y and Z of surfaces in the light of an illuminant to the channels of the
    /// camera, in rows: a `ColorMatrix` of DNG (Adobe, Digital Negative 1.7.1.0, 2023, chapter 6). It is the
    /// inverse of a fit as that of [`Self::response`]. White has Y = 1 and a second channel near 1.
    pub fn colour_matrix(&self, illuminant: &Spectrum) -> [[f64; 3]; 3] {
        let to_xyz = xyz_from_channels(&self.sensitivities(), illuminant, illuminant);
        to_xyz.inverse().transpose().to_cols_array_2d()
    }

    /// Returns the matrix from the channels of the camera in the light of an illuminant, relative to those of
    /// white, to X, Y and Z of the same surfaces in D50, in rows: a `ForwardMatrix` of DNG. White is exact.
    pub fn forward_matrix(&self, illuminant: &Spectrum) -> [[f64; 3]; 3] {
        let (camera, d50) = (self.sensitivities(), d_illuminant(5000.0));
        let to_xyz = xyz_from_channels(&camera, illuminant, &d50);
        let of_white = |channels: &Sensitivities, light: &Spectrum| {
            let light = by_nanometre(light);
            response_to(channels, &light) / integral(&light, &channels[1])
        };
        let (neutral, white) = (of_white(&camera, illuminant), of_white(&observer(), &d50));
        let scale = DMat3::from_diagonal(white / (to_xyz * neutral));
        (scale * to_xyz * DMat3::from_diagonal(neutral)).transpose().to_cols_array_2d()
    }
}

/// Returns the matrix from the channels of a camera, for reflectances in the light of a scene, to X, Y and Z
/// of the same reflectances in another light: a linear fit. In both, white is 1 in the second.
pub(super) fn xyz_from_channels(
    camera: &Sensitivities,
    scene: &Spectrum,
    output: &Spectrum,
) -> DMat3 {
    let ([scene, output], observer) = ([scene, output].map(by_nanometre), observer());
    let [green, luminance] = [integral(&scene, &camera[1]), integral(&output, &observer[1])];
    let pairs = PATCHES.iter().map(|patch| {
        let patch = tabulated(patch, 1e-3);
        let seen = response_to(camera, &product(&patch, &scene)) / green;
        (seen, response_to(&observer, &product(&patch, &output)) / luminance)
    });
    fit(pairs, None)
}

/// Returns the matrix that comes nearest, by least squares, to mapping the first vector of each pair
/// to the second. An `exact` pair is mapped without a difference.
pub(super) fn fit(
    pairs: impl Iterator<Item = (DVec3, DVec3)>,
    exact: Option<(DVec3, DVec3)>,
) -> DMat3 {
    let (mut products, mut squares) = (DMat3::ZERO, DMat3::ZERO);
    let outer = |a: DVec3, b: DVec3| DMat3::from_cols(a * b.x, a * b.y, a * b.z);
    for (from, to) in pairs {
        products += outer(to, from);
        squares += outer(from, from);
    }
    let inverse = squares.inverse();
    let free = products * inverse;
    let Some((from, to)) = exact else { return free };
    // Lagrange's multiplier of the constraint.
    let direction = inverse * from;
    free + outer(to - free * from, direction) * (1.0 / direction.dot(from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::camera_sensor::nanometres;
    use crate::{colour_matching, named_spectrum};

    /// A camera that sees X, Y and Z has the matrix 1 in any light.
    #[test]
    fn the_colour_matrix_of_the_observer_is_unity() {
        let row = |nm: f64| {
            let [x, y, z] = colour_matching(nm);
            [nm, x, y, z]
        };
        let camera = CameraSensor::from_table(&nanometres().map(row).collect::<Vec<_>>()).unwrap();
        for light in ["stdillum-A", "stdillum-D65", "stdillum-F2"] {
            let found = camera.colour_matrix(&named_spectrum(light).unwrap());
            let off = |i: usize, j: usize| found[i][j] - f64::from(u32::from(i == j));
            let most = (0..9).map(|k| off(k / 3, k % 3).abs()).fold(0.0, f64::max);
            assert!(most < 1e-6, "{light}: {found:?}");
        }
    }

    #[test]
    fn a_fit_recovers_a_matrix_and_maps_the_exact_pair() {
        let matrix = DMat3::from_cols_array(&[1.0, 0.2, 0.0, 0.1, 0.9, 0.3, 0.0, 0.4, 1.2]);
        let from = [DVec3::X, DVec3::Y, DVec3::Z, DVec3::new(1.0, 2.0, 3.0)];
        let found = fit(from.into_iter().map(|v| (v, matrix * v)), None);
        assert!(found.abs_diff_eq(matrix, 1e-12));
        let exact = (DVec3::ONE, DVec3::new(3.0, 2.0, 1.0));
        let found = fit(from.into_iter().map(|v| (v, matrix * v)), Some(exact));
        assert!((found * exact.0).abs_diff_eq(exact.1, 1e-12));
    }

    #[test]
    fn the_forward_matrix_maps_white_to_d50() {
        for name in ["canon_eos_100d", "nikon_d850", "sony_ilce_9"] {
            let camera = CameraSensor::from_name(name).unwrap();
            for light in ["stdillum-A", "stdillum-D65", "stdillum-F11"] {
                let found = camera.forward_matrix(&named_spectrum(light).unwrap());
                let white = found.map(|row| row.iter().sum::<f64>());
                let off = DVec3::from_array(white) - DVec3::new(0.9642, 1.0, 0.8251);
                assert!(off.abs().max_element() < 3e-4, "{name} in {light}: {white:?}");
            }
        }
    }
}
