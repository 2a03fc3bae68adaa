//! Bayer patterns: the colour filters in front of a sensor (Bayer 1976, US patent 3,971,065).

use std::fmt;
use std::str::FromStr;

/// The filters of two by two pixels, named in reading order.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Bayer {
    /// Red and green, green and blue.
    #[default]
    Rggb,
    /// Blue and green, green and red.
    Bggr,
    /// Green and red, blue and green.
    Grbg,
    /// Green and blue, red and green.
    Gbrg,
}

impl Bayer {
    /// All patterns.
    pub const ALL: [Self; 4] = [Self::Rggb, Self::Bggr, Self::Grbg, Self::Gbrg];

    /// Returns its name: the filters in reading order.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rggb => "rggb",
            Self::Bggr => "bggr",
            Self::Grbg => "grbg",
            Self::Gbrg => "gbrg",
        }
    }

    /// Returns the channel that a pixel of the frame sees: 0 red, 1 green, 2 blue.
    #[inline(always)]
    pub fn channel(self, [x, y]: [u32; 2]) -> usize {
        let place = (y & 1) * 2 + (x & 1);
        match self.name().as_bytes()[place as usize] {
            b'r' => 0,
            b'g' => 1,
            _ => 2,
        }
    }
}

impl FromStr for Bayer {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|bayer| bayer.name() == text);
        found.ok_or_else(|| format!("expected rggb, bggr, grbg or gbrg, found {text:?}"))
    }
}

impl fmt::Display for Bayer {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(self.name())
    }
}
