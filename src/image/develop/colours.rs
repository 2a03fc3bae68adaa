//! Colours of a camera by the light of the scene ("Mapping Camera Color Space to CIE XYZ Space", Adobe, Digital
//! Negative Specification 1.7.1.0, 2023, chapter 6).

use glam::{DMat3, DVec3};

use petzval_spectrum::{D50, Primaries, adapt};

use super::DevelopError;

/// Largest element of a matrix that is accepted.
const MAX_ELEMENT: f64 = 1e4;

/// Matrices of a camera in one light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct LightColours {
    /// Correlated colour temperature (K), if it is known.
    pub kelvin: Option<f64>,
    /// From X, Y and Z to the channels of the model: `ColorMatrix`.
    pub from_xyz: DMat3,
    /// From the channels of the model to those of this camera: `AnalogBalance` times `CameraCalibration`.
    pub calibration: DMat3,
    /// From channels relative to white to X, Y and Z in D50: `ForwardMatrix`.
    pub to_xyz_d50: Option<DMat3>,
}

/// White balance with which a picture was taken.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Neutral {
    /// Channels of white: `AsShotNeutral`.
    Channels(DVec3),
    /// Chromaticities x and y of the light: `AsShotWhiteXY`.
    Light([f64; 2]),
}

/// Colours of a camera, and the white balance with which it took a picture.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct CameraColours {
    first: LightColours,
    /// Matrices in a second light, and the temperatures of both lights (K).
    second: Option<(LightColours, [f64; 2])>,
    as_shot: Neutral,
}

impl CameraColours {
    /// Returns the colours of a camera with matrices in one light or in two, of which one is left out if its temperature
    /// is unknown or that of the other. Without a white balance, daylight (D50) is white.
    ///
    /// # Errors
    /// Returns what was found if there are no matrices, or if one is singular.
    pub fn new(mut lights: Vec<LightColours>, as_shot: Option<Neutral>) -> Result<Self, String> {
        let is_sound = |matrix: &DMat3| {
            let largest = matrix.to_cols_array().into_iter().map(f64::abs).fold(0.0, f64::max);
            largest < MAX_ELEMENT && matrix.determinant().abs() > 1e-9
        };
        for light in &mut lights {
            if let Some(forward) = &mut light.to_xyz_d50 {
                // White is D50, whatever the rounding of the file.
                *forward = DMat3::from_diagonal(xyz(D50) / (*forward * DVec3::ONE)) * *forward;
            }
            let to_channels = light.calibration * light.from_xyz;
            if !(is_sound(&to_channels) && light.to_xyz_d50.as_ref().is_none_or(is_sound)) {
                return Err("its ColorMatrix or ForwardMatrix is singular or too large; expected matrices that tell three \
                            colours apart"
                    .to_owned());
            }
        }
        let (first, second) = match lights[..] {
            [] => return Err("it has no colour matrix; expected ColorMatrix1".to_owned()),
            [first, second, ..] => match (first.kelvin, second.kelvin) {
                (Some(a), Some(b)) if a != b => (first, Some((second, [a, b]))),
                (None, Some(_)) => (second, None),
                _ => (first, None),
            },
            [only] => (only, None),
        };
        Ok(Self { first, second, as_shot: as_shot.unwrap_or(Neutral::Light(D50)) })
    }

    /// Returns the channels of white as the picture was taken.
    pub(super) fn as_shot(&self) -> Option<DVec3> {
        match self.as_shot {
            Neutral::Channels(neutral) => Some(neutral),
            Neutral::Light(light) => self.neutral_of(light),
        }
    }

