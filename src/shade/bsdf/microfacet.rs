//! The microfacets of rough surfaces.

use super::vector::{dot, scale};
use crate::lanes::Real;
use crate::sampler::disk;

/// Below this roughness in both directions a surface counts as smooth.
const SMOOTH: f32 = 1e-3;

/// The least roughness of a direction where the other one is rough.
const LEAST: f32 = 1e-4;

/// More roughness than any surface has; keeps powers of it in the range of f32.
const MOST: f32 = 1e3;

/// The distribution of normals of Trowbridge & Reitz 1975 ("GGX"), with Smith's shadowing
/// correlated by height. In the formulas a direction w of cosine c is *stretched* to
/// s = sqrt(c^2 + (alpha_x w_x)^2 + (alpha_y w_y)^2), so that Smith's Lambda = (s / c - 1) / 2
/// and no tangent is needed at grazing angles.
#[derive(Clone, Copy, Debug)]
pub struct Microfacets<R: Real> {
    alpha: [R; 2],
    alpha2: [R; 2],
    /// Where the surface counts as smooth.
    pub smooth: R::Mask,
}

impl<R: Real<Scalar = f32>> Microfacets<R> {
    /// Microfacets of roughness alpha along x and along y.
    #[inline(always)]
    pub fn new(alpha: [R; 2]) -> Self {
        let smooth = alpha[0].max(alpha[1]).lt(R::splat(SMOOTH));
        let clamp = |a: R| a.max(R::splat(LEAST)).min(R::splat(MOST));
        let alpha = [clamp(alpha[0]), clamp(alpha[1])];
        Self { alpha, alpha2: [alpha[0].square(), alpha[1].square()], smooth }
    }

    /// D: area of the microfacets with normal `m` (unit) by solid angle, for each area of
    /// surface (Walter et al. 2007, eq. 33, for alphas of two directions).
    #[inline(always)]
    pub fn density(&self, m: [R; 3]) -> R {
        let [x2, y2] = self.alpha2;
        let area = self.alpha[0] * self.alpha[1];
        let both = area.square() * m[2].square();
        let spread = (m[0].square()).mul_add(y2, (m[1].square()).mul_add(x2, both));
        area.square() * area / (R::constant(std::f64::consts::PI) * spread.square())
    }

    /// The stretched length of a direction.
    #[inline(always)]
    pub fn stretched(&self, w: [R; 3]) -> R {
        let slope2 = w[0].square().mul_add(self.alpha2[0], w[1].square() * self.alpha2[1]);
        w[2].mul_add(w[2], slope2).sqrt()
    }

    /// G(wo, wi) / |cos wo|, from the cosines (magnitudes) and stretched lengths
    /// (Heitz 2014, eq. 99).
    #[inline(always)]
    pub fn shadowed(o: Facing<R>, i: Facing<R>) -> R {
        let two = R::splat(2.0);
        two * i.cos / o.stretched.mul_add(i.cos, i.stretched * o.cos)
    }

    /// G1(wo) / |cos wo| (Heitz 2014, eq. 43 and 72).
    #[inline(always)]
    pub fn visible(o: Facing<R>) -> R {
        R::splat(2.0) / (o.cos + o.stretched)
    }

    /// A direction as [`Self::shadowed`] wants it.
    #[inline(always)]
    pub fn facing(&self, w: [R; 3]) -> Facing<R> {
        Facing { cos: w[2].abs(), stretched: self.stretched(w) }
    }

    /// Draws a normal, z >= 0, of those seen from `wo` or, where that is below, from -`wo`,
    /// with density D(m) G1(wo) |wo m| / |cos wo|.
    ///
    /// In the stretched space a visible normal is halfway between the direction and a point of
    /// a spherical cap (Dupuy & Benyoub 2023, "Sampling visible GGX normals with spherical
    /// caps"). The cap is reached from a disk by Lambert's equal-area map, which needs no
    /// azimuth, and in which the height of the sum is a product without cancellation.
    #[inline(always)]
    pub fn sample(&self, wo: [R; 3], u: [R; 2]) -> [R; 3] {
        let (zero, one, two) = (R::splat(0.0), R::splat(1.0), R::splat(2.0));
        let sign = R::select(wo[2].lt(zero), -one, one);
        let shorten = sign / self.stretched(wo).max(R::splat(f32::MIN_POSITIVE));
        let [ax, ay] = self.alpha;
        let [x, y, z] = scale([wo[0] * ax, wo[1] * ay, wo[2]], shorten);
        let [px, py] = disk(u[0], u[1]);
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

/// How a direction stands to the microfacets.
#[derive(Clone, Copy, Debug)]
pub struct Facing<R> {
    /// |cos| of its angle to the surface's normal.
    pub cos: R,
    /// Its stretched length.
    pub stretched: R,
}
