//! The prescription of a lens: its surfaces, media, stop and alignment.

pub mod coating;
pub(crate) mod configuration;
pub mod design;
pub mod error;
pub(crate) mod group_focus;
pub(crate) mod index_warnings;
pub mod iris;
pub mod limits;
pub mod named_mask;
pub mod pose;
pub(crate) mod row;
pub(crate) mod rows;
pub mod surface_aperture;
pub mod system;

use std::fmt;
use std::sync::Arc;

use coating::{ASSUMED_COATING, Coating};
use design::Design;
use error::LensError;
use pose::{CoordinateBreak, TiltDecenter};
pub use row::{CrossSection, Row, TransverseAxis};
pub use rows::Rows;

use petzval_spectrum::likely_glass;
use petzval_spectrum::{CatalogueGlass, D_LINE, Glass, IndexRangeError};

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
    /// Whether the coatings of the rows are those of [`Self::assume_coating`].
    pub assumed_coating: bool,
    /// Tilted or decentred elements and groups, inner ones before those that contain them.
    pub tilt_decenters: Vec<TiltDecenter>,
    /// Changes of the axis for all that follows, in the order of the rows.
    pub breaks: Vec<CoordinateBreak>,
    /// Use of the lens, as far as its file states it: wavelengths, fields, conjugates, states.
    pub design: Design,
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
            assumed_coating: false,
            tilt_decenters: Vec::new(),
            breaks: Vec::new(),
            design: Design::default(),
        })
    }

    /// Returns the index of the stop among the rows.
    pub fn stop(&self) -> usize {
        self.rows.stop()
    }

    /// Returns the lens with its refractive indices at one wavelength (nm).
    ///
    /// # Errors
    /// Returns an error if the data of a medium do not cover the wavelength.
    pub fn at_wavelength(&self, nm: f64) -> Result<Self, IndexRangeError> {
        self.check_wavelengths([nm; 2])?;
        Ok(self.at_checked_wavelength(nm))
    }

    /// As [`Self::at_wavelength`], for a wavelength in a range that
    /// [`Self::check_wavelengths`] has passed. Beyond it the indices are those of the ends of the
    /// data.
    pub fn at_checked_wavelength(&self, nm: f64) -> Self {
        let mut lens = self.clone();
        for row in &mut lens.rows {
            row.index = row.glass.nearest_index(row.index, nm);
        }
        lens
    }

    /// Gives every medium without stated dispersion the Abbe number of the most likely catalogue
    /// glass, and returns those glasses in the order of the rows.
    pub fn assume_dispersion(&mut self) -> Vec<Arc<CatalogueGlass>> {
        let mut glasses = Vec::new();
        for i in 0..self.rows.len() {
            let row = &self.rows[i];
            if row.index == 1.0 || row.glass.disperses() {
                continue;
            }
            let bend = |row: &Row| row.curvatures().iter().sum::<f64>();
            let converging = bend(row) >= self.rows.get(i + 1).map_or(0.0, bend);
            if let Some(glass) = likely_glass(row.index, converging) {
                self.rows[i].glass = Glass::Abbe { nd: row.index, vd: glass.vd() };
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

    /// Returns whether any surface reflects.
    pub fn has_mirrors(&self) -> bool {
        self.rows.iter().any(|row| row.mirror)
    }

    /// Returns the direction of travel before row `i`, or behind the lens if `i` is the number of
    /// rows: 1 along +z, -1 after an odd number of mirrors.
    pub fn travel_before(&self, i: usize) -> f64 {
        match self.rows[..i].iter().filter(|row| row.mirror).count() % 2 {
            0 => 1.0,
            _ => -1.0,
        }
    }

    /// Returns the directions of travel before each row, in the order of the rows, and behind the
    /// last: 1 along +z, -1 after an odd number of mirrors.
    pub fn travels(&self) -> Vec<f64> {
        let turn = |travel: &mut f64, row: &Row| {
            *travel = if row.mirror { -*travel } else { *travel };
            Some(*travel)
        };
        std::iter::once(1.0).chain(self.rows.iter().scan(1.0, turn)).collect()
    }

    /// Returns the position of a film (mm behind the front vertex of the centred lens), by its
    /// distance from the rear vertex along the way of the light (mm).
    pub fn film_position(&self, distance: f64) -> f64 {
        self.length() + self.travel_before(self.rows.len()) * distance
    }

    /// Returns the index of the medium on the scene side of row `i`.
    pub fn index_before(&self, i: usize) -> f64 {
        if i == 0 { 1.0 } else { self.rows[i - 1].index }
    }

    /// Returns the indices before and behind row `i`, in the direction of light from the scene.
    pub fn indices(&self, i: usize) -> [f64; 2] {
        [self.index_before(i), self.rows[i].index]
    }

    /// Returns the indices before and behind row `i`, negative where light travels along -z.
    /// [`Self::all_signed_indices`] returns those of all rows without a walk for each.
    pub(crate) fn signed_indices(&self, i: usize) -> [f64; 2] {
        let [before, behind] = self.indices(i);
        [self.travel_before(i) * before, self.travel_before(i + 1) * behind]
    }

    /// Returns `signed_indices` of all rows.
    pub fn all_signed_indices(&self) -> Vec<[f64; 2]> {
        let travels = self.travels();
        let signed = |i: usize| {
            let [before, behind] = self.indices(i);
            [travels[i] * before, travels[i + 1] * behind]
        };
        (0..self.rows.len()).map(signed).collect()
    }

    /// Coats all glass-air surfaces that have no coating of their own.
    pub fn coat(&mut self, coating: &Coating) {
        for i in 0..self.rows.len() {
            if self.rows[i].coating.is_none() && Coating::applies_to(self.indices(i)) {
                self.rows[i].coating = Some(coating.clone());
            }
        }
    }

    /// Coats all glass-air surfaces of a lens that names no coating with [`ASSUMED_COATING`]. This is
    /// the only assumption about coatings: losses, ghosts and T-stops all take it.
    pub fn assume_coating(&mut self) {
        if self.rows.iter().all(|row| row.coating.is_none()) {
            self.coat(&ASSUMED_COATING);
            self.assumed_coating = true;
        }
    }

    /// Returns the transmittance of row `i` at normal incidence and the d line.
    pub fn transmittance(&self, i: usize) -> f64 {
        let coating = self.rows[i].coating.as_ref().unwrap_or(&Coating::Bare);
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
            "{:>4}  {:>11}  {:>10}  {:>8}  {:>6}  {:>9}  {:>9}",
            "", "radius", "thickness", "index", "Abbe", "diameter", "transmits"
        )?;
        for (i, row) in self.rows.iter().enumerate() {
            let [before, behind] = self.indices(i);
            let bare_stop = row.stop && row.radius.is_infinite();
            let radius = if bare_stop {
                if before == behind { "stop".to_owned() } else { "plane stop".to_owned() }
            } else if row.radius.is_infinite() {
                "plane".to_owned()
            } else if row.radius.abs() >= 1e6 {
                format!("{:.4e}", row.radius)
            } else {
                format!("{:.4}", row.radius)
            };
            let thickness = if i + 1 == self.rows.len() {
                "to film".to_owned()
            } else {
                format!("{:.4}", row.thickness)
            };
            let abbe = row.glass.abbe_number().map_or_else(String::new, |vd| format!("{vd:.2}"));
            let stop = if row.stop && !bare_stop { Some("stop") } else { None };
            let mirror = if row.mirror { Some("mirror") } else { None };
            let name = row.glass.name().filter(|_| !row.mirror);
            let words: Vec<&str> = [name, stop, mirror].into_iter().flatten().collect();
            let line = format!(
                "{:>4}  {radius:>11}  {thickness:>10}  {:>8.4}  {abbe:>6}  {:>9.3}  {:>9.5}  {}",
                i + 1,
                row.index,
                row.diameter,
                self.transmittance(i),
                words.join(", ")
            );
            writeln!(f, "{}", line.trim_end())?;
        }
        for (i, row) in self.rows.iter().enumerate() {
            for line in row.shape_lines() {
                writeln!(f, "surface {}: {line}", i + 1)?;
            }
        }
        for (i, row) in self.rows.iter().enumerate().filter(|(_, row)| !row.pose.is_aligned()) {
            writeln!(f, "surface {}: {}", i + 1, row.pose)?;
        }
        for (i, row) in self.rows.iter().enumerate() {
            for aperture in &row.apertures {
                writeln!(f, "surface {}: {aperture}", i + 1)?;
            }
        }
        for TiltDecenter { rows: [first, last], pose } in &self.tilt_decenters {
            writeln!(f, "surfaces {} to {}: {pose}", first + 1, last + 1)?;
        }
        for axis in &self.breaks {
            match axis.row < self.rows.len() {
                true => write!(f, "axis before surface {}: ", axis.row + 1)?,
                false => write!(f, "film: ")?,
            }
            let ([x, y, _], [ax, ay]) = (axis.transform.translation.to_array(), axis.tilt());
            writeln!(f, "decentred by {x:.4}, {y:.4} mm, tilted by {ax:.4}, {ay:.4} degrees")?;
        }
        Ok(())
    }
}