    /// Returns the matrices in light of these chromaticities, which are linear in the reciprocal of its temperature
    /// between those of both lights.
    fn at(&self, light: [f64; 2]) -> LightColours {
        let first = self.first;
        let Some((second, kelvins)) = self.second else { return first };
        let [at_first, at_second] = kelvins.map(f64::recip);
        let share = (colour_temperature(light).recip() - at_second) / (at_first - at_second);
        let share = share.clamp(0.0, 1.0);
        let between = |a: DMat3, b: DMat3| a * share + b * (1.0 - share);
        LightColours {
            kelvin: None,
            from_xyz: between(first.from_xyz, second.from_xyz),
            calibration: between(first.calibration, second.calibration),
            to_xyz_d50: match (first.to_xyz_d50, second.to_xyz_d50) {
                (Some(a), Some(b)) => Some(between(a, b)),
                (a, b) => a.or(b),
            },
        }
    }

    /// Returns the channels of white in light of these chromaticities.
    pub(super) fn neutral_of(&self, light: [f64; 2]) -> Option<DVec3> {
        let colours = self.at(light);
        let neutral = colours.calibration * colours.from_xyz * xyz(light);
        (neutral.is_finite() && neutral.min_element() > 0.0).then_some(neutral)
    }

    /// Returns the chromaticities of the light in which these channels are white: the matrices that find it are those in
    /// that light.
    fn light_of(&self, neutral: DVec3) -> Option<[f64; 2]> {
        let mut light = D50;
        for _ in 0..30 {
            let colours = self.at(light);
            let xyz = (colours.calibration * colours.from_xyz).inverse() * neutral;
            light = [xyz.x / xyz.element_sum(), xyz.y / xyz.element_sum()];
        }
        let [x, y] = light;
        (x > 0.0 && y > 0.0 && x + y < 1.0).then_some(light)
    }

    /// Returns the matrix from channels relative to those of white to linear sRGB, in which white is 1, and the
    /// chromaticities of the light.
    ///
    /// # Errors
    /// Returns an error if no light has these channels.
    pub(super) fn to_srgb(&self, neutral: DVec3) -> Result<(DMat3, [f64; 2]), DevelopError> {
        let light = self.light_of(neutral);
        let light = light.ok_or(DevelopError::NoWhite)?;
        let LightColours { from_xyz, calibration, to_xyz_d50, .. } = self.at(light);
        let screen = Primaries::SRGB;
        let to_channels = DMat3::from_diagonal(neutral);
        let matrix = match to_xyz_d50 {
            Some(forward) => {
                let of_model = calibration.inverse();
                let relative = DMat3::from_diagonal((of_model * neutral).recip());
                adapt(xyz(D50), screen.white_xyz()) * forward * relative * of_model * to_channels
            }
            None => {
                let to_xyz = (calibration * from_xyz).inverse();
                let white = to_xyz * neutral;
                adapt(white / white.y, screen.white_xyz())
                    * (to_xyz * (1.0 / white.y))
                    * to_channels
            }
        };
        let matrix = screen.to_xyz().inverse() * matrix;
        match matrix.is_finite() {
            true => Ok((matrix, light)),
            false => Err(DevelopError::NoWhite),
        }
    }
}

/// Returns X, Y and Z of chromaticities, with Y = 1.
fn xyz(white: [f64; 2]) -> DVec3 {
    Primaries { white, ..Primaries::SRGB }.white_xyz()
}

