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
mod start;
mod survey;
mod walk;

pub(crate) use survey::survey;
pub(crate) use walk::CausticColumns;

use crate::advance::PathColumns;
use crate::film::{Frame, Splat};
use crate::light_tracing::entry::EntrySampler;
use crate::light_tracing::light_paths::{
    FrontEntry, LightPathInput, LightPaths, PathCount, add_splats,
};
use caster::Caster;
use petzval_base::distribution::DiscreteDistribution;
use petzval_base::lanes::Real;
use petzval_base::rays::SampleBatch;
use petzval_base::sampler::pixel_key;
use petzval_lens::RealLens;
use walk::Connected;

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

impl Caustics {
    /// Size of the columns of a worker (bytes).
    pub(crate) const COLUMN_BYTES: usize = size_of::<CausticColumns>()
        + size_of::<SampleBatch>()
        + PathColumns::BOXED_BYTES
        + size_of::<LightPaths>();

    /// Returns the number of light paths per sample number.
    pub(crate) fn path_count(&self, frame: &Frame) -> PathCount {
        PathCount::new(frame.resolution, SAMPLES_PER_PATH)
    }

    /// Traces a wave of a sample number and returns its splats.
    pub(crate) fn trace<R: Real<Scalar = f32>>(
        &self,
        input: &LightPathInput<'_>,
        lens: &RealLens,
        columns: &mut CausticColumns,
        [wave, sample]: [u32; 2],
    ) -> Vec<Splat> {
        let count = self.path_count(input.frame);
        let key = pixel_key(sample, u32::MAX - 4, input.seed);
        let light = input.wave_light(count.wave_number([wave, sample]));
        let (input, set) = (&light.input, light.set);
        let bands = light.bands(|band| lens.bands[band].response);
        let lens = (lens, &self.front);
        let mut splats = Vec::new();
        self.walk::<R>(input, columns, [key, wave], &mut |Connected { paths, .. }| {
            add_splats::<R>(input, lens, (count, set, &bands), paths, |_, _| 1.0, &mut splats);
        });
        splats
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
