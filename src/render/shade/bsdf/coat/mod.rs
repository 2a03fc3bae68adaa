//! Coated surface: a clear or hazy layer over a base, evaluated by random walks.
//!
//! The walks of all lanes go on in step, each lane's as far as it needs, until the last has ended.
//! Random numbers are drawn by index, so a lane does not notice its neighbours. Work that no lane
//! needs is skipped, which leaves all results as they are.

mod density;
mod parameters;
mod sample;
mod value;
mod walk;

use super::{Bsdf, BsdfSample, Dielectric};
pub(in crate::shade) use parameters::{CoatedConductorParameters, CoatedDiffuseParameters};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::max_component;

/// A clear or hazy layer, with an interface to the outside.
#[derive(Clone, Copy, Debug)]
pub struct CoatLayer<R: Real> {
    /// The interface to the outside; its index is that of the layer over that of the outside.
    pub interface: Dielectric<R>,
    /// Thickness [mean free paths]. A clear layer absorbs along it.
    pub thickness: R,
    /// Single-scattering albedo by colour channel; 0 makes the layer clear.
    pub albedo: [R; 3],
    /// Asymmetry of the scattering in the layer, -1 to 1.
    pub g: R,
    /// Maximum number of events of a walk inside the layer, an integer.
    pub max_depth: R,
    /// Number of walks of an evaluation, an integer.
    pub samples: R,
    /// Weights of the two techniques at a rough interface.
    pub weights: MisWeights,
}

/// Weights of the two techniques that connect a walk to the light through a rough interface: the
/// interface samples a direction for the light, or the walk samples its own.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MisWeights {
    /// The weights of pbrt-v4. If the walk samples, the other density is that of the interface
    /// sampling the light for the walk, not the walk for the light. These weights do not add up
    /// to 1: for light that passes a rough interface and scatters on a rough base, evaluations are
    /// several per cent too large, and larger than samples.
    #[default]
    Pbrt,
    /// The weights of Veach & Guibas 1995. Evaluations and samples have the same mean.
    Exact,
}

/// A purely reflecting base under a layer, the same from both sides: pbrt-v4's `LayeredBxDF`.
///
/// The BSDF is known only as the mean over random walks between interface and base (Guo, Hasan &
/// Zhao 2018, "Position-free Monte Carlo simulation for arbitrary layered BSDFs"). The walks depend
/// on the directions and on a seed; different samples of a pixel should have different seeds. Walks
/// end after `max_depth` events, and the light of later events is lost.
#[derive(Clone, Copy, Debug)]
pub struct Coated<R: Real, B> {
    layer: CoatLayer<R>,
    base: B,
    clear: R::Mask,
}

impl<R: Real<Scalar = f32>, B: Bsdf<R>> Coated<R, B> {
    /// A base under a layer. The base must not transmit light.
    #[inline(always)]
    pub fn new(layer: CoatLayer<R>, base: B) -> Self {
        let clear = max_component(layer.albedo).le(R::splat(0.0));
        let thickness = layer.thickness.max(R::splat(f32::MIN_POSITIVE));
        Self { layer: CoatLayer { thickness, ..layer }, base, clear }
    }

    /// Returns whether all lobes are singular, so that [`Self::evaluate`] is always 0.
    #[inline(always)]
    pub fn is_singular(&self) -> R::Mask {
        self.layer.interface.singular() & self.base.singular() & self.clear
    }

    /// Returns estimates of f |cos wi| by colour channel and of the density of [`Self::sample`].
    /// The two are independent, so the product of one with a multiple-importance weight made of the
    /// other is unbiased.
    #[inline(always)]
    pub fn evaluate(&self, wo: [R; 3], wi: [R; 3], seed: R::Word) -> ([R; 3], R) {
        (self.value(wo, wi, seed), self.pdf(wo, wi, seed))
    }

    /// Returns the BSDF whose walks have these seeds.
    #[inline(always)]
    pub fn seeded(self, seed: R::Word) -> SeededCoat<R, B> {
        SeededCoat { coated: self, seed }
    }
}

/// Seeds and weights of the walks of a coat's evaluations.
#[derive(Clone, Copy, Debug)]
pub(in crate::shade) struct CoatWalks<R: Real> {
    /// Seeds of the random numbers.
    pub(in crate::shade) seed: R::Word,
    /// Weights of the two techniques at a rough interface.
    pub(in crate::shade) weights: MisWeights,
}

/// A coated surface with the seeds of its walks. Every evaluation repeats the same walks.
#[derive(Clone, Copy, Debug)]
pub struct SeededCoat<R: Real, B> {
    coated: Coated<R, B>,
    seed: R::Word,
}

impl<R: Real<Scalar = f32>, B: Bsdf<R>> Bsdf<R> for SeededCoat<R, B> {
    #[inline(always)]
    fn evaluate(&self, wo: [R; 3], wi: [R; 3]) -> ([R; 3], R) {
        self.coated.evaluate(wo, wi, self.seed)
    }

    #[inline(always)]
    fn sample(&self, wo: [R; 3], u: [R; 2], choice: R) -> BsdfSample<R> {
        self.coated.sample(wo, u, choice, self.seed)
    }

    #[inline(always)]
    fn singular(&self) -> R::Mask {
        self.coated.is_singular()
    }
}
