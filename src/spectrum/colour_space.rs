//! RGB colour spaces, and their conversions to linear sRGB.

use std::sync::LazyLock;

use glam::{DMat3, DVec3};

use super::{Spectrum, d_illuminant, d65, named_spectrum};
use crate::primaries::{Primaries, adapt};

/// A colour space of linear red, green and blue; the spaces of pbrt-v4.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ColourSpace {
    /// ITU-R BT.709 primaries, white D65.
    #[default]
    Srgb,
    /// DCI-P3 primaries, white D65.
    DciP3,
    /// ITU-R BT.2020 primaries, white D65.
    Rec2020,
    /// ACES2065-1 (SMPTE ST 2065-1), white D60.
    Aces2065,
}

/// The matrices from a space to linear sRGB.
struct Conversion {
    /// For the colours of lights.
    light: DMat3,
    /// For the colours of surfaces, with chromatic adaptation.
    surface: DMat3,
}

static XYZ_FROM_SRGB: LazyLock<DMat3> = LazyLock::new(|| ColourSpace::Srgb.to_xyz());

static SRGB_FROM_XYZ: LazyLock<DMat3> = LazyLock::new(|| XYZ_FROM_SRGB.inverse());

static CONVERSIONS: LazyLock<[Conversion; 4]> =
    LazyLock::new(|| ColourSpace::ALL.map(ColourSpace::conversion));

/// Converts X, Y, Z to linear sRGB, which may be outside the gamut.
pub fn srgb_from_xyz(xyz: [f64; 3]) -> [f64; 3] {
    (*SRGB_FROM_XYZ * DVec3::from_array(xyz)).to_array()
}

/// Converts linear sRGB to X, Y, Z.
pub fn xyz_from_srgb(rgb: [f64; 3]) -> [f64; 3] {
    (*XYZ_FROM_SRGB * DVec3::from_array(rgb)).to_array()
}

/// Returns the matrix from linear sRGB to linear sRGB that makes daylight of a temperature (K) the
/// white of a space.
pub fn white_balance(kelvin: f64, space: ColourSpace) -> DMat3 {
    let from = DVec3::from_array(d_illuminant(kelvin).to_xyz());
    *SRGB_FROM_XYZ * adapt(from / from.y, space.white()) * *XYZ_FROM_SRGB
}

impl ColourSpace {
    const ALL: [Self; 4] = [Self::Srgb, Self::DciP3, Self::Rec2020, Self::Aces2065];

    /// The names of the spaces, in pbrt-v4's spelling.
    pub const NAMES: [&str; 4] = ["srgb", "dci-p3", "rec2020", "aces2065-1"];

    /// Returns the space of a name, ignoring case.
    pub fn from_name(name: &str) -> Option<Self> {
        let found = Self::NAMES.iter().position(|known| known.eq_ignore_ascii_case(name))?;
        Some(Self::ALL[found])
    }

    /// Converts the colour of a light to linear sRGB, which may be outside the gamut: (1, 1, 1) is
    /// the white of this space.
    pub fn light(self, rgb: [f64; 3]) -> [f64; 3] {
        self.convert(rgb, |conversion| &conversion.light)
    }

    /// Converts the colour of a surface to linear sRGB, which may be outside the gamut. It is
    /// adapted from white to white (Lam 1985, "Bradford"): (1, 1, 1), which reflects all light,
    /// becomes (1, 1, 1).
    pub fn surface(self, rgb: [f64; 3]) -> [f64; 3] {
        self.convert(rgb, |conversion| &conversion.surface)
    }

    fn convert(self, rgb: [f64; 3], matrix: impl Fn(&Conversion) -> &DMat3) -> [f64; 3] {
        if self == Self::Srgb {
            return rgb;
        }
        (*matrix(&CONVERSIONS[self as usize]) * DVec3::from_array(rgb)).to_array()
    }

