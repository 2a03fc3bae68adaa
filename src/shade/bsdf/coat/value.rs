//! Estimate of a coat's BSDF value.

use super::super::Bsdf;
use super::super::dielectric::{Lobes, Transport};
use super::super::phase_function::{henyey_greenstein, sample_henyey_greenstein};
use super::super::random_stream::RandomStream;
use super::walk::{Event, Walk, continues, transmittance};
use super::{CoatLayer, Coated, MisWeights};
use crate::lanes::vector::{dot, negate};
use crate::shade::mis::power_heuristic;

/// Separates the random numbers of values from those of densities and samples of the same seed.
const VALUE_STREAM: u32 = 0x5eed_0001;

fn add(sum: &mut [f32; 3], beta: [f32; 3], value: [f32; 3], factor: f32) {
    for channel in 0..3 {
        sum[channel] += beta[channel] * value[channel] * factor;
    }
}

impl<B: Bsdf<f32>> Coated<B> {
    /// Returns an estimate of f |cos wi| by colour channel. Its mean over seeds is the value.
    pub fn value(&self, wo: [f32; 3], wi: [f32; 3], seed: u32) -> [f32; 3] {
        if wo[2] * wi[2] <= 0.0 || self.is_singular() {
            return [0.0; 3];
        }
        let (wo, wi) = if wo[2] < 0.0 { (negate(wo), negate(wi)) } else { (wo, wi) };
        let mut random = RandomStream::new(seed ^ VALUE_STREAM, wo.into_iter().chain(wi));
        let mut sum = [0.0; 3];
        for _ in 0..self.layer.samples {
            add(&mut sum, [1.0; 3], self.walk_value(wo, wi, &mut random), 1.0);
        }
        let walks = self.layer.samples.max(1) as f32;
        let (reflected, _) = self.layer.interface.evaluate_lobes(wo, wi, Lobes::REFLECTION);
        sum.map(|s| s / walks + reflected)
    }

    /// Estimates, by one walk, the light that enters the layer along `wo` and leaves it along `wi`.
    ///
    /// Each event is connected to the light by two techniques: through a direction that the
    /// interface sampled for `wi` beforehand and, if the interface is rough, through the walk's own
    /// next direction.
    fn walk_value(&self, wo: [f32; 3], wi: [f32; 3], random: &mut RandomStream) -> [f32; 3] {
        let CoatLayer { interface, thickness, albedo, g, .. } = self.layer;
        let into = self.enter(wo, Transport::Radiance, random);
        let light = self.enter(wi, Transport::Importance, random);
        let mut sum = [0.0; 3];
        if !continues(&into) || !continues(&light) {
            return sum;
        }
        let from = negate(light.wi);
        // The sample's weight contains the cosine inside; the result contains that outside.
        let through = light.weight[0] * (wi[2] / light.wi[2]).abs();
        let rough = !interface.singular();
        let mut walk = Walk { z: thickness, w: into.wi, throughput: into.weight };
        for depth in 0..self.layer.max_depth {
            if !walk.survives(depth, random) {
                break;
            }
            let back = negate(walk.w);
            match self.advance(&mut walk, random) {
                Event::Stuck => continue,
                Event::Medium(z) => {
                    let phase = henyey_greenstein(dot(back, from), g);
                    let weight = if rough { power_heuristic(light.pdf, phase) } else { 1.0 };
                    let passes = transmittance(thickness - z, light.wi) * through;
                    add(&mut sum, walk.throughput, albedo, phase * weight * passes);

                    walk.w = sample_henyey_greenstein(back, g, random.next_pair());
                    walk.throughput = [0, 1, 2].map(|c| walk.throughput[c] * albedo[c]);
                    walk.z = z;
                    if rough && walk.w[2] > 0.0 {
                        let phase = henyey_greenstein(dot(back, walk.w), g);
                        let (out, pdf) = self.exit(walk.w, wi);
                        let weight = power_heuristic(phase, pdf);
                        let passes = transmittance(thickness - z, walk.w);
                        add(&mut sum, walk.throughput, [out; 3], weight * passes);
                    }
                }
                Event::Boundary if walk.z > 0.0 => {
                    let (lobes, transport) = (Lobes::REFLECTION, Transport::Radiance);
                    let (u, choice) = (random.next_pair(), random.next_number());
                    if !walk.follow(&interface.sample_lobes(back, u, choice, lobes, transport)) {
                        break;
                    }
                }
                Event::Boundary => {
                    let base_rough = !self.base.singular();
                    if base_rough {
                        let (value, pdf) = self.base.evaluate(back, from);
                        let weight = if rough { power_heuristic(light.pdf, pdf) } else { 1.0 };
                        let passes = transmittance(thickness, light.wi) * through;
                        add(&mut sum, walk.throughput, value, weight * passes);
                    }
                    let sample = self.base.sample(back, random.next_pair(), random.next_number());
                    if !walk.follow(&sample) {
                        break;
                    }
                    if rough {
                        let (out, pdf) = self.exit(walk.w, wi);
                        let weight =
                            if base_rough { power_heuristic(sample.pdf, pdf) } else { 1.0 };
                        let passes = transmittance(thickness, walk.w);
                        add(&mut sum, walk.throughput, [out; 3], weight * passes);
                    }
                }
            }
        }
        sum
    }

    /// Returns f |cos wi| of light that leaves the layer along `wi` after a walk along `w`, and the
    /// density of the other technique, for its weight.
    fn exit(&self, w: [f32; 3], wi: [f32; 3]) -> (f32, f32) {
        let (interface, back) = (&self.layer.interface, negate(w));
        let (value, pdf) = interface.evaluate_lobes(back, wi, Lobes::TRANSMISSION);
        match self.layer.weights {
            MisWeights::Pbrt => (value, pdf),
            MisWeights::Exact => (value, interface.evaluate_lobes(wi, back, Lobes::TRANSMISSION).1),
        }
    }
}