/// Returns the correlated colour temperature of chromaticities (K): McCamy, "Correlated color temperature as an explicit
/// function of chromaticity coordinates" (1992).
fn colour_temperature([x, y]: [f64; 2]) -> f64 {
    let n = (x - 0.3320) / (0.1858 - y);
    let kelvin = ((449.0 * n + 3525.0) * n + 6823.3) * n + 5520.33;
    // A fit of 2000 to 12500 K.
    if kelvin.is_finite() { kelvin.clamp(1000.0, 25_000.0) } else { 25_000.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A camera whose channels are X, Y and Z in tungsten, and sums of them in daylight.
    fn camera(forward: bool, as_shot: Option<Neutral>) -> CameraColours {
        let mixed = DMat3::from_cols_array(&[0.9, 0.1, 0.0, 0.2, 0.8, 0.1, 0.0, 0.1, 1.1]);
        let light = |kelvin, from_xyz: DMat3, light| LightColours {
            kelvin: Some(kelvin),
            from_xyz,
            calibration: DMat3::from_diagonal(DVec3::new(1.1, 1.0, 0.9)),
            to_xyz_d50: forward.then(|| {
                let neutral = from_xyz * xyz(light);
                // A file may have white a little beside D50.
                let off = DMat3::from_diagonal(DVec3::new(1.01, 1.0, 0.98));
                off * adapt(xyz(light), xyz(D50))
                    * from_xyz.inverse()
                    * DMat3::from_diagonal(neutral)
            }),
        };
        let lights = vec![
            light(2856.0, DMat3::IDENTITY, [0.4476, 0.4074]),
            light(6504.0, mixed, [0.3127, 0.3290]),
        ];
        CameraColours::new(lights, as_shot).unwrap()
    }

    #[test]
    fn white_is_white_and_the_light_of_a_white_balance_is_found_again() {
        for forward in [true, false] {
            let camera = camera(forward, None);
            for light in [[0.4476, 0.4074], [0.40, 0.39], D50, [0.3127, 0.3290], [0.29, 0.30]] {
                let neutral = camera.neutral_of(light).unwrap();
                let (matrix, found) = camera.to_srgb(neutral / neutral.max_element()).unwrap();
                let off = (0..2).map(|i| (found[i] - light[i]).abs()).fold(0.0, f64::max);
                assert!(off < 1e-6, "{found:?}, not {light:?}");
                let white = (matrix * DVec3::ONE - DVec3::ONE).abs().max_element();
                assert!(white < 1e-6, "{light:?}: {white}");
            }
        }
    }

    #[test]
    fn both_ways_of_the_specification_agree_in_the_lights_of_the_matrices() {
        for light in [[0.4476, 0.4074], [0.3127, 0.3290]] {
            let [a, b] = [true, false].map(|forward| {
                let camera = camera(forward, Some(Neutral::Light(light)));
                camera.to_srgb(camera.as_shot().unwrap()).unwrap().0
            });
            assert!(a.abs_diff_eq(b, 2e-3), "{a} and {b}");
        }
    }

    #[test]
    fn temperatures_are_those_of_the_illuminants() {
        for (light, kelvin) in
            [([0.4476, 0.4074], 2856.0), (D50, 5003.0), ([0.3127, 0.3290], 6504.0)]
        {
            let off = colour_temperature(light) / kelvin - 1.0;
            assert!(off.abs() < 0.003, "{kelvin}: {off}");
        }
        assert_eq!(colour_temperature([0.332, 0.1858]), 25_000.0);
    }

    #[test]
    fn singular_and_missing_matrices_are_refused() {
        let none = CameraColours::new(Vec::new(), None).unwrap_err();
        assert!(none.contains("no colour matrix"), "{none}");
        let flat = LightColours {
            kelvin: None,
            from_xyz: DMat3::from_cols(DVec3::ONE, DVec3::ONE, DVec3::X),
            calibration: DMat3::IDENTITY,
            to_xyz_d50: None,
        };
        assert!(CameraColours::new(vec![flat], None).unwrap_err().contains("singular"));
    }

    #[test]
    fn of_two_lights_the_known_one_is_kept() {
        let light = |kelvin, scale| LightColours {
            kelvin,
            from_xyz: DMat3::IDENTITY * scale,
            calibration: DMat3::IDENTITY,
            to_xyz_d50: None,
        };
        for (kelvins, kept) in [
            ([Some(2856.0), None], 1.0),
            ([None, Some(6504.0)], 2.0),
            ([None, None], 1.0),
            ([Some(5003.0); 2], 1.0),
        ] {
            let lights = vec![light(kelvins[0], 1.0), light(kelvins[1], 2.0)];
            let colours = CameraColours::new(lights, None).unwrap();
            assert_eq!(
                (colours.first.from_xyz.x_axis.x, colours.second),
                (kept, None),
                "{kelvins:?}"
            );
        }
    }
}
