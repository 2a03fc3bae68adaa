//! Data of a lens file about the use of the lens: wavelengths, fields, object, film, configurations.

use petzval_spectrum::D_LINE;

/// Statements of a lens file about the use of the lens.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Design {
    /// Wavelengths in the order of the file; none if it states none.
    pub wavelengths: Vec<SpectralLine>,
    /// Index of the primary wavelength.
    pub primary: usize,
    /// Field points, if stated.
    pub fields: Option<Fields>,
    /// Distance from the front vertex to the object (mm), infinite for a distant one.
    pub object_distance: Option<f64>,
    /// Distance from the rear vertex to the film along the way of the light (mm).
    pub film_distance: Option<f64>,
    /// States of zoom and focus, in the order of the file; none for a lens with one state.
    pub configurations: Vec<Configuration>,
    /// Assumptions and approximations that the reader of the file made, for the user to see.
    pub notes: Vec<String>,
}

/// A wavelength of a design.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpectralLine {
    /// Wavelength (nm).
    pub nm: f64,
    /// Relative weight.
    pub weight: f64,
}

impl SpectralLine {
    /// Creates a line from a wavelength in micrometres, as lens files state it. A product with
    /// 1000 that is off a number of 12 digits by rounding alone is that number, so that 0.5875618 um
    /// are 587.5618 nm and not 587.5618000000001.
    pub fn from_um(um: f64, weight: f64) -> Self {
        let nm = 1000.0 * um;
        let short = rounded(nm);
        let nm = if (short - nm).abs() <= 2.0 * f64::EPSILON * nm.abs() { short } else { nm };
        Self { nm, weight }
    }

    /// Returns the number of micrometres from which [`Self::from_um`] gives this wavelength, with as
    /// few digits as it takes.
    pub fn um(&self) -> f64 {
        let guess = self.nm / 1000.0;
        let candidates = [rounded(guess), guess, guess.next_up(), guess.next_down()];
        let exact = |um: &f64| Self::from_um(*um, self.weight).nm == self.nm;
        candidates.into_iter().find(exact).unwrap_or(guess)
    }
}

/// Rounds a number to 12 significant digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.11e}").parse().unwrap_or(value)
}

/// Field points of a design.
#[derive(Clone, Debug, PartialEq)]
pub struct Fields {
    /// Meaning of the coordinates.
    pub kind: FieldKind,
    /// Coordinates along x and y: degrees or mm.
    pub points: Vec<[f64; 2]>,
}

/// Meaning of the coordinates of a field point.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldKind {
    /// Angle of the chief ray to the axis before the lens (degrees).
    Angle,
    /// Height of the object (mm).
    ObjectHeight,
    /// Height of the image (mm).
    ImageHeight,
}

/// A named state of zoom and focus.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Configuration {
    /// Name in the file, such as "Wide" or "2"; may be empty.
    pub name: String,
    /// Stated focal length (mm).
    pub focal_length: Option<f64>,
    /// Stated f-number.
    pub f_number: Option<f64>,
    /// Distance from the front vertex to the object (mm), infinite for a distant one.
    pub object_distance: Option<f64>,
    /// Stated magnification; 0 for a distant object.
    pub magnification: Option<f64>,
    /// Distance from the rear vertex to the film along the way of the light (mm).
    pub film_distance: Option<f64>,
    /// Values that this state gives to rows.
    pub settings: Vec<Setting>,
}

/// A value that a configuration gives to a row.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Setting {
    /// Row, from 0 at the scene side.
    pub row: usize,
    /// Quantity of the row.
    pub quantity: Quantity,
    /// Its value (mm; 1/mm for a curvature).
    pub value: f64,
}

/// A quantity of a row that a configuration may change.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Distance to the next vertex.
    Thickness,
    /// Curvature at the vertex.
    Curvature,
    /// Clear diameter.
    Diameter,
}

impl Design {
    /// Returns the primary wavelength (nm): that of the file, otherwise the d line.
    pub fn primary_wavelength(&self) -> f64 {
        self.wavelengths.get(self.primary).map_or(D_LINE, |line| line.nm)
    }
}
