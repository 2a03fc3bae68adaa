//! Sampling of a coat's BSDF.

use super::super::dielectric::Transport;
use super::super::lobe_choice::LobeChoice;
use super::super::phase_function::sample_henyey_greenstein;
use super::super::{Bsdf, BsdfSample};
use super::Coated;
use super::walk::{Walk, any, continues, draw};
use petzval_base::lanes::vector::{negate, scale, select};
use petzval_base::lanes::{Real, Word};
use petzval_base::sampler::RandomStream;

/// Separates the random numbers of samples from those of values and densities of the same seed.
const SAMPLE_STREAM: u32 = 0x5eed_0003;

impl<R: Real<Scalar = f32>, B: Bsdf<R>> Coated<R, B> {
    /// Samples a direction by following a path through the layer until it leaves.
    ///
    /// Given the direction, the mean of the weight is the value over the true density. `pdf` is the
    /// estimate of [`Self::pdf`], for multiple importance sampling.
    #[inline(always)]
    pub fn sample(&self, wo: [R; 3], u: [R; 2], choice: R, seed: R::Word) -> BsdfSample<R> {
        let zero = R::splat(0.0);
        let below = wo[2].lt(zero);
        let upper = select(below, negate(wo), wo);
        let mut sample = self.sample_from_above(upper, u, choice, seed);
        sample.wi = select(below, negate(sample.wi), sample.wi);
        sample.pdf = zero;
        let smooth = sample.valid & !sample.singular;
        if any::<R>(smooth) {
            sample.pdf = R::select(smooth, self.pdf(wo, sample.wi, seed), zero);
        }
        BsdfSample { eta2: R::splat(1.0), ..sample }.only(sample.valid)
    }

    /// [`Self::sample`] for `wo` above the surface, without the density.
    #[inline(never)]
    fn sample_from_above(&self, wo: [R; 3], u: [R; 2], choice: R, seed: R::Word) -> BsdfSample<R> {
        let (zero, interface) = (R::splat(0.0), &self.layer.interface);
        let radiance = Transport::Radiance;
        let first = interface.sample_lobes(wo, u, choice, LobeChoice::OfCoat, radiance);
        let (goes, up) = (continues(&first), zero.lt(first.wi[2]));
        let mut result = first.only(goes & up);
        let seed = seed ^ R::Word::splat(SAMPLE_STREAM);
        let random = RandomStream::new(seed, [wo[0], wo[1], wo[2], u[0], u[1], choice]);
        // Walks that enter more often than light does weigh little, and refraction divides by eta^2:
        // roulette must take neither back.
        let throughput = [R::splat(1.0); 3];
        let (z, w) = (self.layer.thickness, first.wi);
        let mut walk = Walk { z, w, throughput, active: goes & !up };
        let mut singular = first.singular;
        for depth in 0.. {
            let random = random.substream(depth);
            walk.active = walk.active & self.within_depth(depth);
            walk.play_roulette(depth, &random);
            if !any::<R>(walk.active) {
                break;
            }
            let back = negate(walk.w);
            let arrival = self.advance(&mut walk, &random);
            // A walk that does not move is lost.
            walk.active = arrival.medium | arrival.interface | arrival.base;
            let (u, choice) = (random.pair(draw::DIRECTION), random.number(draw::LOBE));
            if any::<R>(arrival.medium) {
                let w = sample_henyey_greenstein(back, self.layer.g, u);
                walk.w = select(arrival.medium, w, walk.w);
                walk.attenuate(arrival.medium, self.layer.albedo);
                singular = singular & !arrival.medium;
            }
            if any::<R>(arrival.base) {
                let sample = self.base.sample(back, u, choice);
                walk.follow(arrival.base, &sample);
                singular = singular & (sample.singular | !arrival.base);
            }
            if any::<R>(arrival.interface) {
                let sample = interface.sample_lobes(back, u, choice, LobeChoice::Both, radiance);
                walk.follow(arrival.interface, &sample);
                singular = singular & (sample.singular | !arrival.interface);
                let leaves = arrival.interface & walk.active & zero.lt(sample.wi[2]);
                result.wi = select(leaves, walk.w, result.wi);
                let weight = scale(walk.throughput, first.weight[0]);
                result.weight = select(leaves, weight, result.weight);
                result.singular = (leaves & singular) | (result.singular & !leaves);
                result.valid = result.valid | leaves;
                walk.active = walk.active & !leaves;
            }
        }
        result
    }
}
