//! Targets of an optimization.

use std::fmt;
use std::str::FromStr;

/// Quantity with a target.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TargetKind {
    /// Focal length at the primary wavelength (mm).
    FocalLength,
    /// Root mean square spot radius over all fields (mm).
    Spot,
    /// Distortion of the largest field (percent).
    Distortion,
    /// Paraxial back focal distance at the primary wavelength (mm).
    BackFocalDistance,
    /// Distance from the rear vertex to the film (mm).
    FilmDistance,
}

/// A target with its weight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DesignTarget {
    /// Quantity.
    pub kind: TargetKind,
    /// Wanted value, in the unit of the quantity.
    pub value: f64,
    /// Weight of the square of the deviation (1/mm^2). A distortion counts as the error of the
    /// image height, in mm.
    pub weight: f64,
}

impl TargetKind {
    /// All kinds with their names.
    pub const NAMES: [(&str, Self); 5] = [
        ("efl", Self::FocalLength),
        ("spot", Self::Spot),
        ("distortion", Self::Distortion),
        ("bfd", Self::BackFocalDistance),
        ("film", Self::FilmDistance),
    ];

    /// Returns the unit.
    pub fn unit(self) -> &'static str {
        if self == Self::Distortion { "%" } else { "mm" }
    }
}

impl fmt::Display for TargetKind {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let name = Self::NAMES.iter().find(|(_, kind)| kind == self);
        f.write_str(name.map_or("", |(name, _)| name))
    }
}

impl FromStr for DesignTarget {
    type Err = String;

    /// Reads `NAME`, `NAME=VALUE` or `NAME=VALUE:WEIGHT`.
    fn from_str(text: &str) -> Result<Self, String> {
        const EXPECTED: &str = "expected efl=MM, spot, distortion=PERCENT, bfd=MM or film=MM, and \
                                :WEIGHT behind it for another weight than 1";
        let (text, weight) = match text.split_once(':') {
            Some((text, weight)) => {
                let weight = weight.parse().ok().filter(|w: &f64| *w > 0.0 && w.is_finite());
                (text, weight.ok_or("expected a weight above 0")?)
            }
            None => (text, 1.0),
        };
        let (name, value) = match text.split_once('=') {
            Some((name, value)) => {
                let value = value.parse().ok().filter(|v: &f64| v.is_finite());
                (name, Some(value.ok_or(EXPECTED)?))
            }
            None => (text, None),
        };
        let named = TargetKind::NAMES.iter().find(|(known, _)| *known == name);
        let (_, kind) = named.ok_or(EXPECTED)?;
        let value = match (kind, value) {
            (TargetKind::Spot, Some(value)) if value != 0.0 => {
                return Err("the target of a spot is 0: write spot".to_owned());
            }
            (TargetKind::Spot | TargetKind::Distortion, None) => 0.0,
            (_, Some(value)) => value,
            (_, None) => return Err(format!("{name} needs a value: {EXPECTED}")),
        };
        Ok(Self { kind: *kind, value, weight })
    }
}
