//! Variables of an optimization.

use std::fmt;

use petzval_lens::Prescription;
use petzval_spectrum::Glass;

/// Least thickness that a variable takes without a stated bound (mm).
const LEAST_THICKNESS: f64 = 0.1;
/// Range of an index without a stated bound.
const INDEX_RANGE: [f64; 2] = [1.3, 2.2];

/// Quantity of a row that a variable changes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum VariableKind {
    /// Curvature, shown as a radius (mm).
    Radius,
    /// Curvature (1/mm).
    Curvature,
    /// Distance to the next vertex (mm).
    Thickness,
    /// Conic constant.
    Conic,
    /// Coefficient of a power of the asphere.
    Asphere(u32),
    /// Index of a medium without a name, at the d line.
    Index,
    /// Distance from the rear vertex to the film (mm); the row is the last one.
    Film,
}

/// A variable with its bounds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DesignVariable {
    /// Kind.
    pub kind: VariableKind,
    /// Row, from 0.
    pub row: usize,
    /// Smallest and largest value: a curvature for a radius.
    pub bounds: [f64; 2],
}

/// Why a variable is refused.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("variable {name}: {found}; {expected}")]
pub struct VariableError {
    /// Name of the variable.
    pub name: String,
    /// The problem.
    pub found: String,
    /// The expectation, and the remedy.
    pub expected: String,
}

impl DesignVariable {
    /// Names of variables, for messages.
    pub const NAMES: &'static str = "expected r3 (radius of surface 3), c3 (curvature), t3 (thickness behind it), k3 \
        (conic), a3_6 (asphere coefficient of power 6), n3 (index behind it) or film (its distance)";

    /// Finds a variable of a lens by its name.
    ///
    /// # Errors
    /// Returns an error if the name is unknown, or if the lens has no such quantity to change.
    pub fn named(name: &str, lens: &Prescription) -> Result<Self, VariableError> {
        let error = |found: &str, expected: &str| VariableError {
            name: name.to_owned(),
            found: found.to_owned(),
            expected: expected.to_owned(),
        };
        let count = lens.rows.len();
        let free = [f64::NEG_INFINITY, f64::INFINITY];
        if name == "film" {
            let bounds = [0.0, f64::INFINITY];
            return Ok(Self { kind: VariableKind::Film, row: count - 1, bounds });
        }
        let mut letters = name.chars();
        let letter = letters.next().unwrap_or(' ');
        let (number, power) = match letters.as_str().split_once('_') {
            Some((number, power)) => (number, Some(power)),
            None => (letters.as_str(), None),
        };
        let kind = match (letter, power.map(str::parse)) {
            ('r', None) => VariableKind::Radius,
            ('c', None) => VariableKind::Curvature,
            ('t', None) => VariableKind::Thickness,
            ('k', None) => VariableKind::Conic,
            ('n', None) => VariableKind::Index,
            ('a', Some(Ok(power))) if (2..=20).contains(&power) => VariableKind::Asphere(power),
            ('a', _) => {
                return Err(error("no power from 2 to 20", "write a3_6 for the term of h^6"));
            }
            _ => return Err(error("no such quantity", Self::NAMES)),
        };
        let row = match number.parse::<usize>() {
            Ok(number) if (1..=count).contains(&number) => number - 1,
            _ => {
                let found = format!("no surface \"{number}\"");
                return Err(error(&found, &format!("expected a surface from 1 to {count}")));
            }
        };
        let surface = &lens.rows[row];
        let flat = surface.index == lens.index_before(row) && !surface.mirror;
        let bounds = match kind {
            VariableKind::Thickness if row + 1 == count => {
                return Err(error(
                    "the last surface has no thickness",
                    "vary film, the distance of the film behind it",
                ));
            }
            VariableKind::Thickness => match surface.thickness < 0.0 {
                true => [f64::NEG_INFINITY, -LEAST_THICKNESS],
                false => [LEAST_THICKNESS.min(surface.thickness), f64::INFINITY],
            },
            VariableKind::Index => match (&surface.glass, surface.mirror) {
                (Glass::Constant | Glass::Abbe { .. }, false) if surface.index != 1.0 => {
                    INDEX_RANGE
                }
                (Glass::Catalogue(glass), false) => {
                    let found = format!("the glass {} has a fixed index", glass.full_name());
                    return Err(error(&found, "give the surface index and abbe instead of glass"));
                }
                _ => return Err(error("no medium whose index can change", Self::NAMES)),
            },
            _ if flat => {
                return Err(error(
                    "the surface does not refract",
                    "vary a surface between two media, or a mirror",
                ));
            }
            VariableKind::Conic if surface.is_plane() => {
                return Err(error("a plane has no conic", "vary its radius or give it one"));
            }
            _ => free,
        };
        Ok(Self { kind, row, bounds })
    }

