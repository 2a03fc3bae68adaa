//! Caustics: light that mirrors and clear glass throw onto other surfaces.
//!
//! A camera path finds a caustic only if the direction in which it leaves a diffuse surface happens
//! to lead through the glass to the lamp. A light path starts there instead: with a point of a
//! surface that reflects or refracts, a *caster*, and a point of a light that shines on it. From
//! each later surface that scatters widely it is connected to a point before the lens, traced to the
//! film and splatted (light tracing, t = 1 of Veach 1997, section 10.2).
//!
//! The two kinds of paths divide the light between them, so that no weights are needed. Light paths
//! take all paths from an area light
//! - whose first surface after the light is a mirror or clear glass, and
//! - whose last surface before the lens [receives caustics](crate::shade::shade_light_paths): it is
//!   no clear glass, and no lobe of it is narrow.
//!
//! Camera paths leave out exactly these. They keep what the lens sees in mirrors and through glass,
//! which no connection to the lens can find, and the light of skies and point lights.

mod caster;
mod entry;
mod start;
mod survey;
mod walk;

pub use survey::survey_caustics;

use crate::distribution::DiscreteDistribution;
use crate::film::{Frame, PixelFilter};
use crate::lens::RealLens;
use crate::light_tracing::light_paths::{FrontEntry, PathCount, SplatStage};
use caster::Caster;
use entry::EntrySampler;

/// The surfaces that throw caustics, and the lens as light paths enter it.
#[derive(Clone, Debug)]
pub struct Caustics {
    casters: Vec<Caster>,
    /// Choice of a caster.
    choice: DiscreteDistribution,
    entry: EntrySampler,
    front: FrontEntry,
}

/// Samples of the picture per light path.
const SAMPLES_PER_PATH: u64 = 16;

/// Returns the number of light paths per sample number.
fn path_count(frame: &Frame) -> PathCount {
    PathCount::new(frame.resolution, SAMPLES_PER_PATH)
}

impl Caustics {
    /// Returns the largest size of the splats that wait to be added to the film (bytes).
    pub fn bytes_waiting(frame: &Frame, filter: &PixelFilter, lens: &RealLens) -> u64 {
        SplatStage::filtered(path_count(frame), filter, lens).bytes_waiting()
    }

    /// Returns the number of casters.
    pub fn casters(&self) -> usize {
        self.casters.len()
    }

    /// Sets the probabilities of the casters in proportion to these numbers.
    fn set_shares(&mut self, weights: &[f64]) {
        let total: f64 = weights.iter().sum();
        let shares: Vec<f64> = weights.iter().map(|weight| weight / total).collect();
        for (caster, &share) in self.casters.iter_mut().zip(&shares) {
            caster.share = share;
        }
        self.choice = DiscreteDistribution::from_probabilities(&shares);
    }
}
