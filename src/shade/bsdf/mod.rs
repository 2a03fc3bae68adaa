//! Scattering functions: what a surface does to light, in pbrt-v4's definitions.
//!
//! Directions are unit vectors [x, y, z] in the frame of the shading normal, which is z; x and
//! y are the tangents ([`Frame`]). `wo` points to where a path came from, `wi` to where the
//! light comes from. The signs of their z say whether light is reflected or transmitted.
//! Radiance is transported: light that is refracted on its way to `wo` loses the square of the
//! refractive index.
//!
//! All but the coats are kernels over lanes: free of branches, and the same bit for bit for
//! one lane and for eight. A coat is a random walk ([`Coated`]), for one lane.

mod any;
mod coat;
mod conductor;
mod dielectric;
mod diffuse;
mod frame;
mod fresnel;
mod microfacet;
mod phase;
mod stream;
mod thin;
mod vector;

pub use any::AnyBsdf;
pub use coat::{Coated, Layer, Weights};
pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use diffuse::{Diffuse, DiffuseTransmission};
pub use frame::Frame;
pub use fresnel::{Refraction, conductor_reflectance};
pub use microfacet::Microfacets;
pub use phase::{henyey_greenstein, sample_henyey_greenstein};
pub use stream::Stream;
pub use thin::ThinDielectric;

use crate::lanes::Real;

/// What a scattering function can be asked, lane by lane.
pub trait Bsdf<R: Real<Scalar = f32>> {
    /// f |cos wi| by colour channel, and the density, by solid angle about `wi`, with which
    /// [`Self::draw`] draws it. Both are 0 for what only a singular lobe scatters.
    fn evaluate(&self, wo: [R; 3], wi: [R; 3]) -> ([R; 3], R);

    /// Draws a direction from two numbers in [0, 1) for its place and one that chooses a lobe.
    fn draw(&self, wo: [R; 3], u: [R; 2], choice: R) -> Drawn<R>;

    /// Where [`Self::evaluate`] is 0 for all directions, so that lights need not be sampled.
    fn singular(&self) -> R::Mask;
}

/// A direction drawn from a scattering function.
#[derive(Clone, Copy, Debug)]
pub struct Drawn<R: Real> {
    /// The direction; the normal where nothing was drawn.
    pub wi: [R; 3],
    /// f |cos wi| / density by colour channel, for a singular lobe the share of light in it
    /// over the probability of the lobe; 0 where nothing was drawn.
    pub weight: [R; 3],
    /// Density by solid angle, as [`Bsdf::evaluate`] tells; 0 for a singular lobe.
    pub density: R,
    /// Whether the lobe is singular: no other technique can draw its direction.
    pub singular: R::Mask,
    /// Whether anything was drawn.
    pub valid: R::Mask,
    /// What Russian roulette multiplies the throughput by before it looks at it: the square of
    /// the refractive index beyond the surface over that before it where light was refracted,
    /// else 1.
    pub eta2: R,
}

impl<R: Real<Scalar = f32>> Drawn<R> {
    /// The same, with nothing drawn outside of the mask.
    #[inline(always)]
    fn only(self, mask: R::Mask) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let valid = self.valid & mask;
        let [x, y, z] = self.wi;
        let [r, g, b] = self.weight;
        Self {
            wi: [R::select(valid, x, zero), R::select(valid, y, zero), R::select(valid, z, one)],
            weight: [
                R::select(valid, r, zero),
                R::select(valid, g, zero),
                R::select(valid, b, zero),
            ],
            density: R::select(valid, self.density, zero),
            singular: self.singular,
            valid,
            eta2: R::select(valid, self.eta2, one),
        }
    }
}
