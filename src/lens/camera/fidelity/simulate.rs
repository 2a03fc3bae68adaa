//! Cameras whose lens is replaced by a model of another fidelity.

use super::{Fidelity, gaussian, polynomial, thin};
use crate::camera::band::Band;
use crate::camera::{Camera, LensColumns, LensModel, RealLens};
use crate::prescription::Prescription;
use crate::prescription::pose::FilmPlane;
use petzval_base::lanes::f32x8;
use petzval_base::rays::{SampleBatch, WAVE_SIZE};
use petzval_base::sampler::{Dimension, sample_2d};
use petzval_base::stats::LensStats;

impl Camera {
    /// Returns this camera with its real lens modelled at a fidelity. Its effects stay: dispersion
    /// and losses apply in models with surfaces and are left out in others. A camera without a real
    /// lens stays as it is. This takes up to a tenth of a second.
    pub fn with_fidelity(&self, fidelity: Fidelity) -> Self {
        let LensModel::Real(lens) = &self.model else { return self.clone() };
        let mut size = self.film;
        let model = match fidelity {
            Fidelity::Single => (**lens).clone(),
            Fidelity::Double => lens.doubled(),
            Fidelity::Polynomial => lens.fitted(),
            Fidelity::Paraxial | Fidelity::Thick => {
                let (film, scale) = gaussian::refocused(lens);
                size = [0, 1].map(|i| size[i] * scale[i]);
                let ideal = match fidelity {
                    Fidelity::Paraxial => gaussian::paraxial(&lens.monochromatic()),
                    _ => gaussian::thick(&lens.monochromatic(), &film),
                };
                lens.replaced(film, ideal)
            }
            Fidelity::Thin | Fidelity::Pinhole => {
                let has_aperture = fidelity == Fidelity::Thin;
                return thin::thin(self, lens, has_aperture, on_axis_irradiance(lens));
            }
        };
        let exposure_ratio = match fidelity {
            Fidelity::Single | Fidelity::Double => 1.0,
            _ => on_axis_irradiance(lens) / on_axis_irradiance(&model),
        };
        let exposure_ratio = if exposure_ratio.is_finite() { exposure_ratio } else { 1.0 };
        Self {
            model: LensModel::Real(Box::new(model)),
            film: size,
            imaging_ratio: self.imaging_ratio * exposure_ratio,
            ..self.clone()
        }
    }
}

impl RealLens {
    /// Returns the lens with its surfaces as polynomials.
    fn fitted(&self) -> Self {
        let mut lens = self.clone();
        if let Some(band) = polynomial::fitted(self, &self.monochromatic(), self.response()) {
            lens.bands = vec![band];
            lens.pupil_bounds.fans_only = true;
        }
        lens.fresnel = false;
        lens
    }

    /// Returns the lens with every ray traced in f64.
    fn doubled(&self) -> Self {
        let mut lens = self.clone();
        lens.trace_in_f64 = true;
        lens
    }

    /// Returns the prescription at the wavelength of its only band, or at the primary one if it
    /// has several.
    pub(super) fn monochromatic(&self) -> Prescription {
        match &self.bands[..] {
            [band] if band.wavelength != self.prescription.design.primary_wavelength() => {
                self.prescription.at_checked_wavelength(band.wavelength)
            }
            _ => self.prescription.clone(),
        }
    }

    /// Returns another lens and film in its place, with one band and without losses.
    fn replaced(&self, film: FilmPlane, lens: Prescription) -> Self {
        let mut lens =
            Self::with_film(lens, &film, self.pupil_sampling, self.units_per_mm, self.front_depth);
        lens.bands.iter_mut().for_each(|band| band.response = self.response());
        lens
    }

    /// Returns the mean response of its bands in red, green and blue.
    fn response(&self) -> [f64; 3] {
        let sum = |i: usize| self.bands.iter().map(|band: &Band| band.response[i]).sum::<f64>();
        [0, 1, 2].map(|i| sum(i) / self.bands.len() as f64)
    }
}

/// Number of waves of rays that measure the exposure.
const EXPOSURE_WAVES: usize = 16;

/// Returns the irradiance for a radiance of 1 where the axis meets the film: the mean weight of
/// samples over the pupil and the bands. It traces about 16,000 rays.
pub fn on_axis_irradiance(lens: &RealLens) -> f64 {
    let mut samples = SampleBatch { len: WAVE_SIZE, ..SampleBatch::default() };
    for axis in 0..2 {
        samples.film[axis].fill(-lens.film_pose.decentre[axis] as f32);
    }
    let mut columns = LensColumns::default();
    let mut stats = LensStats::default();
    let mut sum = 0.0;
    for wave in 0..EXPOSURE_WAVES {
        for i in 0..WAVE_SIZE {
            let point = sample_2d(0, (wave * WAVE_SIZE + i) as u32, Dimension::Pupil);
            [samples.pupil[0][i], samples.pupil[1][i]] = point;
        }
        samples.band = wave % lens.bands.len();
        lens.trace_samples::<f32x8>(&samples, &mut columns, lens.fresnel, &mut stats);
        sum += columns.batch.total_weight();
    }
    sum / (EXPOSURE_WAVES * WAVE_SIZE) as f64
}
