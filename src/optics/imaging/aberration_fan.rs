//! Ray fans and fans of optical path difference.

use super::image_quality::{FieldRays, ImageQuality};

/// A ray of a fan.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AberrationPoint {
    /// Coordinate in the stop, relative to its radius.
    pub stop: f64,
    /// Distance on the film from the chief ray at the primary wavelength (mm).
    pub aberration: [f64; 2],
    /// Optical path difference to the reference sphere (wavelengths); positive where the ray is
    /// shorter than the chief ray.
    pub waves: f64,
    /// Whether the ray passes all rims.
    pub passes: bool,
}

/// Rays of a field and a wavelength along a line through the centre of the stop.
#[derive(Clone, Debug, PartialEq)]
pub struct AberrationFan {
    /// Wavelength (nm).
    pub nm: f64,
    /// Rays from -1 to 1; rays that miss a surface are left out.
    pub points: Vec<AberrationPoint>,
}

impl ImageQuality {
    /// Returns the fans of a field along x (0, sagittal) or y (1, tangential), for every
    /// wavelength, with `count` rays to each side of the chief ray.
    pub fn fans(&self, field: &FieldRays, axis: usize, count: u32) -> Vec<AberrationFan> {
        self.lenses
            .iter()
            .zip(&field.chiefs)
            .map(|(lens, chief)| {
                let mut points = Vec::new();
                let Some(chief) = chief else {
                    return AberrationFan { nm: lens.nm, points };
                };
                let zero = lens.aim(chief, [0.0; 2]);
                let zero = zero.map_or(f64::NAN, |ray| field.reference.path_difference(&ray));
                for i in -i64::from(count)..=i64::from(count) {
                    let stop = i as f64 / f64::from(count);
                    let mut at = [0.0; 2];
                    // Rounding must not put the marginal ray beyond the rim.
                    at[axis] = stop * (1.0 - 1e-9);
                    let Some(ray) = lens.aim(chief, at) else { continue };
                    let path = field.reference.path_difference(&ray) - zero;
                    points.push(AberrationPoint {
                        stop,
                        aberration: [0, 1].map(|i| ray.point[i] - field.reference.point[i]),
                        waves: -path / lens.wavelength(),
                        passes: ray.clipped.is_none(),
                    });
                }
                AberrationFan { nm: lens.nm, points }
            })
            .collect()
    }
}