    /// Returns the value in a lens with a film at this distance (mm).
    pub fn value(&self, lens: &Prescription, film: f64) -> f64 {
        let row = &lens.rows[self.row];
        match self.kind {
            VariableKind::Radius | VariableKind::Curvature => row.curvature(),
            VariableKind::Thickness => row.thickness,
            VariableKind::Conic => row.conic,
            VariableKind::Asphere(power) => {
                row.asphere.iter().find(|(p, _)| *p == power).map_or(0.0, |(_, a)| *a)
            }
            VariableKind::Index => row.index,
            VariableKind::Film => film,
        }
    }

    /// Gives the value to a lens and its film.
    pub(super) fn set(&self, lens: &mut Prescription, film: &mut f64, value: f64) {
        let row = &mut lens.rows[self.row];
        match self.kind {
            VariableKind::Radius | VariableKind::Curvature => row.radius = value.recip(),
            VariableKind::Thickness => row.thickness = value,
            VariableKind::Conic => row.conic = value,
            VariableKind::Asphere(power) => {
                match row.asphere.iter_mut().find(|(p, _)| *p == power) {
                    Some((_, a)) => *a = value,
                    None if value != 0.0 => {
                        row.asphere.push((power, value));
                        row.asphere.sort_by_key(|(p, _)| *p);
                    }
                    None => {}
                }
            }
            VariableKind::Index => {
                row.index = value;
                if let Glass::Abbe { vd, .. } = row.glass {
                    row.glass = Glass::Abbe { nd: value, vd };
                }
            }
            VariableKind::Film => *film = value,
        }
    }

    /// Returns the step of finite differences: about a nanometre of sag or path at the rim.
    pub(super) fn step(&self, lens: &Prescription) -> f64 {
        const SAG: f64 = 1e-6;
        let row = &lens.rows[self.row];
        let half = (row.diameter / 2.0).max(1e-3);
        match self.kind {
            VariableKind::Radius | VariableKind::Curvature => 2.0 * SAG / (half * half),
            VariableKind::Thickness | VariableKind::Film => 10.0 * SAG,
            VariableKind::Conic => {
                let sag = row.curvature().abs().powi(3) * half.powi(4) / 8.0;
                (SAG / sag).clamp(1e-6, 1e-2)
            }
            VariableKind::Asphere(power) => SAG / half.powi(power as i32),
            VariableKind::Index => 1e-6,
        }
    }

    /// Returns a value as it is shown: the radius of a curvature.
    pub fn shown(&self, value: f64) -> f64 {
        if self.kind == VariableKind::Radius { value.recip() } else { value }
    }
}

impl fmt::Display for DesignVariable {
    /// Writes the name.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let number = self.row + 1;
        match self.kind {
            VariableKind::Radius => write!(f, "r{number}"),
            VariableKind::Curvature => write!(f, "c{number}"),
            VariableKind::Thickness => write!(f, "t{number}"),
            VariableKind::Conic => write!(f, "k{number}"),
            VariableKind::Asphere(power) => write!(f, "a{number}_{power}"),
            VariableKind::Index => write!(f, "n{number}"),
            VariableKind::Film => write!(f, "film"),
        }
    }
}
