//! Reception: how a surface receives light, as far as the selection of a light depends on it.

use glam::Vec3;

use crate::VectorColumns;
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{dot, splat};
use petzval_base::rays::SortedColumn;

/// Squared part of the bound of lights that widens a lobe, since most of them are far inside. Of 0.04 to
/// 1, this left the least noise in the atelier and at night.
const WIDENING: f32 = 0.1;
/// Least squared length of a half vector.
const SHORTEST2: f32 = 1e-3;

/// How surfaces receive light, one per lane.
#[derive(Clone, Copy, Debug)]
pub struct Reception<R = f32> {
    /// Unit normal on the side from which light counts; 0 if it counts from both sides.
    pub facing: [R; 3],
    /// The lobe of a glossy surface; `None` if the surfaces of all lanes scatter widely.
    pub lobe: Option<GlossyLobe<R>>,
}

/// The glossy lobe of a surface, and how much of its light that lobe reflects.
#[derive(Clone, Copy, Debug)]
pub struct GlossyLobe<R = f32> {
    /// Unit vector to where the reflected light goes, world space.
    pub wo: [R; 3],
    /// Squared width alpha of the microfacets (GGX), above 0.
    pub alpha2: R,
    /// Weight of the lobe, in [0, 1); the wide rest of the surface has the difference to 1.
    pub share: R,
}

/// Glossy lobes in columns, see [`GlossyLobe`].
#[derive(Clone, Copy, Debug)]
pub struct LobeColumns<'a> {
    /// Unit vectors to where the reflected light goes, world space.
    pub wo: &'a VectorColumns,
    /// Squared widths alpha of the microfacets.
    pub alpha2: &'a SortedColumn<f32>,
    /// Weights of the lobes; 0 for surfaces that scatter widely.
    pub share: &'a SortedColumn<f32>,
}

impl From<Vec3> for Reception {
    /// Returns the reception of a surface that scatters widely, from its normal or 0.
    fn from(facing: Vec3) -> Self {
        Self { facing: facing.to_array(), lobe: None }
    }
}

impl Reception {
    /// Returns the reception in every lane.
    #[inline(always)]
    pub(super) fn splat<R: Real<Scalar = f32>>(&self) -> Reception<R> {
        let lobe = self.lobe.map(|GlossyLobe { wo, alpha2, share }| GlossyLobe {
            wo: splat(wo),
            alpha2: R::splat(alpha2),
            share: R::splat(share),
        });
        Reception { facing: splat(self.facing), lobe }
    }
}

impl<R: Real<Scalar = f32>> GlossyLobe<R> {
    /// Returns the lobes of a packet, or `None` if their weights are 0 in all lanes.
    #[inline(always)]
    pub fn new(wo: [R; 3], alpha2: R, share: R) -> Option<Self> {
        let some = R::bits(R::splat(0.0).lt(share)) != 0;
        some.then_some(Self { wo, alpha2, share })
    }

    /// Returns the density of the microfacets that reflect light from the unit vector `towards`, times
    /// pi (Walter et al. 2007, equation 33), given the unit normal and the cosine of `towards` to it.
    ///
    /// `sin2_extent` is the squared sine of the half angle that bounds the lights there. It widens the
    /// lobe: half vectors of length l differ by that angle over l.
    #[inline(always)]
    pub(super) fn reflection(&self, normal: [R; 3], towards: [R; 3], cos: R, sin2_extent: R) -> R {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let length2 = R::splat(2.0) * (one + dot(towards, self.wo));
        let inverse = one / length2.max(R::splat(SHORTEST2));
        let along = (cos + dot(normal, self.wo)).max(zero);
        let cos2 = (along * along * inverse).min(one);
        let alpha2 = self.alpha2 + R::splat(WIDENING) * sin2_extent * inverse;
        let spread = cos2 * (alpha2 - one) + one;
        alpha2 / (spread * spread)
    }

    /// Returns the light that the whole surface reflects, given what its wide part and its lobe do.
    #[inline(always)]
    pub(super) fn blend(&self, wide: R, glossy: R) -> R {
        wide + self.share * (glossy - wide)
    }
}
