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
    /// Rotation about its centre, from x towards y (degrees).
    pub rotation: f64,
    /// Whether the inside is opaque; otherwise the outside is.
    pub obscures: bool,
}

impl SurfaceAperture {
    /// Creates an open circle of a radius (mm) around a centre (mm).
    pub fn circle(radius: f64, centre: [f64; 2]) -> Self {
        let half_widths = [radius; 2];
        Self { form: ApertureForm::Ellipse, half_widths, centre, rotation: 0.0, obscures: false }
    }

    /// Creates an opaque arm of a spider: a bar of a width (mm) from the vertex outwards to a radius
    /// (mm), in a direction from x towards y (degrees).
    pub fn arm(width: f64, radius: f64, direction: f64) -> Self {
        let (sin, cos) = direction.to_radians().sin_cos();
        Self {
            form: ApertureForm::Rectangle,
            half_widths: [radius / 2.0, width / 2.0],
            centre: [cos, sin].map(|along| along * radius / 2.0),
            rotation: direction,
            obscures: true,
        }
    }

    /// Returns the same shape with an opaque inside.
    pub fn obscuring(self) -> Self {
        Self { obscures: true, ..self }
    }

    /// Returns whether light passes at a point of the surface (mm).
    pub fn transmits(&self, x: f64, y: f64) -> bool {
        let (sin, cos) = self.rotation.to_radians().sin_cos();
        let [dx, dy] = [x - self.centre[0], y - self.centre[1]];
        let u = (dx * cos + dy * sin) / self.half_widths[0];
        let v = (dy * cos - dx * sin) / self.half_widths[1];
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
            ApertureForm::Rectangle if self.rotation == 0.0 => (x.abs() + w).hypot(y.abs() + h),
            ApertureForm::Rectangle => x.hypot(y) + w.hypot(h),
            ApertureForm::Ellipse => x.hypot(y) + w.max(h),
        }
    }

    /// Returns the half-widths (mm) of the smallest ellipse of its proportions that contains the
    /// shape, or of a circle around a rotated one.
    pub(crate) fn ellipse_around(&self) -> [f64; 2] {
        let [w, h] = self.half_widths;
        match self.form {
            ApertureForm::Rectangle if self.rotation != 0.0 => [w.hypot(h); 2],
            ApertureForm::Ellipse if self.rotation != 0.0 => [w.max(h); 2],
            ApertureForm::Rectangle => self.half_widths.map(|half| half * SQRT_2),
            ApertureForm::Ellipse => self.half_widths,
        }
    }

    /// Returns the lowest and the highest y of the shape (mm).
    pub fn range_along_y(&self) -> [f64; 2] {
        let (sin, cos) = self.rotation.to_radians().sin_cos();
        let [along, across] = [self.half_widths[0] * sin, self.half_widths[1] * cos];
        let half = match self.form {
            ApertureForm::Rectangle => along.abs() + across.abs(),
            ApertureForm::Ellipse => along.hypot(across),
        };
        [self.centre[1] - half, self.centre[1] + half]
    }

    /// Returns whether this obscures the way to the rim of a surface of this semi-diameter (mm) in some
    /// direction, as the arm of a spider does. Focus, f-number and drawings, which are those of rays in
    /// the planes of x and y, leave arms out.
    pub fn is_arm(&self, semi_diameter: f64) -> bool {
        let [x, y] = self.centre;
        let length = x.hypot(y);
        let own = if length > 0.0 { [x / length, y / length] } else { [1.0, 0.0] };
        let blocks = |[x, y]: [f64; 2]| {
            [0.5, 0.75, 0.999].iter().all(|share| {
                let at = share * semi_diameter;
                !self.transmits(x * at, y * at)
            })
        };
        let directions = [own, [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]];
        self.obscures && directions.into_iter().any(blocks)
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
        write!(f, "{form} {kind}, {} mm by {} mm, centre ({x}, {y}) mm", 2.0 * w, 2.0 * h)?;
        match self.rotation == 0.0 {
            true => Ok(()),
            false => write!(f, ", rotated by {} degrees", self.rotation),
        }
    }
}
