//! From a sequential system to a prescription.

use std::path::Path;

use super::diameters::complete_diameters;
use super::join::{Joined, along};
use super::{MAX_SURFACES, SequentialSystem, SystemAperture, SystemSurface};
use crate::focus::paraxial::Paraxial;
use crate::prescription::design::{Configuration, Design, Quantity, Setting};
use crate::prescription::error::LensError;
use crate::prescription::pose::CoordinateBreak;
use crate::prescription::{Prescription, Row, Rows};

/// Largest share of the radius at which a conic is used; at 1 it is vertical.
const EDGE: f64 = 0.9999;

/// Share of the radius up to which a stated semi-diameter is that of a hemisphere, rounded.
const TOUCHING: f64 = 1.02;

impl SequentialSystem {
    /// Converts the system to a prescription at its primary wavelength.
    ///
    /// # Errors
    /// Returns an error with the line if the system has no surface or two stops, or if a glass has
    /// no index at the primary wavelength.
    pub fn build(mut self, path: &Path) -> Result<Prescription, LensError> {
        let error = |line: usize, found: String, expected: &str| LensError::Malformed {
            path: path.to_owned(),
            line,
            column: None,
            found,
            expected: expected.to_owned(),
        };
        let stem = || path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let name = if self.name.trim().is_empty() { stem() } else { self.name.trim().to_owned() };
        if let Some(surface) = self.surfaces.get(MAX_SURFACES) {
            let found = format!("more than {MAX_SURFACES} surfaces");
            return Err(error(surface.line, found, "expected one lens"));
        }
        self.read_semi_diameters();
        self.put_window_before_object_medium();
        let mut joined = Joined::default();
        for (i, surface) in self.surfaces.iter().enumerate() {
            joined.push(i, surface, self.design.primary_wavelength(), path)?;
        }
        let touches = joined.let_film_touch_glass();
        let Joined {
            mut rows, mut breaks, gap, frame, broken, places, lines, unknown, front, ..
        } = joined;
        if rows.is_empty() {
            let last = self.surfaces.last().map_or(1, |surface| surface.line);
            return Err(error(
                last,
                "no surface between object and image".into(),
                "expected at least one surface that refracts, reflects or stops",
            ));
        }
        let stops: Vec<usize> = (0..rows.len()).filter(|&i| rows[i].stop).collect();
        if let [_, second, ..] = stops[..] {
            return Err(error(lines[second], "a second stop".into(), "a lens has one"));
        }
        let notes = &mut self.design.notes;
        if stops.is_empty() {
            let stop = likely_stop(&rows);
            rows[stop].stop = true;
            notes.push(format!("the file names no stop; surface {} is taken as it", stop + 1));
        }
        let film_index = rows[rows.len() - 1].index;
        match touches {
            true => notes.push(
                "the last surface touches the film; the film stands inside the glass before it"
                    .to_owned(),
            ),
            false if film_index != 1.0 => {
                notes.push(format!("the film stands in a medium of index {film_index:.4}"));
            }
            false => {}
        }
        if broken {
            breaks.push(CoordinateBreak { row: rows.len(), transform: along(-gap) * frame });
        }
        let parity = if rows.iter().filter(|row| row.mirror).count() % 2 == 0 { 1.0 } else { -1.0 };
        if let Some(object) = &mut self.design.object_distance {
            *object += front;
        }
        self.design.film_distance = (gap * parity != 0.0).then_some(gap * parity);
        let stated: Vec<f64> = self.surfaces.iter().map(|surface| surface.row.thickness).collect();
        for configuration in &mut self.design.configurations {
            place_settings(configuration, &places, &stated, &rows, gap, parity);
        }
        let last = rows.len() - 1;
        rows[last].thickness = 0.0;
        let mut lens = Prescription {
            source: self.source,
            stated_focal_length: self.focal_length,
            stated_f_number: self.f_number,
            design: Design { notes: Vec::new(), ..self.design.clone() },
            breaks,
            ..Prescription::new(name, Vec::from(&*Rows::new(rows)?))?
        };
        let mut notes = std::mem::take(&mut self.design.notes);
        complete_diameters(&mut lens, &unknown, self.aperture, &mut notes);
        limit_to_edges(&mut lens, &mut notes);
        lens.design.notes = notes;
        Ok(lens)
    }

