//! Decentres and tilts of CODE V surfaces.

use glam::DAffine3;

use super::super::axis::{decentre_then_tilt, tilt_then_decentre};
use super::CodeVWord;
use petzval_lens::LensError;

/// Use of the decentre of a surface.
#[derive(Clone, Copy, Default, PartialEq)]
enum Kind {
    /// The axis goes on from the decentred surface.
    #[default]
    Basic,
    /// The axis goes on as before the surface (`DAR`).
    Return,
    /// The reverse change behind the surface (`REV`).
    Reverse,
    /// The axis is tilted again behind a mirror (`BEN`).
    Bend,
}

/// Decentre (units of the file) and tilt (degrees; left-handed about x and y) of a surface.
#[derive(Default)]
pub(super) struct Decentre {
    shift: [f64; 3],
    tilt: [f64; 3],
    kind: Kind,
    /// Surface to whose axes this one returns (`RET`).
    pub back_to: Option<usize>,
}

impl Decentre {
    /// Reads a command; returns whether it is one of decentre or tilt.
    pub fn read(
        &mut self,
        command: &CodeVWord,
        keyword: &str,
        values: &[CodeVWord],
        target: Option<usize>,
    ) -> Result<bool, LensError> {
        let number = || match values.first() {
            Some(word) => word.number(),
            None => Err(command.error(format!("{keyword} without a value"), "expected a number")),
        };
        match keyword {
            "XDE" => self.shift[0] = number()?,
            "YDE" => self.shift[1] = number()?,
            "ZDE" => self.shift[2] = number()?,
            "ADE" => self.tilt[0] = number()?,
            "BDE" => self.tilt[1] = number()?,
            "CDE" => self.tilt[2] = number()?,
            "DAR" => self.kind = Kind::Return,
            "REV" => self.kind = Kind::Reverse,
            "BEN" => self.kind = Kind::Bend,
            "RET" => self.back_to = target,
            _ => return Ok(false),
        }
        Ok(true)
    }

    /// Returns the changes of the axis before and behind the surface.
    pub fn changes(&self, unit: f64) -> [Option<DAffine3>; 2] {
        let still = self.shift == [0.0; 3] && self.tilt == [0.0; 3];
        if still {
            return [None; 2];
        }
        let shift = self.shift.map(|v| v * unit);
        let [a, b, c] = self.tilt;
        let tilt = [-a, -b, c];
        let before = decentre_then_tilt(shift, tilt);
        match self.kind {
            Kind::Basic => [Some(before), None],
            Kind::Return => [Some(before), Some(before.inverse())],
            Kind::Reverse => {
                let back = tilt_then_decentre(shift.map(|v| -v), tilt.map(|v| -v));
                [None, Some(back)]
            }
            Kind::Bend => [Some(before), Some(decentre_then_tilt([0.0; 3], tilt))],
        }
    }
}

/// Axes of the surfaces so far, relative to those of the first.
#[derive(Default)]
pub(super) struct Frames {
    /// Axes of the next surface before its decentre.
    pub next: DAffine3,
    /// Axes of each surface with its decentre, by its number from 1.
    pub surfaces: Vec<DAffine3>,
}
