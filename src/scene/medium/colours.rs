//! Colours of a medium's coefficients, and the spectra that they stand for.

use std::sync::Arc;

use petzval_spectrum::Colour;

/// Coefficients of a medium as colours; those of a field are at density 1.
#[derive(Clone, Debug)]
pub struct MediumColours {
    /// Absorption coefficient.
    pub absorption: Colour,
    /// Scattering coefficient.
    pub scattering: Colour,
    /// Emitted radiance.
    pub emission: Colour,
}

impl MediumColours {
    /// The colours of a medium that emits nothing.
    pub fn dark(absorption: Colour, scattering: Colour) -> Self {
        Self { absorption, scattering, emission: [0.0; 3].into() }
    }

    /// Returns the colours for a [`Medium`](super::Medium), which keeps them if a spectrum is known.
    pub fn if_spectral(self) -> Option<Arc<Self>> {
        let Self { absorption, scattering, emission } = &self;
        let known = [absorption, scattering, emission].into_iter().any(Colour::has_spectrum);
        known.then(|| Arc::new(self))
    }
}
