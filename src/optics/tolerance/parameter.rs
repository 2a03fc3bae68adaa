//! Quantities of a lens that have tolerances.

use std::fmt;

use super::element::{elements, media};
use super::grade::{RadiusLimit, ToleranceLimits};
use petzval_lens::Prescription;

/// Kind of a quantity. The deviations are in its unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ToleranceKind {
    /// Radius of a surface (percent).
    RadiusPercent,
    /// Radius of a surface (fringe spacings).
    RadiusFringes,
    /// Thickness behind a surface (mm).
    Thickness,
    /// Index of a medium at the d line.
    Index,
    /// Abbe number of a medium (percent).
    Abbe,
    /// Tilt of an element about x (0) or y (1) (arc minutes).
    ElementTilt(usize),
    /// Decentre of an element along x (0) or y (1) (mm).
    ElementDecentre(usize),
    /// Tilt of a surface about x (0) or y (1) (arc minutes).
    SurfaceTilt(usize),
}

/// A quantity of a lens with its tolerance.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ToleranceParameter {
    /// Kind of the quantity.
    pub kind: ToleranceKind,
    /// First and last row that it concerns, from 0.
    pub rows: [usize; 2],
    /// Largest deviation to either side, in the unit of the kind.
    pub limit: f64,
}

impl ToleranceKind {
    /// Returns the unit of the deviations; empty for an index.
    pub fn unit(self) -> &'static str {
        match self {
            Self::RadiusPercent | Self::Abbe => "%",
            Self::RadiusFringes => "fringes",
            Self::Thickness | Self::ElementDecentre(_) => "mm",
            Self::Index => "",
            Self::ElementTilt(_) | Self::SurfaceTilt(_) => "arcmin",
        }
    }
}

impl fmt::Display for ToleranceParameter {
    /// Names the quantity, with surfaces from 1: `radius 3`, `decentre y 1-2`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let axis = |axis: usize| ["x", "y"][axis];
        match self.kind {
            ToleranceKind::RadiusPercent | ToleranceKind::RadiusFringes => write!(f, "radius"),
            ToleranceKind::Thickness => write!(f, "thickness"),
            ToleranceKind::Index => write!(f, "index"),
            ToleranceKind::Abbe => write!(f, "Abbe number"),
            ToleranceKind::ElementTilt(a) => write!(f, "element tilt {}", axis(a)),
            ToleranceKind::ElementDecentre(a) => write!(f, "element decentre {}", axis(a)),
            ToleranceKind::SurfaceTilt(a) => write!(f, "surface tilt {}", axis(a)),
        }?;
        let [first, last] = self.rows.map(|row| row + 1);
        let element =
            matches!(self.kind, ToleranceKind::ElementTilt(_) | ToleranceKind::ElementDecentre(_));
        match element && last > first {
            true => write!(f, " {first}-{last}"),
            false => write!(f, " {first}"),
        }
    }
}

/// Returns the quantities of a lens whose limits are not 0, in a fixed order.
pub(super) fn parameters(lens: &Prescription, limits: &ToleranceLimits) -> Vec<ToleranceParameter> {
    let mut all = Vec::new();
    let mut push = |kind, rows, limit: f64| {
        if limit > 0.0 {
            all.push(ToleranceParameter { kind, rows, limit });
        }
    };
    let count = lens.rows.len();
    let refracts = |i: usize| {
        let [before, behind] = lens.indices(i);
        before != behind || lens.rows[i].mirror
    };
    for i in (0..count).filter(|&i| refracts(i)) {
        let row = &lens.rows[i];
        match limits.radius {
            RadiusLimit::Percent(limit) if row.radius.is_finite() => {
                push(ToleranceKind::RadiusPercent, [i, i], limit);
            }
            RadiusLimit::Percent(_) => {}
            RadiusLimit::Fringes(limit) => push(ToleranceKind::RadiusFringes, [i, i], limit),
        }
    }
    for i in (0..count - 1).filter(|&i| lens.rows[i].thickness != 0.0) {
        push(ToleranceKind::Thickness, [i, i], limits.thickness);
    }
    for rows in media(lens) {
        push(ToleranceKind::Index, rows, limits.index);
        if lens.rows[rows[0]].glass.disperses() {
            push(ToleranceKind::Abbe, rows, limits.abbe);
        }
    }
    let elements = elements(lens);
    for rows in &elements {
        for axis in 0..2 {
            push(ToleranceKind::ElementTilt(axis), *rows, limits.tilt);
        }
        for axis in 0..2 {
            push(ToleranceKind::ElementDecentre(axis), *rows, limits.decentre);
        }
    }
    // The first surface of an element is the one to which the others are tilted.
    for [first, last] in elements {
        for i in (first + 1..=last).filter(|&i| refracts(i)) {
            for axis in 0..2 {
                push(ToleranceKind::SurfaceTilt(axis), [i, i], limits.wedge);
            }
        }
    }
    all
}