    /// Returns the primaries and the white.
    pub fn primaries(self) -> Primaries {
        let [red, green, blue] = match self {
            Self::Srgb => [[0.64, 0.33], [0.3, 0.6], [0.15, 0.06]],
            // P3-D65, the variant of displays.
            Self::DciP3 => [[0.68, 0.32], [0.265, 0.690], [0.15, 0.06]],
            Self::Rec2020 => [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]],
            Self::Aces2065 => [[0.7347, 0.2653], [0.0, 1.0], [0.0001, -0.077]],
        };
        let white = self.white();
        let sum = white.element_sum();
        Primaries { red, green, blue, white: [white.x / sum, white.y / sum] }
    }

    /// Returns the matrix from RGB to X, Y, Z.
    fn to_xyz(self) -> DMat3 {
        self.primaries().with_white(self.white())
    }

    /// Returns X, Y, Z of the white, with Y = 1.
    pub(super) fn white(self) -> DVec3 {
        let xyz = DVec3::from_array(self.illuminant().to_xyz());
        xyz / xyz.y
    }

    /// Returns the spectrum of the white.
    pub(super) fn illuminant(self) -> Spectrum {
        match self {
            Self::Aces2065 => named_spectrum("illum-acesD60").unwrap_or(Spectrum::Constant(1.0)),
            _ => d65(),
        }
    }

    fn conversion(self) -> Conversion {
        let to_srgb = *SRGB_FROM_XYZ;
        let adapt = adapt(self.white(), Self::Srgb.white());
        let to_xyz = self.to_xyz();
        Conversion { light: to_srgb * to_xyz, surface: to_srgb * adapt * to_xyz }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_near(found: [f64; 3], expected: [f64; 3], within: f64, what: &str) {
        let off = (0..3).map(|i| (found[i] - expected[i]).abs()).fold(0.0, f64::max);
        assert!(off < within, "{what}: {found:?}, expected {expected:?}");
    }

    #[test]
    fn srgb_has_its_published_matrix() {
        // IEC 61966-2-1, whose white is rounded to four decimals.
        let expected =
            [[0.4124, 0.2126, 0.0193], [0.3576, 0.7152, 0.1192], [0.1805, 0.0722, 0.9505]];
        let found = ColourSpace::Srgb.to_xyz().to_cols_array_2d();
        for (found, expected) in found.into_iter().zip(expected) {
            assert_near(found, expected, 5e-4, "a primary of sRGB");
        }
    }

    #[test]
    fn other_primaries_have_their_published_coordinates_in_srgb() {
        // The products of the published matrices, by channel of the wider space.
        let p3 = [[1.2249, -0.0420, -0.0196], [-0.2249, 1.0420, -0.0786], [0.0, 0.0, 1.0982]];
        let bt2020 =
            [[1.6605, -0.1246, -0.0182], [-0.5876, 1.1329, -0.1006], [-0.0728, -0.0083, 1.1187]];
        for (space, expected) in [(ColourSpace::DciP3, p3), (ColourSpace::Rec2020, bt2020)] {
            for channel in 0..3 {
                let mut rgb = [0.0; 3];
                rgb[channel] = 1.0;
                assert_near(space.light(rgb), expected[channel], 5e-4, "light");
                assert_near(space.surface(rgb), expected[channel], 5e-4, "surface");
            }
        }
    }

    #[test]
    fn white_is_white_on_a_surface_and_the_white_of_its_space_in_a_light() {
        for space in ColourSpace::ALL {
            assert_near(space.surface([1.0; 3]), [1.0; 3], 1e-12, "a white surface");
        }
        for space in [ColourSpace::Srgb, ColourSpace::DciP3, ColourSpace::Rec2020] {
            assert_near(space.light([1.0; 3]), [1.0; 3], 1e-12, "a white light");
        }
        // The white point of ACES, (0.32168, 0.33767), in sRGB: redder than D65.
        let [x, y] = [0.32168, 0.33767];
        let white = srgb_from_xyz([x / y, 1.0, (1.0 - x - y) / y]);
        assert_near(ColourSpace::Aces2065.light([1.0; 3]), white, 2e-3, "the white of ACES");
        assert!(white[0] > 1.03 && white[2] < 0.95);
    }

    #[test]
    fn every_space_converts_a_colour_back() {
        for space in ColourSpace::ALL {
            let srgb = DVec3::new(0.7, 0.4, 0.2);
            let there = space.to_xyz().inverse() * ColourSpace::Srgb.to_xyz() * srgb;
            assert_near(space.light(there.to_array()), srgb.to_array(), 1e-12, "a round trip");
        }
    }

    #[test]
    fn the_constant_of_srgb_is_this_space() {
        let found = ColourSpace::Srgb.primaries();
        let pairs = found.coordinates().into_iter().zip(Primaries::SRGB.coordinates());
        for (found, expected) in pairs {
            assert!((0..2).all(|i| (found[i] - expected[i]).abs() < 2e-6), "{found:?}");
        }
    }

    #[test]
    fn names_are_found_in_any_case() {
        assert_eq!(ColourSpace::from_name("ACES2065-1"), Some(ColourSpace::Aces2065));
        assert_eq!(ColourSpace::from_name("Rec2020"), Some(ColourSpace::Rec2020));
        assert_eq!(ColourSpace::from_name("rec709"), None);
    }
}
