//! A lens as its designer writes it down.

use std::fmt;

/// One row of a lens table: a surface and the medium behind it.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Radius of curvature, mm, positive where the centre lies on the film side; infinite for a
    /// plane.
    pub radius: f64,
    /// Distance to the next surface, or of the last one to nowhere, mm.
    pub thickness: f64,
    /// Refractive index of the medium on the film side of the surface.
    pub index: f64,
    /// Full clear diameter, mm.
    pub diameter: f64,
    /// Whether this is the aperture stop.
    pub stop: bool,
}

impl Row {
    /// Curvature, 1/mm; 0 for a plane.
    pub fn curvature(&self) -> f64 {
        self.radius.recip()
    }

    /// Distance along the axis from the vertex to the surface at height `h`, mm.
    pub fn sag(&self, h: f64) -> f64 {
        let c = self.curvature();
        c * h * h / (1.0 + (1.0 - c * c * h * h).max(0.0).sqrt())
    }
}

/// A lens: its surfaces from the scene to the film, mm.
#[derive(Clone, Debug, PartialEq)]
pub struct Prescription {
    /// What it is called.
    pub name: String,
    /// The surfaces in the order in which light meets them. Exactly one is the stop.
    pub rows: Vec<Row>,
}

impl Prescription {
    /// The place of the stop among the rows.
    ///
    /// # Panics
    /// Where no row is the stop; no reader makes such a lens.
    pub fn stop(&self) -> usize {
        self.rows.iter().position(|row| row.stop).expect("readers let no lens in without a stop")
    }

    /// Front vertex to rear vertex, mm.
    pub fn length(&self) -> f64 {
        self.rows[..self.rows.len() - 1].iter().map(|row| row.thickness).sum()
    }

    /// Index of the medium before row `i`, on its scene side.
    pub fn index_before(&self, i: usize) -> f64 {
        if i == 0 { 1.0 } else { self.rows[i - 1].index }
    }

    /// The surface nearest to the film.
    pub fn rear(&self) -> &Row {
        &self.rows[self.rows.len() - 1]
    }

    /// Closes the stop to a diameter in mm; it cannot be opened beyond what the lens has.
    /// Answers the diameter it has now.
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
            "{:>4}  {:>12}  {:>12}  {:>8}  {:>9}",
            "", "radius", "thickness", "index", "diameter"
        )?;
        for (i, row) in self.rows.iter().enumerate() {
            let radius = if row.stop && row.radius.is_infinite() {
                "stop".to_owned()
            } else if row.radius.is_infinite() {
                "plane".to_owned()
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
                "{:>4}  {radius:>12}  {thickness:>12}  {:>8.4}  {:>9.3}",
                i + 1,
                row.index,
                row.diameter
            )?;
        }
        Ok(())
    }
}
