//! Primaries and white of an RGB colour space, and the matrices between such spaces.

use glam::{DMat3, DVec3};

/// CIE 1931 chromaticities x and y of a linear RGB space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Primaries {
    /// Red.
    pub red: [f64; 2],
    /// Green.
    pub green: [f64; 2],
    /// Blue.
    pub blue: [f64; 2],
    /// The sum of one unit of each.
    pub white: [f64; 2],
}

/// Largest difference of coordinates of the same primaries: files and standards round them.
const SAME: f64 = 1e-3;

impl Primaries {
    /// sRGB (IEC 61966-2-1), the space of all calculations. Its white is that of the CIE's table of
    /// D65, which the standard rounds to four decimals.
    pub const SRGB: Self = Self {
        red: [0.64, 0.33],
        green: [0.3, 0.6],
        blue: [0.15, 0.06],
        white: [0.312_742, 0.329_040],
    };

    /// Returns the coordinates red, green, blue and white.
    pub fn coordinates(&self) -> [[f64; 2]; 4] {
        [self.red, self.green, self.blue, self.white]
    }

    /// Returns whether two spaces are the same, within the rounding of files.
    pub fn is_near(&self, other: &Self) -> bool {
        let [these, those] = [self, other].map(Self::coordinates);
        these.as_flattened().iter().zip(those.as_flattened()).all(|(a, b)| (a - b).abs() <= SAME)
    }

    /// Returns X, Y, Z of the white, with Y = 1.
    pub fn white_xyz(&self) -> DVec3 {
        xyz(self.white)
    }

    /// Returns the matrix from RGB to X, Y, Z.
    pub fn to_xyz(&self) -> DMat3 {
        self.with_white(self.white_xyz())
    }

    /// Returns the matrix from RGB to X, Y, Z with this white: the primaries, scaled so that their
    /// sum is white.
    pub(crate) fn with_white(&self, white: DVec3) -> DMat3 {
        let primaries = DMat3::from_cols(xyz(self.red), xyz(self.green), xyz(self.blue));
        primaries * DMat3::from_diagonal(primaries.inverse() * white)
    }

    /// Returns the matrix from this space to another that preserves X, Y, Z, or `None` if the
    /// coordinates span no space.
    pub fn to(&self, other: &Self) -> Option<DMat3> {
        sound(other.to_xyz().inverse() * self.to_xyz())
    }

    /// Returns the matrix from this space to another that makes this white the other's white, or
    /// `None` if the coordinates span no space.
    pub fn adapted_to(&self, other: &Self) -> Option<DMat3> {
        let adapt = adapt(self.white_xyz(), other.white_xyz());
        sound(other.to_xyz().inverse() * adapt * self.to_xyz())
    }
}

fn sound(matrix: DMat3) -> Option<DMat3> {
    (matrix.is_finite() && matrix.determinant().abs() > 1e-9).then_some(matrix)
}

/// Returns X, Y, Z with Y = 1. Coordinates with y = 0 give infinity.
fn xyz([x, y]: [f64; 2]) -> DVec3 {
    DVec3::new(x / y, 1.0, (1.0 - x - y) / y)
}

/// Returns the matrix that adapts X, Y, Z from one white point to another (Lam 1985, "Bradford").
/// Both have Y = 1.
pub fn adapt(from: DVec3, to: DVec3) -> DMat3 {
    let cones = DMat3::from_cols_array_2d(&[
        [0.8951, -0.7502, 0.0389],
        [0.2664, 1.7135, -0.0685],
        [-0.1614, 0.0367, 1.0296],
    ]);
    cones.inverse() * DMat3::from_diagonal((cones * to) / (cones * from)) * cones
}

#[cfg(test)]
mod tests {
    use super::*;

    /// ACES2065-1 (SMPTE ST 2065-1).
    const ACES: Primaries = Primaries {
        red: [0.7347, 0.2653],
        green: [0.0, 1.0],
        blue: [0.0001, -0.077],
        white: [0.32168, 0.33767],
    };

    #[test]
    fn matrices_there_and_back_are_inverse_and_keep_white_as_they_say() {
        let there = Primaries::SRGB.to(&ACES).unwrap();
        let back = ACES.to(&Primaries::SRGB).unwrap();
        assert!((there * back).abs_diff_eq(DMat3::IDENTITY, 1e-9));
        let white = ACES.adapted_to(&Primaries::SRGB).unwrap() * DVec3::ONE;
        assert!(white.abs_diff_eq(DVec3::ONE, 1e-9), "{white}");
        // Without adaptation, D65 is bluer than the white of ACES.
        let daylight = there * DVec3::ONE;
        assert!(daylight.z > 1.05 && daylight.x < 1.0, "{daylight}");
    }

    #[test]
    fn the_matrix_to_aces_is_the_published_one() {
        // SMPTE ST 2065-1 with Bradford's adaptation, as the Academy's transform publishes it.
        let expected = [
            [0.439_632_98, 0.089_776_44, 0.017_541_17],
            [0.382_988_70, 0.813_439_43, 0.111_546_55],
            [0.177_378_32, 0.096_784_13, 0.870_912_28],
        ];
        let found = Primaries::SRGB.adapted_to(&ACES).unwrap();
        assert!(found.abs_diff_eq(DMat3::from_cols_array_2d(&expected), 5e-4), "{found}");
    }

    #[test]
    fn coordinates_that_span_no_space_have_no_matrix() {
        let flat = Primaries { green: Primaries::SRGB.red, ..Primaries::SRGB };
        assert!(flat.to(&Primaries::SRGB).is_none() && Primaries::SRGB.to(&flat).is_none());
        let dark = Primaries { white: [0.3, 0.0], ..Primaries::SRGB };
        assert!(dark.adapted_to(&Primaries::SRGB).is_none());
    }

    #[test]
    fn rounded_coordinates_are_the_same_space() {
        let rounded = Primaries { white: [0.3127, 0.3290], ..Primaries::SRGB };
        assert!(rounded.is_near(&Primaries::SRGB) && !ACES.is_near(&Primaries::SRGB));
    }
}
