//! Bayer patterns: the colour filters in front of a sensor (Bayer 1976, US patent 3,971,065), and quad Bayer patterns, whose
//! filters cover two by two photosites each.

use std::fmt;
use std::str::FromStr;

/// The filters of two by two pixels, named in reading order, or of four by four.
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
    /// [`Self::Rggb`] with filters of two by two pixels.
    QuadRggb,
    /// [`Self::Bggr`] with filters of two by two pixels.
    QuadBggr,
    /// [`Self::Grbg`] with filters of two by two pixels.
    QuadGrbg,
    /// [`Self::Gbrg`] with filters of two by two pixels.
    QuadGbrg,
}

impl Bayer {
    /// All patterns.
    pub const ALL: [Self; 8] = [
        Self::Rggb,
        Self::Bggr,
        Self::Grbg,
        Self::Gbrg,
        Self::QuadRggb,
        Self::QuadBggr,
        Self::QuadGrbg,
        Self::QuadGbrg,
    ];

    /// Returns its name: the filters in reading order.
    pub fn name(self) -> &'static str {
        match self {
            Self::Rggb => "rggb",
            Self::Bggr => "bggr",
            Self::Grbg => "grbg",
            Self::Gbrg => "gbrg",
            Self::QuadRggb => "quad-rggb",
            Self::QuadBggr => "quad-bggr",
            Self::QuadGrbg => "quad-grbg",
            Self::QuadGbrg => "quad-gbrg",
        }
    }

    /// Returns whether a filter covers two by two pixels.
    pub fn is_quad(self) -> bool {
        matches!(self, Self::QuadRggb | Self::QuadBggr | Self::QuadGrbg | Self::QuadGbrg)
    }

    /// Returns the channel that a pixel of the frame sees: 0 red, 1 green, 2 blue.
    #[inline(always)]
    pub fn channel(self, [x, y]: [u32; 2]) -> usize {
        let shift = u32::from(self.is_quad());
        let place = (y >> shift & 1) * 2 + (x >> shift & 1);
        let channels = match self {
            Self::Rggb | Self::QuadRggb => [0, 1, 1, 2],
            Self::Bggr | Self::QuadBggr => [2, 1, 1, 0],
            Self::Grbg | Self::QuadGrbg => [1, 0, 2, 1],
            Self::Gbrg | Self::QuadGbrg => [1, 2, 0, 1],
        };
        channels[place as usize]
    }
}

impl FromStr for Bayer {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let found = Self::ALL.into_iter().find(|bayer| bayer.name() == text);
        found.ok_or_else(|| {
            format!("expected rggb, bggr, grbg or gbrg, or quad- before them, found {text:?}")
        })
    }
}

impl fmt::Display for Bayer {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        to.write_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_those_of_the_name() {
        for bayer in Bayer::ALL {
            assert_eq!(bayer.name().parse(), Ok(bayer));
            let side = if bayer.is_quad() { 2 } else { 1 };
            let name = bayer.name().trim_start_matches("quad-").as_bytes();
            for (x, y) in (0..9).flat_map(|y| (0..9).map(move |x| (x, y))) {
                let letter = name[(y / side % 2 * 2 + x / side % 2) as usize];
                assert_eq!(bayer.channel([x, y]), "rgb".find(char::from(letter)).unwrap());
            }
        }
        assert!("quad".parse::<Bayer>().is_err());
    }
}
