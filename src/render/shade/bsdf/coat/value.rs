//! Estimate of a coat's BSDF value.

use super::super::dielectric::Transport;
use super::super::lobe_choice::LobeChoice;
use super::super::sample_henyey_greenstein;
use super::super::{Bsdf, BsdfSample};
use super::walk::{Walk, any, continues, draw, transmittance, upright};
use super::{Coated, MisWeights};
use petzval_base::lanes::vector::{dot, negate, scale};
use petzval_base::lanes::{Real, Word};
use petzval_base::sampler::RandomStream;
use petzval_base::sampler::mis::power_heuristic;
use petzval_scene::henyey_greenstein;

/// Separates the random numbers of values from those of densities and samples of the same seed.
const VALUE_STREAM: u32 = 0x5eed_0001;

/// The light that walks connect to, and the sum of what they find.
struct Light<R: Real> {
    /// The direction outside.
    wi: [R; 3],
    /// The direction inside that the interface sampled for `wi`.
    inside: BsdfSample<R>,
    /// Points along `inside` to where light goes.
    from: [R; 3],
    /// Share of the light that enters.
    through: R,
    /// Lanes with a rough interface.
    rough: R::Mask,
    sum: [R; 3],
}

impl<R: Real<Scalar = f32>> Light<R> {
    /// Adds light to the sum of some lanes.
    #[inline(always)]
    fn add(&mut self, lanes: R::Mask, throughput: [R; 3], value: [R; 3], factor: R) {
        for channel in 0..3 {
            let more = throughput[channel] * value[channel] * factor;
            self.sum[channel] = R::select(lanes, self.sum[channel] + more, self.sum[channel]);
        }
    }

    /// Returns the weight of the direction that the interface sampled, given the density of the
    /// walk's own directions.
    #[inline(always)]
    fn weight(&self, pdf: R) -> R {
        R::select(self.rough, power_heuristic(self.inside.pdf, pdf), R::splat(1.0))
    }
}

impl<R: Real<Scalar = f32>, B: Bsdf<R>> Coated<R, B> {
    /// Returns an estimate of f |cos wi| by colour channel. Its mean over seeds is the value.
    #[inline(never)]
    pub fn value(&self, wo: [R; 3], wi: [R; 3], seed: R::Word) -> [R; 3] {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let scatters = zero.lt(wo[2] * wi[2]) & !self.is_singular();
        if !any::<R>(scatters) {
            return [zero; 3];
        }
        let (wo, wi) = upright(wo, wi);
        let seed = seed ^ R::Word::splat(VALUE_STREAM);
        let random = RandomStream::new(seed, [wo[0], wo[1], wo[2], wi[0], wi[1], wi[2]]);
        let mut sum = [zero; 3];
        for walk in 0.. {
            let active = scatters & R::splat(walk as f32).lt(self.layer.samples);
            if !any::<R>(active) {
                break;
            }
            let found = self.walk_value(wo, wi, random.substream(walk), active);
            for channel in 0..3 {
                sum[channel] = sum[channel] + found[channel];
            }
        }
        let share = one / self.layer.samples.max(one);
        let (reflected, _) = self.layer.interface.evaluate_lobes(wo, wi, LobeChoice::Reflection);
        for channel in 0..3 {
            let value = sum[channel].mul_add(share, reflected);
            sum[channel] = R::select(scatters, value, zero);
        }
        sum
    }

