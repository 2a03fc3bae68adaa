//! White balance of files for display: the light that looks white.

use glam::{DMat3, DVec3};

use super::Picture;
use petzval_spectrum::{Primaries, Spectrum, adapt, d_illuminant, daylight, named_spectrum};

/// The light that files for display show as white, by adaptation of its cone responses to those of the
/// screen's white (Lam 1985, "Bradford"). It keeps the luminance of that light.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[non_exhaustive]
pub enum WhiteBalance {
    /// Colours as they are: white is that of sRGB, and in a raw file the white balance of the file.
    #[default]
    Off,
    /// The mean light of the picture, as if its world were grey in the mean. A pixel brighter than
    /// the white of the exposure counts as much as white.
    Auto,
    /// Light of these CIE 1931 chromaticities x and y.
    White([f64; 2]),
}

/// Bound of the elements of the matrix of an adaptation of X, Y, Z: it is 10 for the flame of a candle.
const LARGEST: f64 = 100.0;

impl WhiteBalance {
    /// Parses a colour temperature such as 3200K, an illuminant, chromaticities x,y, or auto. `none` is the word for
    /// [`WhiteBalance::Off`].
    ///
    /// # Errors
    /// Returns what was expected.
    pub fn parse(text: &str, none: &str) -> Result<Self, String> {
        let expected = || {
            format!(
                "expected a temperature from 1000K to 25000K, D50, D55, D65, D75, A, x,y, auto or {none}"
            )
        };
        let light = |spectrum: Spectrum| {
            let [x, y, z] = spectrum.to_xyz();
            Self::to_light([x, y].map(|v| v / (x + y + z)))
        };
        let white = match text {
            _ if text == none => return Ok(Self::Off),
            "auto" => return Ok(Self::Auto),
            "A" => named_spectrum("stdillum-A").and_then(light),
            "D50" => light(d_illuminant(5000.0)),
            "D55" => light(d_illuminant(5500.0)),
            "D65" => light(d_illuminant(6500.0)),
            "D75" => light(d_illuminant(7500.0)),
            _ => match text.strip_suffix(['K', 'k']) {
                Some(kelvin) => {
                    let kelvin = kelvin.trim().parse::<f64>().map_err(|_| expected())?;
                    (1000.0..=25_000.0).contains(&kelvin).then(|| light(daylight(kelvin))).flatten()
                }
                None => {
                    let [x, y] = text.split_once(',').map(Into::into).ok_or_else(expected)?;
                    let number = |word: &str| word.trim().parse::<f64>().map_err(|_| expected());
                    Self::to_light([number(x)?, number(y)?])
                }
            },
        };
        white.ok_or_else(expected)
    }

    /// Returns the white balance to a light of these chromaticities, or `None` if it is too far from
    /// white to be balanced.
    pub fn to_light(chromaticities: [f64; 2]) -> Option<Self> {
        matrix(chromaticities).map(|_| Self::White(chromaticities))
    }

    /// Replaces `Auto` by the white that it finds in a picture which is multiplied by a factor. The
    /// chromaticities have four decimals. A black picture has none.
    #[must_use]
    pub fn found(self, picture: &Picture, factor: f32) -> Self {
        if self != Self::Auto {
            return self;
        }
        let to_xyz = Primaries::SRGB.to_xyz();
        let mut sum = DVec3::ZERO;
        for pixel in &picture.pixels {
            let light = DVec3::from_array(pixel.map(f64::from)) * f64::from(factor);
            let xyz = to_xyz * light;
            if light.is_finite() && xyz.y > 0.0 {
                sum += xyz / xyz.y.max(1.0);
            }
        }
        let round = |v: f64| (v * 1e4).round() / 1e4;
        let whole = sum.element_sum();
        Self::to_light([round(sum.x / whole), round(sum.y / whole)]).unwrap_or(Self::Off)
    }

