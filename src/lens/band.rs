//! A lens for light of one colour.

use super::glass::D_LINE;
use super::prescription::Prescription;
use super::surface::{From, Surface, sequence, sequence_at};

/// A part of the visible light, traced at one wavelength, and what it counts in the picture.
#[derive(Clone, Debug)]
pub struct Band {
    /// nm.
    pub wavelength: f64,
    /// What light of the band adds to red, green and blue; 1 on average over all bands.
    pub response: [f64; 3],
    pub(super) surfaces: Vec<Surface<f32>>,
    pub(super) exact: Vec<Surface<f64>>,
    /// For light from the scene that starts at the front vertex; none for all light at once.
    pub(super) back: Vec<Surface<f32>>,
    pub(super) back_exact: Vec<Surface<f64>>,
}

impl Band {
    /// A lens with its film at this distance behind the rear vertex, mm, in this light.
    pub fn new(
        lens: &Prescription,
        film_distance: f64,
        wavelength: f64,
        response: [f64; 3],
    ) -> Self {
        let lens = lens.at_wavelength(wavelength);
        Self {
            wavelength,
            response,
            surfaces: sequence_at::<f32>(&lens, From::Film(film_distance), wavelength),
            exact: sequence_at::<f64>(&lens, From::Film(film_distance), wavelength),
            back: sequence_at::<f32>(&lens, From::Scene(0.0), wavelength),
            back_exact: sequence_at::<f64>(&lens, From::Scene(0.0), wavelength),
        }
    }

    /// All light, traced at the d line with the indices that the file gives.
    pub fn whole(lens: &Prescription, film_distance: f64) -> Self {
        Self {
            wavelength: D_LINE,
            response: [1.0; 3],
            surfaces: sequence::<f32>(lens, From::Film(film_distance)),
            exact: sequence::<f64>(lens, From::Film(film_distance)),
            back: Vec::new(),
            back_exact: Vec::new(),
        }
    }
}
