//! The prescription of a lens: its surfaces, media, stop and alignment.

pub(crate) mod coating;
pub(crate) mod error;
pub(crate) mod formats;
pub(crate) mod index_warnings;
pub(crate) mod iris;
pub(crate) mod named_mask;
pub(crate) mod pose;
pub(crate) mod row;
pub(crate) mod rows;

use std::fmt;

use coating::Coating;
use error::LensError;
use pose::TiltDecenter;
pub use row::{Row, TransverseAxis};
pub use rows::Rows;

use crate::spectrum::glass::{CatalogueGlass, D_LINE, Glass, likely_glass};

/// A lens: its surfaces from the scene to the film. Lengths are in millimetres.
#[derive(Clone, Debug, PartialEq)]
pub struct Prescription {
    /// Name of the lens.
    pub name: String,
    /// Source of the figures: a patent, a book, a catalogue.
    pub source: Option<String>,
    /// Focal length that the file states (mm).
    pub stated_focal_length: Option<f64>,
    /// f-number that the file states.
    pub stated_f_number: Option<f64>,
    /// Surfaces in the order in which light meets them.
    pub rows: Rows,
    /// Tilted or decentred elements and groups, inner ones before those that contain them.
    pub tilt_decenters: Vec<TiltDecenter>,
}

impl Prescription {
    /// Creates a centred lens without stated figures.
    ///
    /// # Errors
    /// Returns an error if there is no row, or if not exactly one row is the stop.
    pub fn new(name: impl Into<String>, rows: Vec<Row>) -> Result<Self, LensError> {
        Ok(Self {
            name: name.into(),
            source: None,
            stated_focal_length: None,
            stated_f_number: None,
            rows: Rows::new(rows)?,
            tilt_decenters: Vec::new(),
        })
    }

    /// Returns the index of the stop among the rows.
    pub fn stop(&self) -> usize {
        self.rows.stop()
    }

    /// Returns the lens with its refractive indices at one wavelength (nm).
    pub fn at_wavelength(&self, nm: f64) -> Self {
        let mut lens = self.clone();
        for row in &mut lens.rows {
            row.index = row.glass.index(row.index, nm);
        }
        lens
    }

    /// Gives every medium without stated dispersion the Abbe number of the most likely catalogue
    /// glass, and returns those glasses in the order of the rows.
    pub fn assume_dispersion(&mut self) -> Vec<&'static CatalogueGlass> {
        let mut glasses = Vec::new();
        for i in 0..self.rows.len() {
            let row = &self.rows[i];
            if row.index == 1.0 || row.glass.disperses() {
                continue;
            }
            let bend = |row: &Row| row.curvatures().iter().sum::<f64>();
            let converging = bend(row) >= self.rows.get(i + 1).map_or(0.0, bend);
            if let Some(glass) = likely_glass(row.index, converging) {
                self.rows[i].glass = Glass::Abbe { vd: glass.vd() };
                glasses.push(glass);
            }
        }
        glasses
    }

    /// Returns whether the lens is rotationally symmetric.
    pub fn is_round(&self) -> bool {
        self.rows.iter().all(Row::is_round) && !self.is_misaligned()
    }

    /// Returns the distance from the front vertex to the rear vertex (mm).
    pub fn length(&self) -> f64 {
        self.rows[..self.rows.len() - 1].iter().map(|row| row.thickness).sum()
    }

    /// Returns the index of the medium on the scene side of row `i`.
    pub fn index_before(&self, i: usize) -> f64 {
        if i == 0 { 1.0 } else { self.rows[i - 1].index }
    }

    /// Returns the indices before and behind row `i`, in the direction of light from the scene.
    pub fn indices(&self, i: usize) -> [f64; 2] {
        [self.index_before(i), self.rows[i].index]
    }

    /// Coats all glass-air surfaces that have no coating of their own.
    pub fn coat(&mut self, coating: Coating) {
        for i in 0..self.rows.len() {
            if self.rows[i].coating.is_none() && Coating::applies_to(self.indices(i)) {
                self.rows[i].coating = Some(coating);
            }
        }
    }

    /// Returns the transmittance of row `i` at normal incidence and the d line.
    pub fn transmittance(&self, i: usize) -> f64 {
        let coating = self.rows[i].coating.unwrap_or_default();
        coating.transmittance(self.indices(i), 1.0, D_LINE)
    }

    /// Returns the surface nearest to the film.
    pub fn rear(&self) -> &Row {
        &self.rows[self.rows.len() - 1]
    }

    /// Closes the stop to a diameter (mm), never beyond its own, and returns the resulting
    /// diameter.
    pub fn stop_down(&mut self, diameter: f64) -> f64 {
        let stop = self.stop();
        let row = &mut self.rows[stop];
        row.diameter = row.diameter.min(diameter);
        row.diameter
    }
}

impl fmt::Display for Prescription {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:>4}  {:>12}  {:>12}  {:>8}  {:>9}  {:>9}",
            "", "radius", "thickness", "index", "diameter", "transmits"
        )?;
        for (i, row) in self.rows.iter().enumerate() {
            let [before, behind] = self.indices(i);
            let radius = if row.stop && row.radius.is_infinite() {
                if before == behind { "stop".to_owned() } else { "plane stop".to_owned() }
            } else if row.radius.is_infinite() {
                "plane".to_owned()
            } else if row.radius.abs() >= 1e7 {
                format!("{:.4e}", row.radius)
            } else {
                format!("{:.4}", row.radius)
            };
            let thickness = if i + 1 == self.rows.len() {
                "to film".to_owned()
            } else {
                format!("{:.4}", row.thickness)
            };
            writeln!(
                f,
                "{:>4}  {radius:>12}  {thickness:>12}  {:>8.4}  {:>9.3}  {:>9.5}",
                i + 1,
                row.index,
                row.diameter,
                self.transmittance(i)
            )?;
        }
        for (i, row) in self.rows.iter().enumerate().filter(|(_, row)| !row.pose.is_aligned()) {
            writeln!(f, "surface {}: {}", i + 1, row.pose)?;
        }
        for TiltDecenter { rows: [first, last], pose } in &self.tilt_decenters {
            writeln!(f, "surfaces {} to {}: {pose}", first + 1, last + 1)?;
        }
        Ok(())
    }
}
