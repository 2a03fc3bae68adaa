//! A camera whose lens is simulated less exactly than it could be, or more.

mod double;
mod exposure;
mod focus;
mod gaussian;
mod least_squares;
mod polynomial;
mod pupil_point;
mod thin;

pub(super) use double::{ExactColumns, launched};
pub(super) use pupil_point::PupilPoint;

use super::band::Band;
use super::camera::{Camera, Model, RealLens};
use super::fidelity::Fidelity;
use super::glass::D_LINE;
use super::pose::FilmPlane;
use super::prescription::Prescription;

impl Camera {
    /// This camera with its real lens simulated so exactly, with the effects that it simulates now:
    /// dispersion and losses go on where the model knows of surfaces, and are left out elsewhere. A
    /// camera without a lens of glass stays as it is. Up to a tenth of a second.
    pub fn simulated(&self, fidelity: Fidelity) -> Self {
        let Model::Real(lens) = &self.model else { return self.clone() };
        let mut size = self.film;
        let model = match fidelity {
            Fidelity::Single => (**lens).clone(),
            Fidelity::Double => lens.doubled(),
            Fidelity::Polynomial => lens.fitted(),
            Fidelity::Paraxial | Fidelity::Thick => {
                let (film, scale) = focus::refocused(lens);
                size = [0, 1].map(|i| size[i] * scale[i]);
                let ideal = match fidelity {
                    Fidelity::Paraxial => gaussian::paraxial(&lens.plain()),
                    _ => gaussian::thick(&lens.plain(), &film),
                };
                lens.replaced(film, ideal)
            }
            Fidelity::Thin | Fidelity::Pinhole => {
                let open = fidelity == Fidelity::Thin;
                return thin::thin(self, lens, open, exposure::on_axis(lens));
            }
        };
        let metered = match fidelity {
            Fidelity::Single | Fidelity::Double => 1.0,
            _ => exposure::on_axis(lens) / exposure::on_axis(&model),
        };
        let metered = if metered.is_finite() { metered } else { 1.0 };
        Self {
            model: Model::Real(Box::new(model)),
            film: size,
            imaging_ratio: self.imaging_ratio * metered,
            ..self.clone()
        }
    }
}

impl RealLens {
    /// The same, by polynomials.
    fn fitted(&self) -> Self {
        let mut lens = self.clone();
        if let Some(band) = polynomial::fitted(self, &self.plain(), self.response()) {
            lens.bands = vec![band];
            lens.bound.strict = true;
        }
        lens.fresnel = false;
        lens
    }

    /// The same, with every ray in f64.
    fn doubled(&self) -> Self {
        let mut lens = self.clone();
        lens.double = true;
        lens
    }

    /// The lens for the light that it is traced in; that of the d line where it is taken apart.
    fn plain(&self) -> Prescription {
        match &self.bands[..] {
            [band] if band.wavelength != D_LINE => self.prescription.at_wavelength(band.wavelength),
            _ => self.prescription.clone(),
        }
    }

    /// Another lens and film in its place, for all light at once and without losses.
    fn replaced(&self, film: FilmPlane, lens: Prescription) -> Self {
        let mut lens = Self::posed(lens, &film, self.aiming, self.unit, self.front);
        lens.bands.iter_mut().for_each(|band| band.response = self.response());
        lens
    }

    /// What all its bands together add to red, green and blue.
    fn response(&self) -> [f64; 3] {
        let sum = |i: usize| self.bands.iter().map(|band: &Band| band.response[i]).sum::<f64>();
        [0, 1, 2].map(|i| sum(i) / self.bands.len() as f64)
    }
}