    /// Estimates, by one walk, the light that enters the layer along `wo` and leaves it along `wi`;
    /// 0 in lanes that are not active.
    ///
    /// Each event is connected to the light by two techniques: through a direction that the
    /// interface sampled for `wi` beforehand and, if the interface is rough, through the walk's own
    /// next direction.
    #[inline(always)]
    fn walk_value(
        &self,
        wo: [R; 3],
        wi: [R; 3],
        random: RandomStream<R>,
        active: R::Mask,
    ) -> [R; 3] {
        let into = self.enter(wo, Transport::Radiance, random.substream(0));
        let inside = self.enter(wi, Transport::Importance, random.substream(1));
        let active = active & continues(&into) & continues(&inside);
        let mut light = Light {
            wi,
            from: negate(inside.wi),
            // The sample's weight contains the cosine inside; the result contains that outside.
            through: inside.weight[0] * (wi[2] / inside.wi[2]).abs(),
            inside,
            rough: !self.layer.interface.singular(),
            sum: [R::splat(0.0); 3],
        };
        // Refraction divides radiance by eta^2, which is no reason for roulette to end walks.
        let (z, w, throughput) = (self.layer.thickness, into.wi, [R::splat(1.0); 3]);
        let mut walk = Walk { z, w, throughput, active };
        for depth in 0.. {
            let random = random.substream(2 + depth);
            walk.active = walk.active & self.within_depth(depth);
            walk.play_roulette(depth, &random);
            if !any::<R>(walk.active) {
                break;
            }
            let back = negate(walk.w);
            let arrival = self.advance(&mut walk, &random);
            if any::<R>(arrival.medium) {
                self.scatter_in_medium(arrival.medium, back, &mut walk, &mut light, &random);
            }
            if any::<R>(arrival.interface) {
                let (u, choice) = (random.pair(draw::DIRECTION), random.number(draw::LOBE));
                let (lobes, transport) = (LobeChoice::Reflection, Transport::Radiance);
                let sample = self.layer.interface.sample_lobes(back, u, choice, lobes, transport);
                walk.follow(arrival.interface, &sample);
            }
            if any::<R>(arrival.base) {
                self.scatter_at_base(arrival.base, back, &mut walk, &mut light, &random);
            }
        }
        scale(light.sum, into.weight[0])
    }

    /// Scatters walks in the medium, and adds the light that they find.
    #[inline(always)]
    fn scatter_in_medium(
        &self,
        lanes: R::Mask,
        back: [R; 3],
        walk: &mut Walk<R>,
        light: &mut Light<R>,
        random: &RandomStream<R>,
    ) {
        let (albedo, g) = (self.layer.albedo, self.layer.g);
        let above = self.layer.thickness - walk.z;
        let phase = henyey_greenstein(dot(back, light.from), g);
        let passes = transmittance(above, light.inside.wi) * light.through;
        light.add(lanes, walk.throughput, albedo, phase * light.weight(phase) * passes);

        let w = sample_henyey_greenstein(back, g, random.pair(draw::DIRECTION));
        for axis in 0..3 {
            walk.w[axis] = R::select(lanes, w[axis], walk.w[axis]);
        }
        walk.attenuate(lanes, albedo);
        let leaves = lanes & light.rough & R::splat(0.0).lt(w[2]);
        if any::<R>(leaves) {
            let phase = henyey_greenstein(dot(back, w), g);
            let (out, pdf) = self.exit(w, light.wi);
            let passes = power_heuristic(phase, pdf) * transmittance(above, w);
            light.add(leaves, walk.throughput, [out; 3], passes);
        }
    }

    /// Scatters walks at the base, and adds the light that they find.
    #[inline(always)]
    fn scatter_at_base(
        &self,
        lanes: R::Mask,
        back: [R; 3],
        walk: &mut Walk<R>,
        light: &mut Light<R>,
        random: &RandomStream<R>,
    ) {
        let thickness = self.layer.thickness;
        let rough = lanes & !self.base.singular();
        if any::<R>(rough) {
            let (value, pdf) = self.base.evaluate(back, light.from);
            let passes = transmittance(thickness, light.inside.wi) * light.through;
            light.add(rough, walk.throughput, value, light.weight(pdf) * passes);
        }
        let (u, choice) = (random.pair(draw::DIRECTION), random.number(draw::LOBE));
        let sample = self.base.sample(back, u, choice);
        walk.follow(lanes, &sample);
        let leaves = lanes & walk.active & light.rough;
        if any::<R>(leaves) {
            let (out, pdf) = self.exit(walk.w, light.wi);
            let weight = R::select(rough, power_heuristic(sample.pdf, pdf), R::splat(1.0));
            let passes = weight * transmittance(thickness, walk.w);
            light.add(leaves, walk.throughput, [out; 3], passes);
        }
    }

    /// Returns f |cos wi| of light that leaves the layer along `wi` after a walk along `w`, and the
    /// density of the other technique, for its weight.
    #[inline(always)]
    fn exit(&self, w: [R; 3], wi: [R; 3]) -> (R, R) {
        let (interface, back) = (&self.layer.interface, negate(w));
        let (value, pdf) = interface.evaluate_lobes(back, wi, LobeChoice::Transmission);
        match self.layer.weights {
            MisWeights::Pbrt => (value, pdf),
            MisWeights::Exact => {
                (value, interface.evaluate_lobes(wi, back, LobeChoice::Transmission).1)
            }
        }
    }
}
