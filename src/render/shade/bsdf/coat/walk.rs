//! Random walk between the interface and the base of a coat.

use super::super::dielectric::Transport;
use super::super::lobe_choice::LobeChoice;
use super::super::{Bsdf, BsdfSample};
use super::Coated;
use petzval_base::lanes::Real;
use petzval_base::lanes::math::{exp_negative, ln};
use petzval_base::lanes::vector::{max_component, negate, renormalize, scale, select};
use petzval_base::sampler::RandomStream;

/// Indices of the random numbers of an event.
pub(super) mod draw {
    /// Russian roulette.
    pub(crate) const ROULETTE: u32 = 0;
    /// Distance to the next scattering in the medium.
    pub(crate) const DISTANCE: u32 = 1;
    /// Direction after the event, two numbers.
    pub(crate) const DIRECTION: u32 = 2;
    /// Lobe of the direction.
    pub(crate) const LOBE: u32 = 4;
}

/// State of the walks inside the layer.
pub(super) struct Walk<R: Real> {
    /// Height over the base [mean free paths].
    pub(super) z: R,
    /// Unit vector along which the walk goes.
    pub(super) w: [R; 3],
    pub(super) throughput: [R; 3],
    /// Lanes whose walk goes on.
    pub(super) active: R::Mask,
}

/// Lanes by the next event of their walks. Lanes in none of the sets have ended, or their step was
/// too short for the height to change in f32.
pub(super) struct Arrival<R: Real> {
    /// Scattering in the layer's medium.
    pub(super) medium: R::Mask,
    /// Arrival at the interface.
    pub(super) interface: R::Mask,
    /// Arrival at the base.
    pub(super) base: R::Mask,
}

/// Returns whether a mask is set in any lane.
#[inline(always)]
pub(super) fn any<R: Real>(mask: R::Mask) -> bool {
    R::bits(mask) != 0
}

impl<R: Real<Scalar = f32>> Walk<R> {
    /// Plays Russian roulette.
    #[inline(always)]
    pub(super) fn play_roulette(&mut self, depth: u32, random: &RandomStream<R>) {
        if depth <= 3 {
            return;
        }
        let left = max_component(self.throughput);
        let survives = random.number(draw::ROULETTE).lt(left);
        let safe = R::splat(0.25).le(left);
        self.active = self.active & (safe | survives);
        let factor = R::select(safe, R::splat(1.0), R::splat(1.0) / left);
        self.throughput = scale(self.throughput, factor);
    }

    /// Continues walks along sampled directions, and ends those that have none.
    #[inline(always)]
    pub(super) fn follow(&mut self, lanes: R::Mask, sample: &BsdfSample<R>) {
        self.w = select(lanes, renormalize(sample.wi), self.w);
        self.attenuate(lanes, sample.weight);
        self.active = self.active & (continues(sample) | !lanes);
    }

    /// Multiplies the throughput.
    #[inline(always)]
    pub(super) fn attenuate(&mut self, lanes: R::Mask, [r, g, b]: [R; 3]) {
        let [x, y, z] = self.throughput;
        self.throughput = select(lanes, [x * r, y * g, z * b], self.throughput);
    }
}

/// Returns whether walks can continue along sampled directions.
#[inline(always)]
pub(super) fn continues<R: Real<Scalar = f32>>(sample: &BsdfSample<R>) -> R::Mask {
    let zero = R::splat(0.0);
    sample.valid & zero.lt(max_component(sample.weight)) & !sample.wi[2].equals(zero)
}

/// Returns the share of light that passes a slab of the layer along a direction. `height` is the
/// slab's thickness [mean free paths].
#[inline(always)]
pub(super) fn transmittance<R: Real<Scalar = f32>>(height: R, w: [R; 3]) -> R {
    let thin = height.abs().le(R::splat(f32::MIN_POSITIVE));
    R::select(thin, R::splat(1.0), exp_negative(-(height / w[2]).abs()))
}

/// Turns directions so that the first points up.
#[inline(always)]
pub(super) fn upright<R: Real<Scalar = f32>>(wo: [R; 3], wi: [R; 3]) -> ([R; 3], [R; 3]) {
    let below = wo[2].lt(R::splat(0.0));
    (select(below, negate(wo), wo), select(below, negate(wi), wi))
}

impl<R: Real<Scalar = f32>, B: Bsdf<R>> Coated<R, B> {
    /// Returns the lanes whose walks may have another event after this many.
    #[inline(always)]
    pub(super) fn within_depth(&self, depth: u32) -> R::Mask {
        R::splat(depth as f32).lt(self.layer.max_depth)
    }

    /// Samples a direction through the interface into the layer.
    #[inline(always)]
    pub(super) fn enter(
        &self,
        w: [R; 3],
        transport: Transport,
        random: RandomStream<R>,
    ) -> BsdfSample<R> {
        let (u, choice) = (random.pair(draw::DIRECTION), random.number(draw::LOBE));
        self.layer.interface.sample_lobes(w, u, choice, LobeChoice::Transmission, transport)
    }

    /// Moves walks to their next event.
    #[inline(always)]
    pub(super) fn advance(&self, walk: &mut Walk<R>, random: &RandomStream<R>) -> Arrival<R> {
        let (zero, one, thickness) = (R::splat(0.0), R::splat(1.0), self.layer.thickness);
        let (before, hazy) = (walk.z, walk.active & !self.clear);
        walk.z = R::select(before.equals(thickness), zero, thickness);
        let none = zero.lt(zero);
        let (mut moves, mut medium) = (walk.active, none);
        if any::<R>(hazy) {
            let free = before - ln(one - random.number(draw::DISTANCE)) * walk.w[2];
            moves = moves & !(hazy & free.equals(before));
            medium = hazy & moves & zero.lt(free) & free.lt(thickness);
            walk.z = R::select(hazy, free.max(zero).min(thickness), walk.z);
        }
        if any::<R>(walk.active & self.clear) {
            walk.attenuate(self.clear, [transmittance(thickness, walk.w); 3]);
        }
        let (boundary, top) = (moves & !medium, zero.lt(walk.z));
        Arrival { medium, interface: boundary & top, base: boundary & !top }
    }
}
