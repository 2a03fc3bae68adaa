//! Shape of the opening of a stop.

use std::f64::consts::{FRAC_PI_4, SQRT_2};
use std::sync::Arc;

/// Shape of the opening of a stop, inside its clear diameter.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Iris {
    /// A circle of the clear diameter.
    #[default]
    Round,
    /// An opening between blades; its corners lie on the clear diameter.
    Blades {
        /// Number of blades, from 3.
        count: u32,
        /// Angle of the first corner from +x towards +y (degrees).
        rotation: f64,
        /// Curvature of the edges over that of the clear diameter: 0 straight, 1 a circle.
        curvature: f64,
    },
    /// A mask over the square around the clear diameter.
    Mask(ApertureMask),
}

/// A square grid of transmissions over the square around an opening.
#[derive(Clone, Debug, PartialEq)]
pub struct ApertureMask {
    /// Name of the shape or of the file.
    pub name: String,
    /// Number of rows and of columns.
    pub size: usize,
    /// Transmissions row by row, the first at the top (+y), seen from the film.
    pub transmission: Arc<[f32]>,
    /// Meaning of the transmissions.
    pub convention: MaskConvention,
    /// Whether the mask draws a shape with straight edges: its pixels have none of their own.
    pub is_shape: bool,
}

/// Meaning that a file format gives to a mask.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MaskConvention {
    /// Lens files: transmissions from 0 to 1 inside the round opening. The mask darkens the
    /// picture.
    #[default]
    Physical,
    /// pbrt-v4's camera: factors whose mean over the square is pi / 4, so that the picture is as
    /// bright as with the round opening. The whole square is open, and values are interpolated
    /// between the centres of pixels.
    Pbrt,
    /// As [`Self::Physical`], but interpolated between the centres of pixels, to find the edges of a shape.
    Smooth,
}

impl ApertureMask {
    /// Scales the mask to pbrt-v4's convention (`RealisticCamera::Create`).
    pub fn normalized(self) -> Self {
        let sum: f64 = self.transmission.iter().map(|&t| f64::from(t)).sum();
        let scale = FRAC_PI_4 * self.transmission.len() as f64 / sum;
        let scaled = self.transmission.iter().map(|&t| (f64::from(t) * scale) as f32);
        Self { transmission: scaled.collect(), convention: MaskConvention::Pbrt, ..self }
    }

    /// Returns the transmission at a point of an opening of this semi-diameter; 0 outside the mask.
    pub(crate) fn at(&self, x: f64, y: f64, half: f64) -> f64 {
        let pixel = |v: f64| (v / half + 1.0) / 2.0 * self.size as f64;
        let [column, row] = [pixel(x), pixel(-y)];
        match self.convention {
            MaskConvention::Physical => self.pixel(column, row),
            MaskConvention::Pbrt | MaskConvention::Smooth => {
                let (left, above) = (column - 0.5, row - 0.5);
                let (s, t) = (left - left.floor(), above - above.floor());
                let mix =
                    |row: f64| (1.0 - s) * self.pixel(left, row) + s * self.pixel(left + 1.0, row);
                (1.0 - t) * mix(above) + t * mix(above + 1.0)
            }
        }
    }

    /// Returns the largest transmission.
    pub(crate) fn largest(&self) -> f32 {
        self.transmission.iter().fold(0.0, |a, &b| a.max(b))
    }

    /// Returns the value of the pixel that contains a point; 0 outside the mask.
    fn pixel(&self, column: f64, row: f64) -> f64 {
        let size = self.size as f64;
        if !(0.0..size).contains(&column) || !(0.0..size).contains(&row) {
            return 0.0;
        }
        f64::from(self.transmission[row as usize * self.size + column as usize])
    }
}

impl Iris {
    /// Returns the mask, if it is one.
    pub(crate) fn mask(&self) -> Option<&ApertureMask> {
        match self {
            Self::Mask(mask) => Some(mask),
            _ => None,
        }
    }

    /// Returns the same opening; a shape without the corners of its pixels.
    pub(crate) fn smooth(&self) -> Self {
        match self {
            Self::Mask(mask) if mask.is_shape && mask.convention == MaskConvention::Physical => {
                Self::Mask(ApertureMask { convention: MaskConvention::Smooth, ..mask.clone() })
            }
            other => other.clone(),
        }
    }

    /// Returns the greatest distance from the axis at which light passes, in semi-diameters.
    pub fn reach(&self) -> f64 {
        match self {
            // Interpolation ends half a pixel beyond the corner of the square.
            Self::Mask(mask) if mask.convention == MaskConvention::Pbrt => {
                SQRT_2 * (1.0 + 1.0 / mask.size as f64)
            }
            _ => 1.0,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn masks_by_pbrt_are_interpolated_and_open_to_their_corners() {
        let transmission = [1.0, 1.0, 1.0, 1.0].into();
        let convention = MaskConvention::Pbrt;
        let mask = ApertureMask {
            name: "white".into(),
            size: 2,
            transmission,
            convention,
            is_shape: false,
        };
        assert_eq!([mask.at(0.0, 0.0, 1.0), mask.at(0.5, -0.5, 1.0)], [1.0, 1.0]);
        assert_eq!([mask.at(1.0, 0.0, 1.0), mask.at(1.0, 1.0, 1.0)], [0.5, 0.25]);
        assert_eq!(mask.at(1.6, 0.0, 1.0), 0.0);
        let physical = ApertureMask { convention: MaskConvention::Physical, ..mask };
        assert_eq!(physical.at(0.99, 0.99, 1.0), 1.0);
        assert!(Iris::Mask(physical).reach() == 1.0);
    }
}
