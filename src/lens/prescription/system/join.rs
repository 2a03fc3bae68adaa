//! Rows of a prescription from the surfaces of a system: dummy planes and coordinate breaks are
//! joined with the spaces around them.

use std::path::Path;

use glam::{DAffine3, DVec3};

use super::{MediumBehind, SystemSurface};
use crate::prescription::Row;
use crate::prescription::error::LensError;
use crate::prescription::limits::{MAX_INDEX, MIN_INDEX};
use crate::prescription::pose::CoordinateBreak;
use petzval_spectrum::Glass;

/// Distance between a surface and a film that touch (mm).
const CONTACT: f64 = 1e-9;

/// Returns the translation along z.
pub(super) fn along(z: f64) -> DAffine3 {
    DAffine3::from_translation(DVec3::new(0.0, 0.0, z))
}

/// Rows under construction.
pub(super) struct Joined {
    pub rows: Vec<Row>,
    /// Line of each row.
    pub lines: Vec<usize>,
    /// Rows without a stated diameter.
    pub unknown: Vec<usize>,
    pub breaks: Vec<CoordinateBreak>,
    /// For each surface of the system the row whose space contains its own; none before the first.
    pub places: Vec<Option<usize>>,
    /// Sum of the thicknesses since the last row.
    pub gap: f64,
    /// Axes at the end of that gap, relative to the last row.
    pub frame: DAffine3,
    /// Whether a coordinate break stands in that gap.
    pub broken: bool,
    /// Thickness of all before the first row.
    pub front: f64,
    pub index: f64,
    pub glass: Glass,
}

impl Default for Joined {
    fn default() -> Self {
        Self {
            rows: Vec::new(),
            lines: Vec::new(),
            unknown: Vec::new(),
            breaks: Vec::new(),
            places: Vec::new(),
            gap: 0.0,
            frame: DAffine3::IDENTITY,
            broken: false,
            front: 0.0,
            index: 1.0,
            glass: Glass::Constant,
        }
    }
}

impl Joined {
    pub fn push(
        &mut self,
        _i: usize,
        surface: &SystemSurface,
        nm: f64,
        path: &Path,
    ) -> Result<(), LensError> {
        let thickness = surface.row.thickness;
        if let Some(transform) = surface.coordinate_break {
            self.frame = self.frame * transform * along(thickness);
            self.gap += thickness;
            self.broken = true;
            self.places.push(self.rows.len().checked_sub(1));
            return Ok(());
        }
        let (index, glass) = match &surface.medium {
            MediumBehind::Air => (1.0, Glass::Constant),
            MediumBehind::Same | MediumBehind::Mirror => (self.index, self.glass.clone()),
            &MediumBehind::Index(index) => (index, Glass::Constant),
            // Outside its data, for which the reader of the file checks, it is that of the nearest end.
            MediumBehind::Glass(glass) => (glass.nearest_index(1.0, nm), glass.clone()),
        };
        if !(MIN_INDEX..MAX_INDEX).contains(&index) {
            return Err(LensError::Malformed {
                path: path.to_owned(),
                line: surface.line,
                column: None,
                found: format!("a medium of index {index}"),
                expected: "expected 1 (air) to 10".to_owned(),
            });
        }
        let row = &surface.row;
        let mirror = matches!(surface.medium, MediumBehind::Mirror);
        let changes = mirror || index != self.index || glass != self.glass;
        let plane = row.is_plane() && row.ideal.is_none();
        let blocks =
            row.stop || row.obstruction > 0.0 || !row.apertures.is_empty() || surface.clips;
        if !changes && !blocks && plane {
            self.frame *= along(thickness);
            self.gap += thickness;
            self.places.push(self.rows.len().checked_sub(1));
            return Ok(());
        }
        match self.rows.last_mut() {
            Some(before) => before.thickness = self.gap,
            None => self.front = self.gap,
        }
        if self.broken {
            let transform = along(-self.gap) * self.frame;
            self.breaks.push(CoordinateBreak { row: self.rows.len(), transform });
        }
        let diameter = match surface.semi_diameter {
            Some(semi) if semi > 0.0 => 2.0 * semi,
            _ => {
                self.unknown.push(self.rows.len());
                0.0
            }
        };
        self.places.push(Some(self.rows.len()));
        self.lines.push(surface.line);
        self.rows.push(Row { index, glass: glass.clone(), mirror, diameter, ..row.clone() });
        (self.index, self.glass) = (index, glass);
        (self.gap, self.frame, self.broken) = (thickness, along(thickness), false);
        Ok(())
    }
}

impl Joined {
    /// Removes a last plane that touches the film, so that the film stands in the medium before it.
    pub fn let_film_touch_glass(&mut self) -> bool {
        let [.., before, last] = &self.rows[..] else { return false };
        let removed = self.rows.len() - 1;
        let bare = last.is_plane() && !last.stop && !last.mirror && last.is_unobstructed();
        let refracts = before.index != last.index;
        let moved = self.broken || self.breaks.iter().any(|axis| axis.row == removed);
        if !bare || !refracts || moved || before.ideal.is_some() || self.gap.abs() > CONTACT {
            return false;
        }
        self.gap = before.thickness;
        self.frame = along(self.gap);
        self.rows.pop();
        self.unknown.retain(|&row| row != removed);
        for place in &mut self.places {
            *place = place.map(|row| row.min(removed - 1));
        }
        true
    }
}
