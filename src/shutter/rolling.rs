//! Sensors that read one row after another.

use std::fmt;
use std::str::FromStr;

use super::duration::seconds;

/// Where the reading of rows goes in the picture as it is seen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Reading {
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

impl Reading {
    /// All of them, with their names.
    pub const ALL: [(Self, &'static str); 4] =
        [(Self::Down, "down"), (Self::Up, "up"), (Self::Left, "left"), (Self::Right, "right")];

    /// Its name.
    pub fn name(self) -> &'static str {
        Self::ALL[self as usize].1
    }

    /// The axis of the picture that is read along, and whether from its far end.
    pub fn axis(self) -> (usize, bool) {
        match self {
            Self::Down => (1, false),
            Self::Up => (1, true),
            Self::Left => (0, true),
            Self::Right => (0, false),
        }
    }
}

impl FromStr for Reading {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Self::ALL.iter().find(|(_, name)| *name == text);
        known
            .map(|(reading, _)| *reading)
            .ok_or_else(|| format!("expected down, up, left or right, found {text:?}"))
    }
}

/// How a sensor is read.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Rolling {
    /// From the first row of the whole picture to the last, s.
    pub time: f64,
    /// Which is the first.
    pub reading: Reading,
}

impl Rolling {
    /// When a pixel of a picture is read, from 0 for the first row to 1 for the last.
    #[inline(always)]
    pub fn turn(&self, pixel: [u32; 2], resolution: [u32; 2]) -> f64 {
        let (axis, back) = self.reading.axis();
        let last = resolution[axis] - 1;
        let place = if back { last - pixel[axis] } else { pixel[axis] };
        f64::from(place) / f64::from(last.max(1))
    }
}

impl FromStr for Rolling {
    type Err = String;

    /// Reads `TIME` or `TIME,down|up|left|right`.
    fn from_str(text: &str) -> Result<Self, String> {
        let (time, reading) = match text.split_once(',') {
            Some((time, reading)) => (time, reading.trim().parse()?),
            None => (text, Reading::default()),
        };
        let time = seconds(time)?;
        match time >= 0.0 {
            true => Ok(Self { time, reading }),
            false => Err(format!("expected 0 s or more, found {time} s")),
        }
    }
}

impl fmt::Display for Rolling {
    fn fmt(&self, to: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(to, "{}ms,{}", 1e3 * self.time, self.reading.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_read_in_their_order() {
        let turn = |text: &str, pixel| text.parse::<Rolling>().unwrap().turn(pixel, [5, 3]);
        assert_eq!(turn("20ms", [4, 0]), 0.0);
        assert_eq!([0, 1, 2].map(|y| turn("20ms,down", [3, y])), [0.0, 0.5, 1.0]);
        assert_eq!([0, 1, 2].map(|y| turn("20ms,up", [3, y])), [1.0, 0.5, 0.0]);
        assert_eq!([0, 1, 4].map(|x| turn("1/50, right", [x, 1])), [0.0, 0.25, 1.0]);
        assert_eq!([0, 1, 4].map(|x| turn("1/50, left", [x, 1])), [1.0, 0.75, 0.0]);
        let one = Rolling { time: 1.0, reading: Reading::Up };
        assert_eq!(one.turn([0, 0], [1, 1]), 0.0);
        assert_eq!("1/50,left".parse::<Rolling>().unwrap().to_string(), "20ms,left");
    }

    #[test]
    fn nonsense_is_refused() {
        for text in ["", "20ms,sideways", "-1ms", "20ms,down,up", "nan"] {
            assert!(text.parse::<Rolling>().unwrap_err().contains("expected"), "{text}");
        }
    }
}
