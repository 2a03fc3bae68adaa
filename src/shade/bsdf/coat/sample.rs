//! Sampling of a coat's BSDF, and the density of its samples.

use std::f32::consts::PI;

use super::super::dielectric::{Lobes, Transport};
use super::super::phase_function::sample_henyey_greenstein;
use super::super::random_stream::RandomStream;
use super::super::{Bsdf, BsdfSample};
use super::walk::{Event, Walk, continues};
use super::{CoatLayer, Coated};
use crate::lanes::vector::negate;
use crate::shade::mis::power_heuristic;

/// Separates the random numbers of densities from those of values and samples of the same seed.
const PDF_STREAM: u32 = 0x5eed_0002;
/// Separates the random numbers of samples from those of values and densities of the same seed.
const SAMPLE_STREAM: u32 = 0x5eed_0003;

impl<B: Bsdf<f32>> Coated<B> {
    /// Returns an estimate of the density of [`Self::sample`], for multiple importance sampling.
    ///
    /// The estimate counts the first reflections, and treats a tenth of all samples as uniform over
    /// the sphere. As in pbrt-v4, its integral is only close to 1.
    pub fn pdf(&self, wo: [f32; 3], wi: [f32; 3], seed: u32) -> f32 {
        if wo[2] == 0.0 || self.is_singular() {
            return 0.0;
        }
        let uniform = 0.1 / (4.0 * PI);
        if wo[2] * wi[2] <= 0.0 {
            return uniform;
        }
        let (wo, wi) = if wo[2] < 0.0 { (negate(wo), negate(wi)) } else { (wo, wi) };
        let mut random = RandomStream::new(seed ^ PDF_STREAM, wo.into_iter().chain(wi));
        let mut sum = 0.0;
        for _ in 0..self.layer.samples {
            sum += self.transmitted_pdf(wo, wi, &mut random);
        }
        let walks = self.layer.samples.max(1) as f32;
        let (_, reflected) = self.layer.interface.evaluate_lobes(wo, wi, Lobes::REFLECTION);
        uniform + 0.9 * (reflected + sum / walks)
    }

    /// Estimates the density of paths that enter the layer, meet the base once and leave.
    fn transmitted_pdf(&self, wo: [f32; 3], wi: [f32; 3], random: &mut RandomStream) -> f32 {
        let interface = &self.layer.interface;
        let into = self.enter(wo, Transport::Radiance, random);
        let light = self.enter(wi, Transport::Importance, random);
        if !into.valid || !light.valid {
            return 0.0;
        }
        let (back, from) = (negate(into.wi), negate(light.wi));
        if interface.singular() {
            return self.base.evaluate(back, from).1;
        }
        let sample = self.base.sample(back, random.next_pair(), random.next_number());
        if !continues(&sample) {
            return 0.0;
        }
        let (_, out) = interface.evaluate_lobes(negate(sample.wi), wi, Lobes::BOTH);
        if self.base.singular() {
            return out;
        }
        let (_, reflected) = self.base.evaluate(back, from);
        reflected * power_heuristic(light.pdf, reflected) + out * power_heuristic(sample.pdf, out)
    }

    /// Samples a direction by following a path through the layer until it leaves.
    ///
    /// Given the direction, the mean of the weight is the value over the true density. `pdf` is the
    /// estimate of [`Self::pdf`], for multiple importance sampling.
    pub fn sample(&self, wo: [f32; 3], u: [f32; 2], choice: f32, seed: u32) -> BsdfSample<f32> {
        let below = wo[2] < 0.0;
        let upper = if below { negate(wo) } else { wo };
        let sample = self.sample_from_above(upper, u, choice, seed);
        let wi = if below { negate(sample.wi) } else { sample.wi };
        let pdf = if sample.valid && !sample.singular { self.pdf(wo, wi, seed) } else { 0.0 };
        BsdfSample { wi, pdf, eta2: 1.0, ..sample }.only(true)
    }

    /// [`Self::sample`] for `wo` above the surface, without the density.
    fn sample_from_above(
        &self,
        wo: [f32; 3],
        u: [f32; 2],
        choice: f32,
        seed: u32,
    ) -> BsdfSample<f32> {
        let (both, radiance) = (Lobes::BOTH, Transport::Radiance);
        let CoatLayer { interface, g, albedo, .. } = self.layer;
        let first = interface.sample_lobes(wo, u, choice, both, radiance);
        let nothing = first.only(false);
        if !continues(&first) {
            return nothing;
        }
        if first.wi[2] > 0.0 {
            return first;
        }
        let keys = wo.into_iter().chain(u).chain([choice]);
        let mut random = RandomStream::new(seed ^ SAMPLE_STREAM, keys);
        let mut walk = Walk { z: self.layer.thickness, w: first.wi, throughput: first.weight };
        let mut singular = first.singular;
        for depth in 0..self.layer.max_depth {
            if !walk.survives(depth, &mut random) {
                return nothing;
            }
            let back = negate(walk.w);
            match self.advance(&mut walk, &mut random) {
                Event::Stuck => return nothing,
                Event::Medium(z) => {
                    walk.w = sample_henyey_greenstein(back, g, random.next_pair());
                    walk.throughput = [0, 1, 2].map(|c| walk.throughput[c] * albedo[c]);
                    walk.z = z;
                    singular = false;
                }
                Event::Boundary => {
                    let (u, choice) = (random.next_pair(), random.next_number());
                    let top = walk.z > 0.0;
                    let sample = if top {
                        interface.sample_lobes(back, u, choice, both, radiance)
                    } else {
                        self.base.sample(back, u, choice)
                    };
                    if !walk.follow(&sample) {
                        return nothing;
                    }
                    singular &= sample.singular;
                    if top && sample.wi[2] > 0.0 {
                        return BsdfSample { singular, weight: walk.throughput, ..sample };
                    }
                }
            }
        }
        nothing
    }
}
