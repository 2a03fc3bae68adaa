//! A lens as its designer writes it down.

use std::fmt;

use super::coating::Coating;
use super::glass::{CatalogueGlass, D_LINE, Glass, guess};
use super::iris::Iris;
use super::paraxial::Matrix;
use super::pose::{Askew, Pose};

/// Which way a cylinder runs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Axis {
    /// Straight along x, curved along y.
    X,
    /// Straight along y, curved along x.
    Y,
}

/// One row of a lens table: a surface and the medium behind it.
///
/// Sag and `h` below: z = c h^2 / (1 + sqrt(1 - (1 + k) c^2 h^2)) + sum of a_p h^p, with c the
/// curvature and k the conic constant, z towards the film.
#[derive(Clone, Debug, PartialEq)]
pub struct Row {
    /// Radius of curvature at the vertex, mm, positive where the centre lies on the film side;
    /// infinite for a plane.
    pub radius: f64,
    /// Conic constant k: 0 a sphere, -1 a paraboloid.
    pub conic: f64,
    /// Powers p from 2 to 20 and their coefficients a_p in mm^(1 - p), each power once.
    pub asphere: Vec<(u32, f64)>,
    /// Makes a cylinder of the sphere.
    pub axis: Option<Axis>,
    /// Distance to the next surface, or of the last one to nowhere, mm.
    pub thickness: f64,
    /// Refractive index of the medium on the film side of the surface, at the d line.
    pub index: f64,
    /// How the index changes with wavelength, where that is known.
    pub glass: Glass,
    /// Full clear diameter, mm.
    pub diameter: f64,
    /// Diameter of an opaque disk in the middle, mm; 0 for none.
    pub obstruction: f64,
    /// Whether this is the aperture stop.
    pub stop: bool,
    /// The shape of the opening, inside the clear diameter.
    pub iris: Iris,
    /// What the surface is coated with, where that is said: bare if not.
    pub coating: Option<Coating>,
    /// How the surface alone stands.
    pub pose: Pose,
    /// What a lens of no aberration in the place of the surface does to light on its way to the
    /// film, along x and along y, from its plane to its plane; then the shape counts for nothing.
    pub ideal: Option<[Matrix; 2]>,
}

impl Default for Row {
    /// A plane of no extent in air.
    fn default() -> Self {
        Self {
            radius: f64::INFINITY,
            conic: 0.0,
            asphere: Vec::new(),
            axis: None,
            thickness: 0.0,
            index: 1.0,
            glass: Glass::Constant,
            diameter: 0.0,
            obstruction: 0.0,
            stop: false,
            iris: Iris::Round,
            coating: None,
            pose: Pose::SQUARE,
            ideal: None,
        }
    }
}

impl Row {
    /// Curvature at the vertex, 1/mm; 0 for a plane.
    pub fn curvature(&self) -> f64 {
        self.radius.recip()
    }

    /// Curvatures at the vertex along x and y, 1/mm, with what an asphere's square term adds.
    pub fn curvatures(&self) -> [f64; 2] {
        let square: f64 = self.asphere.iter().filter(|(p, _)| *p == 2).map(|(_, a)| 2.0 * a).sum();
        let c = self.curvature() + square;
        match self.axis {
            None => [c, c],
            Some(Axis::X) => [0.0, c],
            Some(Axis::Y) => [c, 0.0],
        }
    }

    /// Whether turning the surface about the axis changes nothing.
    pub fn is_round(&self) -> bool {
        let even = self.ideal.is_none_or(|[x, y]| x == y);
        self.axis.is_none() && self.iris == Iris::Round && even
    }

    /// Distance along the axis from the vertex to the surface at height `h` (where a cylinder is
    /// curved), mm. Beyond the edge of a conic the sag of its edge.
    pub fn sag(&self, h: f64) -> f64 {
        let c = self.curvature();
        let root = (1.0 - (1.0 + self.conic) * c * c * h * h).max(0.0).sqrt();
        let terms: f64 = self.asphere.iter().map(|&(p, a)| a * h.powi(p as i32)).sum();
        c * h * h / (1.0 + root) + terms
    }

    /// Slope of the surface at height `h`; infinite at the edge of a conic and beyond.
    pub fn slope(&self, h: f64) -> f64 {
        let c = self.curvature();
        let root = (1.0 - (1.0 + self.conic) * c * c * h * h).max(0.0).sqrt();
        let term = |&(p, a): &(u32, f64)| f64::from(p) * a * h.powi(p as i32 - 1);
        c * h / root + self.asphere.iter().map(term).sum::<f64>()
    }

