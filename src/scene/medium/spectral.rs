//! Media at the wavelengths of a set.

use petzval_spectrum::{BandSpectrum, uplift_matrix};

use super::field::{DensityField, Field, FieldEmission};
use super::homogeneous::Homogeneous;
use super::{DiffuseBoundary, Medium, MediumColours, MediumModel};

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
        let in_rgb;
        let MediumColours { absorption, scattering, emission } = match &medium.colours {
            Some(colours) => colours,
            None => {
                in_rgb = medium.model.colours();
                &in_rgb
            }
        };
        let [absorption, scattering, emission] =
            [absorption, scattering, emission].map(|colour| colour.unbounded_spectrum());
        Self { absorption, scattering, emission, thermal: medium.model.thermal_radiances() }
    }
}

impl MediumModel {
    /// Returns the coefficients as colours, those of a field at density 1.
    fn colours(&self) -> MediumColours {
        let (mut absorption, mut scattering, mut emission) = ([1.0; 3], [1.0; 3], [0.0; 3]);
        match self {
            Self::Homogeneous(medium) => {
                (absorption, scattering) = (medium.absorption, medium.scattering);
                emission = medium.emission;
            }
            Self::Varying(varying) => match &varying.field {
                Field::Density(field) => {
                    (absorption, scattering) = (field.absorption, field.scattering);
                    if let Some(FieldEmission::Scaled { radiance, .. }) = &field.emission {
                        emission = *radiance;
                    }
                }
                Field::Cloud { absorption: a, scattering: s, .. } => {
                    (absorption, scattering) = (*a, *s);
                }
                Field::Colour { .. } => (),
            },
        }
        let [absorption, scattering, emission] = [absorption, scattering, emission].map(Into::into);
        MediumColours { absorption, scattering, emission }
    }

    /// Returns the radiances of the table of black bodies, if there is one.
    fn thermal_radiances(&self) -> Vec<BandSpectrum> {
        match self {
            Self::Varying(varying) => match &varying.field {
                Field::Density(DensityField {
                    emission: Some(FieldEmission::Thermal { radiance, .. }),
                    ..
                }) => radiance.by_wavelength(),
                _ => Vec::new(),
            },
            Self::Homogeneous(_) => Vec::new(),
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

    /// Returns the medium at the wavelengths of a set, with the boundary of the hero.
    pub(crate) fn in_set(&self, spectra: &MediumSpectra, set: usize, hero: usize) -> Self {
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
        let boundary = match &self.boundary_dispersion {
            Some(eta) => Some(DiffuseBoundary::new(eta.in_set(set)[hero])),
            None => self.boundary,
        };
        Self { boundary, ..Self::new(model, self.g, None) }
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
