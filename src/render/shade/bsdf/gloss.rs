//! Glossy share of the light that a surface reflects.

use petzval_base::lanes::Real;

/// The light that a surface reflects by microfacets, and otherwise. Lights are selected by it.
#[derive(Clone, Copy, Debug)]
pub(in crate::shade) struct Gloss<R> {
    /// Width alpha of the microfacets along u and v.
    pub(in crate::shade) alpha: [R; 2],
    /// Albedo of the microfacets.
    pub(in crate::shade) glossy: R,
    /// Albedo of the wide rest.
    pub(in crate::shade) wide: R,
}

impl<R: Real<Scalar = f32>> Gloss<R> {
    /// A surface of microfacets alone.
    #[inline(always)]
    pub(super) fn only(alpha: [R; 2]) -> Self {
        Self { alpha, glossy: R::splat(1.0), wide: R::splat(0.0) }
    }
}

/// Returns the mean of the colour channels.
#[inline(always)]
pub(super) fn mean<R: Real<Scalar = f32>>([r, g, b]: [R; 3]) -> R {
    (r + g + b) * R::constant(1.0 / 3.0)
}