    /// Returns the matrix from linear sRGB to balanced linear sRGB. `Auto` is one that has not been
    /// found.
    pub(super) fn matrix(self) -> Option<DMat3> {
        match self {
            Self::Off | Self::Auto => None,
            Self::White(chromaticities) => matrix(chromaticities),
        }
    }
}

/// Returns the matrix from linear sRGB to linear sRGB that makes a light white.
fn matrix([x, y]: [f64; 2]) -> Option<DMat3> {
    let inside = x > 0.0 && y > 0.0 && x + y < 1.0;
    let light = Primaries { white: [x, y], ..Primaries::SRGB }.white_xyz();
    let to_xyz = Primaries::SRGB.to_xyz();
    let adapt = adapt(light, Primaries::SRGB.white_xyz());
    // The cone responses of imaginary or nearly monochromatic lights have no usable ratios.
    let elements = adapt.to_cols_array();
    let sound = adapt.determinant() > 0.0 && elements.iter().all(|element| element.abs() < LARGEST);
    (inside && sound).then(|| to_xyz.inverse() * adapt * to_xyz)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Chromaticities of a black body of 3200 K (CIE 015:2018).
    const TUNGSTEN: [f64; 2] = [0.4234, 0.3990];

    fn card(xy: [f64; 2], luminance: f64) -> Picture {
        let xyz = Primaries { white: xy, ..Primaries::SRGB }.white_xyz() * luminance;
        let light = (Primaries::SRGB.to_xyz().inverse() * xyz).to_array().map(|c| c as f32);
        Picture { size: [4, 1], pixels: vec![light; 4] }
    }

    fn balanced(white: WhiteBalance, picture: &Picture) -> [f32; 3] {
        let light = DVec3::from_array(picture.pixels[0].map(f64::from));
        white.matrix().map_or(light, |matrix| matrix * light).to_array().map(|c| c as f32)
    }

    #[test]
    fn a_grey_card_in_the_light_of_the_white_is_neutral_and_as_bright() {
        let picture = card(TUNGSTEN, 0.3);
        let given = WhiteBalance::to_light(TUNGSTEN).expect("a light");
        for white in [given, WhiteBalance::Auto.found(&picture, 1.0)] {
            let shown = balanced(white, &picture);
            assert!(shown.iter().all(|c| (c - 0.3).abs() < 1e-3), "{white:?}: {shown:?}");
        }
        let [r, _, b] = balanced(WhiteBalance::Off, &picture);
        assert!(r > 2.0 * b, "{r} and {b}");
    }

    #[test]
    fn a_neutral_picture_keeps_its_colours() {
        let white = WhiteBalance::Auto.found(&card(Primaries::SRGB.white, 0.3), 1.0);
        let shown = balanced(white, &Picture { size: [1, 1], pixels: vec![[0.6, 0.2, 0.1]] });
        for (shown, light) in shown.into_iter().zip([0.6, 0.2, 0.1]) {
            assert!((shown - light).abs() < 1e-3, "{white:?}: {shown}, not {light}");
        }
    }

    #[test]
    fn a_bright_lamp_counts_as_white_and_no_more() {
        let mut picture = card([0.3127, 0.3290], 0.2);
        picture.pixels[0] = card(TUNGSTEN, 1e6).pixels[0];
        let WhiteBalance::White([x, _]) = WhiteBalance::Auto.found(&picture, 1.0) else {
            panic!("a white")
        };
        assert!(x > 0.33 && x < 0.41, "{x}");
    }

    #[test]
    fn light_that_cannot_be_white_is_refused() {
        for xy in [[0.0, 0.0], [0.3, 0.0], [0.9, 0.4], [f64::NAN; 2], [0.17, 0.0048], [-0.1, 0.5]] {
            assert_eq!(WhiteBalance::to_light(xy), None, "{xy:?}");
        }
        let black = Picture { size: [2, 1], pixels: vec![[0.0; 3], [f32::NAN; 3]] };
        assert_eq!(WhiteBalance::Auto.found(&black, 1.0), WhiteBalance::Off);
    }
}