    /// Distance along the axis from the vertex to the surface at a point, mm.
    pub fn sag_at(&self, x: f64, y: f64) -> f64 {
        match self.axis {
            None => self.sag(x.hypot(y)),
            Some(Axis::X) => self.sag(y),
            Some(Axis::Y) => self.sag(x),
        }
    }

    /// How [`Self::sag_at`] changes with x and with y.
    pub fn gradient(&self, x: f64, y: f64) -> [f64; 2] {
        let h = x.hypot(y);
        match self.axis {
            None if h > 0.0 => [x, y].map(|v| self.slope(h) * v / h),
            None => [0.0; 2],
            Some(Axis::X) => [0.0, self.slope(y)],
            Some(Axis::Y) => [self.slope(x), 0.0],
        }
    }
}

/// A lens: its surfaces from the scene to the film, mm.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Prescription {
    /// What it is called.
    pub name: String,
    /// Where the figures come from: a patent, a book, a catalogue.
    pub source: Option<String>,
    /// Focal length that the file states, mm.
    pub stated_focal_length: Option<f64>,
    /// f-number that the file states.
    pub stated_f_number: Option<f64>,
    /// The surfaces in the order in which light meets them. Exactly one is the stop.
    pub rows: Vec<Row>,
    /// Elements and groups that stand askew, the inner ones before those that hold them.
    pub askew: Vec<Askew>,
}

impl Prescription {
    /// The place of the stop among the rows.
    ///
    /// # Panics
    /// Where no row is the stop; no reader makes such a lens.
    pub fn stop(&self) -> usize {
        self.rows.iter().position(|row| row.stop).expect("readers let no lens in without a stop")
    }

    /// The lens for light of one wavelength, nm.
    pub fn at_wavelength(&self, nm: f64) -> Self {
        let mut lens = self.clone();
        for row in &mut lens.rows {
            row.index = row.glass.index(row.index, nm);
        }
        lens
    }

    /// Gives every medium of which only the index is known the Abbe number of a glass of the
    /// catalogue that it may be, and answers those glasses in their order.
    pub fn assume_dispersion(&mut self) -> Vec<&'static CatalogueGlass> {
        let mut guessed = Vec::new();
        for i in 0..self.rows.len() {
            let row = &self.rows[i];
            if row.index == 1.0 || row.glass.disperses() {
                continue;
            }
            let bend = |row: &Row| row.curvatures().iter().sum::<f64>();
            let gathers = bend(row) >= self.rows.get(i + 1).map_or(0.0, bend);
            if let Some(glass) = guess(row.index, gathers) {
                self.rows[i].glass = Glass::Abbe { vd: glass.vd() };
                guessed.push(glass);
            }
        }
        guessed
    }

    /// Whether turning the lens about its axis changes nothing.
    pub fn is_round(&self) -> bool {
        self.rows.iter().all(Row::is_round) && !self.is_askew()
    }

    /// Front vertex to rear vertex, mm.
    pub fn length(&self) -> f64 {
        self.rows[..self.rows.len() - 1].iter().map(|row| row.thickness).sum()
    }

    /// Index of the medium before row `i`, on its scene side.
    pub fn index_before(&self, i: usize) -> f64 {
        if i == 0 { 1.0 } else { self.rows[i - 1].index }
    }

    /// Indices before and behind row `i`, as light from the scene meets it.
    pub fn indices(&self, i: usize) -> [f64; 2] {
        [self.index_before(i), self.rows[i].index]
    }

    /// Coats all faces to air that have no coating of their own.
    pub fn coat(&mut self, coating: Coating) {
        for i in 0..self.rows.len() {
            if self.rows[i].coating.is_none() && Coating::fits(self.indices(i)) {
                self.rows[i].coating = Some(coating);
            }
        }
    }

    /// The share of light that row `i` lets through along the axis, at the d line.
    pub fn transmittance(&self, i: usize) -> f64 {
        let coating = self.rows[i].coating.unwrap_or_default();
        coating.transmittance(self.indices(i), 1.0, D_LINE)
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
        for (i, row) in self.rows.iter().enumerate().filter(|(_, row)| !row.pose.is_square()) {
            writeln!(f, "surface {} stands askew: {}", i + 1, row.pose)?;
        }
        for Askew { rows: [first, last], pose } in &self.askew {
            writeln!(f, "surfaces {} to {} stand askew: {pose}", first + 1, last + 1)?;
        }
        Ok(())
    }
}