    /// Halves a column of semi-diameters that holds diameters.
    fn read_semi_diameters(&mut self) {
        if !self.column_of_semi_diameters {
            return;
        }
        let exceeds = |surface: &&SystemSurface| {
            let radius = surface.row.radius.abs();
            let sphere = surface.row.conic == 0.0 && surface.row.asphere.is_empty();
            sphere && surface.semi_diameter.is_some_and(|semi| semi > TOUCHING * radius)
        };
        let count = self.surfaces.iter().filter(exceeds).count();
        if count == 0 {
            return;
        }
        for surface in &mut self.surfaces {
            surface.semi_diameter = surface.semi_diameter.map(|semi| semi / 2.0);
        }
        self.design.notes.push(format!(
            "the column of semi-diameters holds diameters: {count} of {} exceed the radius of \
             their surface",
            self.surfaces.len()
        ));
    }
}

/// Returns the surface that is most likely the stop: the one of the smallest stated diameter.
fn likely_stop(rows: &[Row]) -> usize {
    let stated = (0..rows.len()).filter(|&i| rows[i].diameter > 0.0);
    stated.min_by(|&i, &j| rows[i].diameter.total_cmp(&rows[j].diameter)).unwrap_or(0)
}

/// Moves the settings of a configuration from the surfaces of the system to rows.
fn place_settings(
    configuration: &mut Configuration,
    places: &[Option<usize>],
    stated: &[f64],
    rows: &[Row],
    gap: f64,
    parity: f64,
) {
    let last = rows.len() - 1;
    let mut thickness: Vec<f64> = rows.iter().map(|row| row.thickness).collect();
    thickness[last] = gap;
    let mut changed = vec![false; rows.len()];
    let mut settings = Vec::new();
    for &Setting { row: surface, quantity, value } in &configuration.settings {
        let Some(&Some(row)) = places.get(surface) else {
            // The space before the first row changes the distance of the object only.
            continue;
        };
        match quantity {
            Quantity::Thickness => {
                // Other parts of the space keep their thickness.
                match thickness[row] == stated[surface] {
                    true => thickness[row] = value,
                    false => thickness[row] += value - stated[surface],
                }
                changed[row] = true;
            }
            _ => settings.push(Setting { row, quantity, value }),
        }
    }
    for row in 0..last {
        if changed[row] {
            let value = thickness[row];
            settings.push(Setting { row, quantity: Quantity::Thickness, value });
        }
    }
    if changed[last] && configuration.film_distance.is_none() {
        configuration.film_distance = Some(thickness[last] * parity);
    }
    configuration.settings = settings;
}

/// Limits the diameters of conics to their edges.
fn limit_to_edges(lens: &mut Prescription, notes: &mut Vec<String>) {
    for (i, row) in lens.rows.iter_mut().enumerate() {
        let widest = EDGE * row.edge();
        if row.diameter > widest && row.ideal.is_none() {
            notes.push(format!(
                "surface {}: a diameter of {:.4} mm exceeds the edge of the surface; {widest:.4} \
                 mm is used",
                i + 1,
                row.diameter
            ));
            row.diameter = widest;
        }
    }
}

impl SystemAperture {
    /// Returns the diameter of the entrance pupil (mm) of a lens, for an object at a distance
    /// before its front vertex (mm).
    pub fn entrance_pupil(self, paraxial: &Paraxial, object: f64) -> f64 {
        let tangent = |na: f64| na / (1.0 - na * na).max(1e-6).sqrt();
        match self {
            Self::EntrancePupil(diameter) => diameter,
            Self::FNumber(number) => paraxial.focal_length.abs() / number,
            Self::ImageNa(na) => {
                2.0 * paraxial.rear_focal_length().abs() * tangent(na / paraxial.film_index)
            }
            Self::ObjectNa(na) => {
                2.0 * (object + paraxial.entrance_pupil.position).abs() * tangent(na)
            }
        }
    }
}
