//! Rectangular, elliptical or decentred aperture of a surface, or an obscuration of that shape.

use std::f64::consts::SQRT_2;
use std::fmt;

/// Form of an aperture, seen along the axis of its surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ApertureForm {
    /// A rectangle with sides along x and y.
    Rectangle,
    /// An ellipse with axes along x and y; a circle if its half-widths are equal.
    Ellipse,
}

/// An aperture or obscuration of a surface, in x and y of the surface (mm). It clips in addition to
/// the clear diameter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceAperture {
    /// Form.
    pub form: ApertureForm,
    /// Half-widths along x and y (mm), above 0.
    pub half_widths: [f64; 2],
    /// Centre, from the vertex (mm).
    pub centre: [f64; 2],
    /// Whether the inside is opaque; otherwise the outside is.
    pub obscures: bool,
}

impl SurfaceAperture {
    /// Creates an open circle of a radius (mm) around a centre (mm).
    pub fn circle(radius: f64, centre: [f64; 2]) -> Self {
        let half_widths = [radius; 2];
        Self { form: ApertureForm::Ellipse, half_widths, centre, obscures: false }
    }

    /// Returns the same shape with an opaque inside.
    pub fn obscuring(self) -> Self {
        Self { obscures: true, ..self }
    }

    /// Returns whether light passes at a point of the surface (mm).
    pub fn transmits(&self, x: f64, y: f64) -> bool {
        let u = (x - self.centre[0]) / self.half_widths[0];
        let v = (y - self.centre[1]) / self.half_widths[1];
        let place = match self.form {
            ApertureForm::Rectangle => u.abs().max(v.abs()),
            ApertureForm::Ellipse => u * u + v * v,
        };
        if self.obscures { place >= 1.0 } else { place <= 1.0 }
    }

    /// Returns the radius (mm) of a circle around the vertex that contains the shape.
    pub fn reach(&self) -> f64 {
        let ([x, y], [w, h]) = (self.centre, self.half_widths);
        match self.form {
            ApertureForm::Rectangle => (x.abs() + w).hypot(y.abs() + h),
            ApertureForm::Ellipse => x.hypot(y) + w.max(h),
        }
    }

    /// Returns the half-widths (mm) of the smallest ellipse of its proportions that contains the
    /// shape.
    pub(crate) fn ellipse_around(&self) -> [f64; 2] {
        match self.form {
            ApertureForm::Rectangle => self.half_widths.map(|half| half * SQRT_2),
            ApertureForm::Ellipse => self.half_widths,
        }
    }

    /// Returns the lowest and the highest y of the shape (mm).
    pub fn range_along_y(&self) -> [f64; 2] {
        [self.centre[1] - self.half_widths[1], self.centre[1] + self.half_widths[1]]
    }
}

impl fmt::Display for SurfaceAperture {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let ([x, y], [w, h]) = (self.centre, self.half_widths);
        let kind = if self.obscures { "obscuration" } else { "aperture" };
        let form = match self.form {
            ApertureForm::Rectangle => "rectangular",
            ApertureForm::Ellipse => "elliptical",
        };
        write!(f, "{form} {kind}, {} mm by {} mm, centre ({x}, {y}) mm", 2.0 * w, 2.0 * h)
    }
}
