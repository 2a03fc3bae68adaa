//! Estimate of the density of a coat's samples.

use std::f64::consts::PI;

use super::super::Bsdf;
use super::super::dielectric::Transport;
use super::super::lobe_choice::LobeChoice;
use super::Coated;
use super::walk::{any, continues, draw, upright};
use petzval_base::lanes::vector::negate;
use petzval_base::lanes::{Real, Word};
use petzval_base::sampler::RandomStream;
use petzval_base::sampler::mis::power_heuristic;

/// Separates the random numbers of densities from those of values and samples of the same seed.
const PDF_STREAM: u32 = 0x5eed_0002;

impl<R: Real<Scalar = f32>, B: Bsdf<R>> Coated<R, B> {
    /// Returns an estimate of the density of [`Self::sample`], for multiple importance sampling.
    ///
    /// The estimate counts the first reflections, and treats a tenth of all samples as uniform over
    /// the sphere. Its integral is only close to 1.
    ///
    /// The interface reflects a share of the samples, by `LobeChoice::OfCoat`; the others enter the
    /// layer. The density of pbrt-v4 takes all samples as reflected and also as entering: a coat
    /// that reflects 4 % then seems to sample its reflections 25 times as often as it does, and
    /// multiple importance sampling leaves bright lights in them to these rare samples.
    #[inline(never)]
    pub fn pdf(&self, wo: [R; 3], wi: [R; 3], seed: R::Word) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let uniform = R::constant(0.1 / (4.0 * PI));
        let none = wo[2].equals(zero) | self.is_singular();
        let reflects = zero.lt(wo[2] * wi[2]) & !none;
        if !any::<R>(reflects) {
            return R::select(none, zero, uniform);
        }
        let (wo, wi) = upright(wo, wi);
        let seed = seed ^ R::Word::splat(PDF_STREAM);
        let random = RandomStream::new(seed, [wo[0], wo[1], wo[2], wi[0], wi[1], wi[2]]);
        let mut sum = zero;
        for walk in 0.. {
            let active = reflects & R::splat(walk as f32).lt(self.layer.samples);
            if !any::<R>(active) {
                break;
            }
            let density = self.transmitted_pdf(wo, wi, random.substream(walk));
            sum = R::select(active, sum + density, sum);
        }
        let interface = &self.layer.interface;
        let (_, reflected) = interface.evaluate_lobes(wo, wi, LobeChoice::OfCoat);
        let [_, enters] = LobeChoice::OfCoat.chances(interface.smooth_reflectance(wo));
        let enters = enters / self.layer.samples.max(one);
        let specific = sum.mul_add(enters, reflected);
        let specific = R::select(reflects, specific, zero);
        R::select(none, zero, specific.mul_add(R::splat(0.9), uniform))
    }

    /// Estimates the density of paths that enter the layer, meet the base once and leave.
    #[inline(always)]
    fn transmitted_pdf(&self, wo: [R; 3], wi: [R; 3], random: RandomStream<R>) -> R {
        let (zero, interface) = (R::splat(0.0), &self.layer.interface);
        let into = self.enter(wo, Transport::Radiance, random.substream(0));
        let light = self.enter(wi, Transport::Importance, random.substream(1));
        let enters = into.valid & light.valid;
        let (back, from) = (negate(into.wi), negate(light.wi));
        let (_, reflected) = self.base.evaluate(back, from);
        let mut density = reflected;
        let rough = enters & !interface.singular();
        if any::<R>(rough) {
            let random = random.substream(2);
            let (u, choice) = (random.pair(draw::DIRECTION), random.number(draw::LOBE));
            let sample = self.base.sample(back, u, choice);
            let (_, out) = interface.evaluate_lobes(negate(sample.wi), wi, LobeChoice::Both);
            let both = reflected * power_heuristic(light.pdf, reflected)
                + out * power_heuristic(sample.pdf, out);
            let found = R::select(self.base.singular(), out, both);
            density = R::select(rough, R::select(continues(&sample), found, zero), density);
        }
        R::select(enters, density, zero)
    }
}
