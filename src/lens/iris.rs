//! The shape of the opening of a stop.

use std::f64::consts::{FRAC_PI_4, SQRT_2};
use std::path::Path;
use std::sync::Arc;

use crate::image::{ImageError, Picture};

/// What the opening of a stop looks like, inside its clear diameter.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Iris {
    /// A circle: the clear diameter itself.
    #[default]
    Round,
    /// The opening that blades leave; its corners touch the clear diameter.
    Blades {
        /// How many, from 3.
        count: u32,
        /// Angle of the first corner from +x towards +y, degrees.
        rotation: f64,
        /// Curvature of the blades' edges in units of the round opening's: 0 straight, 1 a circle.
        curvature: f64,
    },
    /// Transmission over the square around the clear diameter.
    Mask(Mask),
}

/// A square grid of transmissions over the square around an opening.
#[derive(Clone, Debug, PartialEq)]
pub struct Mask {
    /// What it is: a name of pbrt's or of a file.
    pub name: String,
    /// Rows and columns.
    pub size: usize,
    /// Row by row, the first at the top (+y), seen from the film.
    pub transmission: Arc<[f32]>,
    /// The reference and the extent of the transmissions.
    pub convention: Convention,
}

/// The meaning that a file format gives to a mask.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Convention {
    /// A lens file: shares of the light, 0 to 1, inside the round opening. The picture gets darker by
    /// what the mask takes.
    #[default]
    Physical,
    /// pbrt-v4's camera: multiples whose mean over the square is pi / 4, so that the picture is as
    /// bright as with the round opening. The whole square is open, and points between the centres of
    /// two pixels are interpolated.
    Pbrt,
}

/// No more points than a picture of 4096 by 4096.
const MOST_SIZE: usize = 4096;

impl Mask {
    /// The mask by pbrt-v4's convention (`RealisticCamera::Create`).
    pub(super) fn normalized(self) -> Self {
        let sum: f64 = self.transmission.iter().map(|&t| f64::from(t)).sum();
        let scale = FRAC_PI_4 * self.transmission.len() as f64 / sum;
        let scaled = self.transmission.iter().map(|&t| (f64::from(t) * scale) as f32);
        Self { transmission: scaled.collect(), convention: Convention::Pbrt, ..self }
    }

    /// A square picture as a mask: the mean of its channels, decoded from sRGB where they have 8
    /// bits, clipped to 0 to 1. What is no number lets nothing through.
    ///
    /// # Errors
    /// Where the file is no picture, or not square, or black.
    pub fn image(path: &Path) -> Result<Self, ImageError> {
        Self::read(path, 1.0)
    }

    /// A square picture as pbrt-v4's camera takes it: as bright as the round opening.
    ///
    /// # Errors
    /// As those of [`Self::image`].
    pub fn image_by_pbrt(path: &Path) -> Result<Self, ImageError> {
        Ok(Self::read(path, f32::MAX)?.normalized())
    }

    fn read(path: &Path, most: f32) -> Result<Self, ImageError> {
        let Picture { size: [width, height], pixels } = Picture::read(path, true)?;
        let refuse = |found: String| ImageError::Malformed { path: path.to_owned(), found };
        if width != height || width == 0 || width > MOST_SIZE {
            return Err(refuse(format!(
                "it has {width} x {height} pixels; an aperture is square, at most {MOST_SIZE} wide"
            )));
        }
        let grey = |rgb: &[f32; 3]| {
            let mean = rgb.iter().sum::<f32>() / 3.0;
            if mean > 0.0 { mean.min(most) } else { 0.0 }
        };
        let transmission: Arc<[f32]> = pixels.iter().map(grey).collect();
        if transmission.iter().all(|&t| t == 0.0) {
            return Err(refuse("it is black; an aperture lets light through".into()));
        }
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        Ok(Self { name, size: width, transmission, convention: Convention::Physical })
    }

    /// The transmission at a point, for an opening of this half width; 0 beyond.
    pub(super) fn at(&self, x: f64, y: f64, half: f64) -> f64 {
        let place = |v: f64| (v / half + 1.0) / 2.0 * self.size as f64;
        let [column, row] = [place(x), place(-y)];
        match self.convention {
            Convention::Physical => self.pixel(column, row),
            Convention::Pbrt => {
                let (left, above) = (column - 0.5, row - 0.5);
                let (s, t) = (left - left.floor(), above - above.floor());
                let mix =
                    |row: f64| (1.0 - s) * self.pixel(left, row) + s * self.pixel(left + 1.0, row);
                (1.0 - t) * mix(above) + t * mix(above + 1.0)
            }
        }
    }

    /// The pixel in which a point lies; 0 beyond the picture.
    fn pixel(&self, column: f64, row: f64) -> f64 {
        let size = self.size as f64;
        if !(0.0..size).contains(&column) || !(0.0..size).contains(&row) {
            return 0.0;
        }
        f64::from(self.transmission[row as usize * self.size + column as usize])
    }
}

impl Iris {
    /// How far from the axis light passes at most, in units of half the clear diameter.
    pub fn reach(&self) -> f64 {
        match self {
            // Interpolation ends half a pixel beyond the corner of the square.
            Self::Mask(mask) if mask.convention == Convention::Pbrt => {
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
    fn the_masks_of_pbrt_are_interpolated_and_open_to_their_corners() {
        let transmission = [1.0, 1.0, 1.0, 1.0].into();
        let convention = Convention::Pbrt;
        let mask = Mask { name: "white".into(), size: 2, transmission, convention };
        assert_eq!([mask.at(0.0, 0.0, 1.0), mask.at(0.5, -0.5, 1.0)], [1.0, 1.0]);
        assert_eq!([mask.at(1.0, 0.0, 1.0), mask.at(1.0, 1.0, 1.0)], [0.5, 0.25]);
        assert_eq!(mask.at(1.6, 0.0, 1.0), 0.0);
        let physical = Mask { convention: Convention::Physical, ..mask };
        assert_eq!(physical.at(0.99, 0.99, 1.0), 1.0);
        assert!(Iris::Mask(physical).reach() == 1.0);
    }
}
