//! Media at the wavelengths of a set.

use petzval_spectrum::{BandSpectrum, uplift_matrix, uplift_unbounded};

use super::field::{DensityField, Field, FieldEmission};
use super::homogeneous::Homogeneous;
use super::{Medium, MediumModel};

/// Coefficients of a medium by wavelength.
#[derive(Clone, Debug)]
pub(crate) struct MediumSpectra {
    absorption: BandSpectrum,
    scattering: BandSpectrum,
    emission: BandSpectrum,
    /// Radiances of the table of black bodies; empty without one.
    thermal: Vec<BandSpectrum>,
}

impl MediumSpectra {
    pub fn of(medium: &Medium) -> Self {
        let (mut absorption, mut scattering, mut emission) = ([1.0; 3], [1.0; 3], [0.0; 3]);
        let mut thermal = Vec::new();
        match &medium.model {
            MediumModel::Homogeneous(medium) => {
                (absorption, scattering) = (medium.absorption, medium.scattering);
                emission = medium.emission;
            }
            MediumModel::Varying(varying) => match &varying.field {
                Field::Density(field) => {
                    (absorption, scattering) = (field.absorption, field.scattering);
                    match &field.emission {
                        Some(FieldEmission::Scaled { radiance, .. }) => emission = *radiance,
                        Some(FieldEmission::Thermal { radiance, .. }) => {
                            thermal = radiance.by_wavelength();
                        }
                        None => (),
                    }
                }
                Field::Cloud { absorption: a, scattering: s, .. } => {
                    (absorption, scattering) = (*a, *s);
                }
                Field::Colour { .. } => (),
            },
        }
        Self {
            absorption: uplift_unbounded(absorption),
            scattering: uplift_unbounded(scattering),
            emission: uplift_unbounded(emission),
            thermal,
        }
    }
}

impl Medium {
    /// Returns the memory that the medium of a set has alone (bytes).
    pub(crate) fn own_bytes(&self) -> usize {
        let own = match &self.model {
            MediumModel::Homogeneous(_) => 0,
            MediumModel::Varying(varying) => varying.own_bytes(),
        };
        size_of::<Self>() + own
    }

    /// Returns the medium at the wavelengths of a set.
    pub(crate) fn in_set(&self, spectra: &MediumSpectra, set: usize) -> Self {
        let absorption = spectra.absorption.in_set(set);
        let scattering = spectra.scattering.in_set(set);
        let model = match &self.model {
            MediumModel::Homogeneous(_) => {
                let emission = spectra.emission.in_set(set);
                MediumModel::Homogeneous(Homogeneous { absorption, scattering, emission })
            }
            MediumModel::Varying(varying) => {
                let mut field = varying.field.clone();
                let factor = field.replace_coefficients(absorption, scattering, spectra, set);
                MediumModel::Varying(Box::new(varying.with_field(field, factor)))
            }
        };
        Self { model, ..*self }
    }
}

impl Field {
    /// Replaces the coefficients by those at the wavelengths of a set. Returns a factor of the largest
    /// extinction that is large enough.
    fn replace_coefficients(
        &mut self,
        absorption: [f32; 3],
        scattering: [f32; 3],
        spectra: &MediumSpectra,
        set: usize,
    ) -> f32 {
        let largest = |a: &[f32; 3], s: &[f32; 3]| (0..3).map(|c| a[c] + s[c]).fold(0.0, f32::max);
        let (a, s) = match self {
            Self::Density(DensityField { absorption, scattering, emission, .. }) => {
                match emission {
                    Some(FieldEmission::Scaled { radiance, .. }) => {
                        *radiance = spectra.emission.in_set(set);
                    }
                    Some(FieldEmission::Thermal { radiance, .. }) => {
                        let table = spectra.thermal.iter().map(|entry| entry.in_set(set));
                        *radiance = radiance.with_radiances(table);
                    }
                    None => (),
                }
                (absorption, scattering)
            }
            Self::Cloud { absorption, scattering, .. } => (absorption, scattering),
            Self::Colour { uplift, .. } => {
                // The largest channel bounds all wavelengths, but for rounding.
                *uplift = Some(uplift_matrix(set));
                return 1.001;
            }
        };
        let before = largest(a, s);
        (*a, *s) = (absorption, scattering);
        if before > 0.0 { largest(a, s) / before * (1.0 + 4.0 * f32::EPSILON) } else { 1.0 }
    }
}
