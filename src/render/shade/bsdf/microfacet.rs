//! Microfacet distribution of rough surfaces (GGX).

use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{dot, scale};
use petzval_base::sampler::concentric_disk;

/// Below this roughness along both axes, a surface counts as smooth.
const SMOOTH_ALPHA: f32 = 1e-3;

/// Smallest roughness along one axis of a surface that is rough along the other.
const MIN_ALPHA: f32 = 1e-4;

/// Largest roughness, beyond any real surface; keeps its powers in the range of f32.
const MAX_ALPHA: f32 = 1e3;

/// Microfacets with the distribution of normals of Trowbridge & Reitz 1975 ("GGX") and Smith's
/// height-correlated masking and shadowing.
///
/// The formulas use the *stretched length* s = sqrt(c^2 + (alpha_x w_x)^2 + (alpha_y w_y)^2) of a
/// direction w of cosine c. With it, Smith's Lambda = (s / c - 1) / 2, and no tangent is needed at
/// grazing angles.
#[derive(Clone, Copy, Debug)]
pub struct Microfacets<R: Real> {
    alpha: [R; 2],
    alpha2: [R; 2],
    /// Lanes in which the surface counts as smooth.
    pub smooth: R::Mask,
}

impl<R: Real<Scalar = f32>> Microfacets<R> {
    /// Microfacets of roughness alpha along x and along y.
    #[inline(always)]
    pub fn new(alpha: [R; 2]) -> Self {
        let smooth = alpha[0].max(alpha[1]).lt(R::splat(SMOOTH_ALPHA));
        let clamp = |a: R| a.max(R::splat(MIN_ALPHA)).min(R::splat(MAX_ALPHA));
        let alpha = [clamp(alpha[0]), clamp(alpha[1])];
        Self { alpha, alpha2: [alpha[0].square(), alpha[1].square()], smooth }
    }

    /// Returns D(m): the area of microfacets with unit normal `m`, by solid angle and by area of
    /// the surface (Walter et al. 2007, eq. 33, with one alpha for each axis).
    #[inline(always)]
    pub fn distribution(&self, m: [R; 3]) -> R {
        let [x2, y2] = self.alpha2;
        let area = self.alpha[0] * self.alpha[1];
        let both = area.square() * m[2].square();
        let spread = (m[0].square()).mul_add(y2, (m[1].square()).mul_add(x2, both));
        area.square() * area / (R::constant(std::f64::consts::PI) * spread.square())
    }

    /// Returns the stretched length of a direction.
    #[inline(always)]
    pub fn stretched_length(&self, w: [R; 3]) -> R {
        let slope2 = w[0].square().mul_add(self.alpha2[0], w[1].square() * self.alpha2[1]);
        w[2].mul_add(w[2], slope2).sqrt()
    }

    /// Returns G(wo, wi) / |cos wo|, where G is the share of microfacets that are visible from both
    /// directions (Heitz 2014, eq. 99).
    #[inline(always)]
    pub fn g_over_cos(o: StretchedDirection<R>, i: StretchedDirection<R>) -> R {
        let two = R::splat(2.0);
        two * i.cos / o.length.mul_add(i.cos, i.length * o.cos)
    }

    /// Returns G1(wo) / |cos wo|, where G1 is the share of microfacets that are visible from `wo`
    /// (Heitz 2014, eqs. 43 and 72).
    #[inline(always)]
    pub fn g1_over_cos(o: StretchedDirection<R>) -> R {
        R::splat(2.0) / (o.cos + o.length)
    }

    /// Returns the form of a direction that [`Self::g_over_cos`] and [`Self::g1_over_cos`] take.
    #[inline(always)]
    pub fn stretch(&self, w: [R; 3]) -> StretchedDirection<R> {
        StretchedDirection { cos: w[2].abs(), length: self.stretched_length(w) }
    }

    /// Samples a normal m, z >= 0, among those visible from `wo` (from -`wo` if `wo` points down),
    /// with density D(m) G1(wo) |wo.m| / |cos wo|.
    ///
    /// In stretched space, a visible normal is halfway between the direction and a point of a
    /// spherical cap (Dupuy & Benyoub 2023, "Sampling visible GGX normals with spherical caps").
    /// Lambert's equal-area map takes a disk to the cap. It needs no azimuth, and it gives the
    /// height of the sum as a product without cancellation.
    #[inline(always)]
    pub fn sample_visible_normal(&self, wo: [R; 3], u: [R; 2]) -> [R; 3] {
        let (zero, one, two) = (R::splat(0.0), R::splat(1.0), R::splat(2.0));
        let sign = R::select(wo[2].lt(zero), -one, one);
        let shorten = sign / self.stretched_length(wo).max(R::splat(f32::MIN_POSITIVE));
        let [ax, ay] = self.alpha;
        let [x, y, z] = scale([wo[0] * ax, wo[1] * ay, wo[2]], shorten);
        let [px, py] = concentric_disk(u[0], u[1]);
        let radius2 = px.mul_add(px, py * py).min(one);
        let height = one + z;
        let wide = (height * (two - radius2 * height)).max(zero).sqrt();
        let half = [px.mul_add(wide, x) * ax, py.mul_add(wide, y) * ay, height * (one - radius2)];
        let length2 = dot(half, half);
        let some = zero.lt(length2);
        let m = scale(half, one / R::select(some, length2, one).sqrt());
        [R::select(some, m[0], zero), R::select(some, m[1], zero), R::select(some, m[2], one)]
    }
}

/// Cosine and stretched length of a direction.
#[derive(Clone, Copy, Debug)]
pub struct StretchedDirection<R> {
    /// Magnitude of the cosine of the angle to the normal.
    pub cos: R,
    /// Stretched length, see [`Microfacets`].
    pub length: R,
}
