//! Ghosts: light that is reflected twice inside the lens.
//!
//! Two surfaces that each reflect a few percent form a second, fainter and mostly unsharp image of
//! a bright source: one for every pair of surfaces. Paths from the film would hardly ever hit such
//! a source, so ghosts use light tracing: a light is sampled from points of the front surface, its
//! rays are traced through the pair's sequence of surfaces, and the light that arrives is splatted
//! on the film (the pairs are those of Hullin et al. 2011, "Physically-based real-time lens flare
//! rendering"). Every surface reflects or transmits its exact share, by angle.
//!
//! Not simulated: light reflected four times or more, and light reflected by the film; light that
//! reaches the lens by mirrors, panes or bright walls; uniform skies; and light that enters from
//! behind the plane of the front vertex.

mod estimate;
mod trace;

pub use estimate::{GhostEstimate, direct_peak, estimate};

use petzval_base::distribution::Distribution;
use petzval_lens::{Prescription, Surface, ghost_sequence};
use petzval_spectrum::LightBand;

/// The simulated ghosts of a picture.
#[derive(Clone, Debug)]
pub struct Ghosts {
    /// The brightest pairs.
    pub pairs: Vec<GhostPair>,
    /// The lens with its coatings.
    lens: Prescription,
    /// Share of the film that light reaches without reflections: outside the image circle the camera takes
    /// no samples.
    lit: f64,
    /// Bands of the light: a single one if neither glass nor a coating has a colour.
    bands: Vec<LightBand>,
}

/// Two surfaces that reflect.
#[derive(Clone, Debug)]
pub struct GhostPair {
    /// Their rows, from 0 at the scene side. Light meets the second one first.
    pub rows: [usize; 2],
    /// Probability that a wave of light paths samples this pair.
    pub share: f64,
    /// Sampling density of the entry points, over the square about the front surface.
    entry: Distribution,
}

/// Returns all pairs of rows that both reflect light.
pub fn pairs(lens: &Prescription) -> Vec<[usize; 2]> {
    let mirrors: Vec<usize> =
        (0..lens.rows.len()).filter(|&row| lens.transmittance(row) < 1.0).collect();
    let below = |&second: &usize| mirrors.iter().filter(move |&&row| row < second);
    mirrors.iter().flat_map(|second| below(second).map(move |&first| [first, *second])).collect()
}

impl Ghosts {
    /// Returns the surfaces of a pair at the wavelength of a band.
    fn surfaces(&self, pair: &GhostPair, band: usize) -> Vec<Surface<f32>> {
        let nm = self.bands[band].wavelength;
        ghost_sequence::<f32>(&self.lens.at_checked_wavelength(nm), pair.rows, nm)
    }
}
