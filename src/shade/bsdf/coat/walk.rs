//! Random walk between the interface and the base of a coat.

use super::super::dielectric::{Lobes, Transport};
use super::super::random_stream::RandomStream;
use super::super::{Bsdf, BsdfSample};
use super::{CoatLayer, Coated};
use crate::lanes::vector::{max_component, scale};

/// State of a walk inside the layer.
pub(super) struct Walk {
    /// Height over the base [mean free paths].
    pub(super) z: f32,
    /// Unit vector along which the walk goes.
    pub(super) w: [f32; 3],
    pub(super) throughput: [f32; 3],
}

/// Next event of a walk.
pub(super) enum Event {
    /// Scattering in the layer's medium, at this height.
    Medium(f32),
    /// Arrival at the interface or the base.
    Boundary,
    /// A step too short for the height to change in f32.
    Stuck,
}

impl Walk {
    /// Plays Russian roulette, and returns whether the walk continues.
    pub(super) fn survives(&mut self, depth: u32, random: &mut RandomStream) -> bool {
        let left = max_component(self.throughput);
        if depth <= 3 || left >= 0.25 {
            return true;
        }
        let survives = random.next_number() < left;
        if survives {
            self.throughput = scale(self.throughput, 1.0 / left);
        }
        survives
    }

    /// Continues along a sampled direction, and returns whether there is one.
    pub(super) fn follow(&mut self, sample: &BsdfSample<f32>) -> bool {
        self.w = sample.wi;
        for channel in 0..3 {
            self.throughput[channel] *= sample.weight[channel];
        }
        continues(sample)
    }
}

/// Returns whether a walk can continue along a sampled direction.
pub(super) fn continues(sample: &BsdfSample<f32>) -> bool {
    sample.valid && max_component(sample.weight) > 0.0 && sample.wi[2] != 0.0
}

/// Returns the share of light that passes a slab of the layer along a direction. `height` is the
/// slab's thickness [mean free paths].
pub(super) fn transmittance(height: f32, w: [f32; 3]) -> f32 {
    if height.abs() <= f32::MIN_POSITIVE { 1.0 } else { (-(height / w[2]).abs()).exp() }
}

impl<B: Bsdf<f32>> Coated<B> {
    /// Samples a direction through the interface into the layer.
    pub(super) fn enter(
        &self,
        w: [f32; 3],
        transport: Transport,
        random: &mut RandomStream,
    ) -> BsdfSample<f32> {
        let (u, choice) = (random.next_pair(), random.next_number());
        self.layer.interface.sample_lobes(w, u, choice, Lobes::TRANSMISSION, transport)
    }

    /// Moves a walk to its next event. At a boundary, the walk's height is that of the boundary.
    pub(super) fn advance(&self, walk: &mut Walk, random: &mut RandomStream) -> Event {
        let CoatLayer { thickness, .. } = self.layer;
        if self.clear {
            walk.z = if walk.z == thickness { 0.0 } else { thickness };
            let passes = transmittance(thickness, walk.w);
            walk.throughput = scale(walk.throughput, passes);
            return Event::Boundary;
        }
        let z = walk.z - (1.0 - random.next_number()).ln() * walk.w[2];
        if z == walk.z {
            return Event::Stuck;
        }
        if 0.0 < z && z < thickness {
            return Event::Medium(z);
        }
        walk.z = z.clamp(0.0, thickness);
        Event::Boundary
    }
}
