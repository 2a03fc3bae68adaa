//! Spectral band: the surfaces of a lens for light of one wavelength.

use crate::prescription::Prescription;
use crate::trace::sequence::{Side, sequence_at};
use crate::trace::surface::Surface;
use petzval_base::lanes::Real;

/// Part of the visible light, traced at one wavelength, with its contribution to the picture.
#[derive(Clone, Debug)]
pub struct Band {
    /// Wavelength at which the band is traced (nm).
    pub wavelength: f64,
    /// Response in red, green and blue; 1 on average over all bands.
    pub response: [f64; 3],
    /// Refractive index of the medium before the film.
    pub film_index: f64,
    /// Surfaces for rays from the film.
    pub(crate) to_scene: Vec<Surface<f32>>,
    /// The same surfaces in f64.
    pub(crate) to_scene_f64: Vec<Surface<f64>>,
    /// Surfaces for rays from the plane of the front vertex; empty in a band of all light.
    pub(crate) to_film: Vec<Surface<f32>>,
    /// The same surfaces in f64.
    pub(crate) to_film_f64: Vec<Surface<f64>>,
}

impl Band {
    /// Prepares a lens for one wavelength (nm), with its film at this distance behind the rear
    /// vertex (mm). [`Prescription::check_wavelengths`] tells whether the data of its glass cover it.
    pub fn new(
        lens: &Prescription,
        film_distance: f64,
        wavelength: f64,
        response: [f64; 3],
    ) -> Self {
        let lens = lens.at_checked_wavelength(wavelength);
        Self {
            wavelength,
            response,
            film_index: lens.rear().index,
            to_scene: sequence_at::<f32>(&lens, Side::Film(film_distance), wavelength),
            to_scene_f64: sequence_at::<f64>(&lens, Side::Film(film_distance), wavelength),
            to_film: sequence_at::<f32>(&lens, Side::Scene(0.0), wavelength),
            to_film_f64: sequence_at::<f64>(&lens, Side::Scene(0.0), wavelength),
        }
    }

    /// Prepares one band for all light, traced at the primary wavelength with the indices of
    /// the file.
    pub fn all_light(lens: &Prescription, film_distance: f64) -> Self {
        let wavelength = lens.design.primary_wavelength();
        Self {
            wavelength,
            response: [1.0; 3],
            film_index: lens.rear().index,
            to_scene: sequence_at::<f32>(lens, Side::Film(film_distance), wavelength),
            to_scene_f64: sequence_at::<f64>(lens, Side::Film(film_distance), wavelength),
            to_film: Vec::new(),
            to_film_f64: Vec::new(),
        }
    }

    /// Returns the surfaces of a lens that has this band, for rays that start elsewhere.
    pub fn sequence<R: Real>(&self, lens: &Prescription, from: Side) -> Vec<Surface<R::Scalar>> {
        match self.to_film.is_empty() {
            true => sequence_at::<R>(lens, from, self.wavelength),
            false => {
                let lens = lens.at_checked_wavelength(self.wavelength);
                sequence_at::<R>(&lens, from, self.wavelength)
            }
        }
    }
}
