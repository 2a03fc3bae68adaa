//! Rolling shutter: sensors that read one row after another.

use std::fmt;
use std::str::FromStr;

use super::duration::parse_seconds;

/// Direction of the readout in the picture as it is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum ReadoutDirection {
    /// From the top row to the bottom one, as most cameras do.
    #[default]
    Down,
    /// From the bottom row to the top one.
    Up,
    /// From the rightmost column to the leftmost one.
    Left,
    /// From the leftmost column to the rightmost one.
    Right,
}

impl ReadoutDirection {
    /// All directions with their names.
    pub const ALL: [(Self, &'static str); 4] =
        [(Self::Down, "down"), (Self::Up, "up"), (Self::Left, "left"), (Self::Right, "right")];

    /// Returns its name.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }
}

impl FromStr for ReadoutDirection {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Self::ALL.iter().find(|(_, name)| *name == text);
        known
            .map(|(direction, _)| *direction)
            .ok_or_else(|| format!("expected down, up, left or right, found {text:?}"))
    }
}

/// Readout of a sensor row by row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RollingShutter {
    /// Time from the first row of the whole picture to the last, s.
    pub time: f64,
    /// Direction of the readout, which says which row is first.
    pub direction: ReadoutDirection,
}

impl RollingShutter {
    /// Returns when a pixel is read: 0 in the first row to 1 in the last.
    #[inline(always)]
    pub fn readout_fraction(&self, pixel: [u32; 2], resolution: [u32; 2]) -> f64 {
        let (axis, reversed) = match self.direction {
            ReadoutDirection::Down => (1, false),
            ReadoutDirection::Up => (1, true),
            ReadoutDirection::Left => (0, true),
            ReadoutDirection::Right => (0, false),
        };
        let last = resolution[axis] - 1;
        let place = if reversed { last - pixel[axis] } else { pixel[axis] };
        f64::from(place) / f64::from(last.max(1))
    }
}

impl FromStr for RollingShutter {
    type Err = String;

    /// Parses `TIME` or `TIME,down|up|left|right`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (time, direction) = match text.split_once(',') {
            Some((time, direction)) => (time, direction.trim().parse()?),
            None => (text, ReadoutDirection::default()),
        };
        let time = parse_seconds(time)?;
        match time >= 0.0 {
            true => Ok(Self { time, direction }),
            false => Err(format!("expected 0 s or more, found {time} s")),
        }
    }
}

impl fmt::Display for RollingShutter {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{}ms,{}", 1e3 * self.time, self.direction.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_in_the_given_direction() {
        let turn = |text: &str, pixel| {
            text.parse::<RollingShutter>().unwrap().readout_fraction(pixel, [5, 3])
        };
        assert_eq!(turn("20ms", [4, 0]), 0.0);
        assert_eq!([0, 1, 2].map(|y| turn("20ms,down", [3, y])), [0.0, 0.5, 1.0]);
        assert_eq!([0, 1, 2].map(|y| turn("20ms,up", [3, y])), [1.0, 0.5, 0.0]);
        assert_eq!([0, 1, 4].map(|x| turn("1/50, right", [x, 1])), [0.0, 0.25, 1.0]);
        assert_eq!([0, 1, 4].map(|x| turn("1/50, left", [x, 1])), [1.0, 0.75, 0.0]);
        let one = RollingShutter { time: 1.0, direction: ReadoutDirection::Up };
        assert_eq!(one.readout_fraction([0, 0], [1, 1]), 0.0);
        assert_eq!("1/50,left".parse::<RollingShutter>().unwrap().to_string(), "20ms,left");
    }

    #[test]
    fn invalid_text_is_refused() {
        for text in ["", "20ms,sideways", "-1ms", "20ms,down,up", "nan"] {
            assert!(text.parse::<RollingShutter>().unwrap_err().contains("expected"), "{text}");
        }
    }
}
