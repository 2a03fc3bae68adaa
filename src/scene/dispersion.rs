//! Refractive indices of materials that depend on the wavelength.

use std::sync::Arc;

use petzval_spectrum::BandSpectrum;

use super::{MaterialModel, Texture};

/// Refractive index by wavelength; `None` if it is constant.
pub type Dispersion = Option<Arc<BandSpectrum>>;

impl MaterialModel {
    /// A sheet of glass that does not disperse light, of a refractive index and a tint of what it transmits.
    pub fn thin_sheet(eta: f32, tint: Texture) -> Self {
        Self::ThinDielectric { eta: [eta; 3], dispersion: None, tint }
    }

    /// Returns whether the surface refracts each wavelength into another direction, so that one of those of a
    /// path goes on.
    pub(super) fn needs_hero(&self) -> bool {
        match self {
            Self::Dielectric { dispersion, .. } => dispersion.is_some(),
            Self::Subsurface { interior, .. } => interior.dispersion.is_some(),
            Self::CoatedDiffuse { coat, .. } | Self::CoatedConductor { coat, .. } => {
                coat.dispersion.is_some()
            }
            _ => false,
        }
    }

    /// Replaces a refractive index that depends on the wavelength by those of a set. Returns whether light
    /// goes on in the direction of the wavelength `hero` alone.
    pub(super) fn fix_index(&mut self, set: usize, hero: usize) -> bool {
        let (eta, dispersion) = match self {
            Self::ThinDielectric { eta, dispersion, .. } => {
                if let Some(spectrum) = dispersion.take() {
                    *eta = spectrum.in_set(set);
                }
                return false;
            }
            Self::Dielectric { eta, dispersion, .. } => (eta, dispersion),
            Self::Subsurface { interior, .. } => (&mut interior.eta, &mut interior.dispersion),
            Self::CoatedDiffuse { coat, .. } | Self::CoatedConductor { coat, .. } => {
                (&mut coat.eta, &mut coat.dispersion)
            }
            _ => return false,
        };
        let Some(spectrum) = dispersion.take() else { return false };
        *eta = spectrum.in_set(set)[hero];
        true
    }
}
