//! A part of a lens as polynomials (Hullin, Hanika & Heidrich 2012, "Polynomial Optics"): from where
//! a ray crosses a plane, and its direction, to a point of the ray behind the part and its direction
//! there.
//!
//! The direction behind comes in three numbers of which the length is then corrected, so that one at
//! right angles to the axis, or beyond, is nothing special. The point is where the ray leaves the last
//! surface. Behind a round part both turn with the ray about the axis, and only these are left, with x
//! and d the two-vectors across the axis of place and direction and r = x.x, s = x.d, q = d.d: the
//! vectors are a(r, s, q) x + b(r, s, q) d, the numbers along the axis c(r, s, q). Any other part has all
//! monomials of its four numbers.

use super::refract::{Crossed, Kernel, Lanes, LensRay};
use crate::lanes::Real;

/// Monomials of the three invariants of a round part to the second degree: vectors are of the fifth
/// degree in place and direction.
pub(super) const ROUND: usize = 10;
/// Monomials of four numbers to the third degree.
pub(super) const GENERAL: usize = 35;

/// The polynomials of a part of a lens.
#[derive(Clone, Debug)]
pub struct Polynomial<T> {
    /// Whether the part is round.
    pub(super) round: bool,
    /// What makes numbers around 1 of a place, mm, and of a direction, of the index's length.
    pub(super) scale: [T; 2],
    /// Six rows. Of a round part a and b of the place and a and b of the direction, then the numbers
    /// along the axis; of others x, y, z of the place and of the direction.
    pub(super) rows: Vec<T>,
    /// The refractive index behind.
    pub(super) index: T,
}

/// 1 and the products of three numbers, to the second degree.
#[inline(always)]
pub(super) fn round_terms<R: Real>([r, s, q]: [R; 3]) -> [R; ROUND] {
    [R::constant(1.0), r, s, q, r * r, r * s, r * q, s * s, s * q, q * q]
}

/// 1 and the products of four numbers, to the third degree.
#[inline(always)]
pub(super) fn general_terms<R: Real>(v: [R; 4]) -> [R; GENERAL] {
    let mut terms = [R::constant(1.0); GENERAL];
    let mut count = 1;
    for i in 0..4 {
        terms[count] = v[i];
        count += 1;
        for j in i..4 {
            let square = v[i] * v[j];
            terms[count] = square;
            count += 1;
            for factor in &v[j..] {
                terms[count] = square * *factor;
                count += 1;
            }
        }
    }
    terms
}

/// The invariants of a ray at a round part.
#[inline(always)]
pub(super) fn invariants<R: Real>([x, y, dx, dy]: [R; 4]) -> [R; 3] {
    [x.mul_add(x, y * y), x.mul_add(dx, y * dy), dx.mul_add(dx, dy * dy)]
}

/// The sums of six rows of coefficients, each times the same terms.
#[inline(always)]
fn six<R: Real, const N: usize>(rows: &[R::Scalar], terms: &[R; N]) -> [R; 6] {
    let mut sums = [R::constant(0.0); 6];
    for (sum, row) in sums.iter_mut().zip(rows.chunks_exact(N)) {
        for (coefficient, term) in row.iter().zip(terms) {
            *sum = R::splat(*coefficient).mul_add(*term, *sum);
        }
    }
    sums
}

/// A polynomial in every lane.
#[derive(Clone, Copy)]
pub(super) struct PolynomialLanes<'a, R: Real, const IS_ROUND: bool>(
    pub Lanes<R>,
    pub &'a Polynomial<R::Scalar>,
);

impl<R: Real, const IS_ROUND: bool> PolynomialLanes<'_, R, IS_ROUND> {
    /// Place and direction where a ray crosses the plane before, around 1.
    #[inline(always)]
    pub fn enter(&self, ray: LensRay<R>) -> [R; 4] {
        let ([x, y, z], [tx, ty, tz]) = (ray.p, ray.t);
        let s = (self.0.advance - z) / tz;
        let [place, slope] = self.1.scale.map(R::splat);
        [s.mul_add(tx, x) * place, s.mul_add(ty, y) * place, tx * slope, ty * slope]
    }
}

impl<R: Real, const IS_ROUND: bool> Kernel<R> for PolynomialLanes<'_, R, IS_ROUND> {
    const REFRACTS: bool = false;

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> Crossed<R> {
        let v = self.enter(ray);
        let rows = &self.1.rows;
        let ([x, y, z], t) = if IS_ROUND {
            let [px, pd, tx, td, z, tz] = six(rows, &round_terms(invariants(v)));
            let across = |a: R, b: R| [a.mul_add(v[0], b * v[2]), a.mul_add(v[1], b * v[3])];
            let ([x, y], [tx, ty]) = (across(px, pd), across(tx, td));
            ([x, y, z], [tx, ty, tz])
        } else {
            let [x, y, z, tx, ty, tz] = six(rows, &general_terms(v));
            ([x, y, z], [tx, ty, tz])
        };
        let [tx, ty, tz] = t;
        let length = tx.mul_add(tx, ty.mul_add(ty, tz * tz)).sqrt();
        let along = R::splat(self.1.index) / length;
        Crossed {
            ray: LensRay { p: [x, y, z], t: t.map(|t| t * along), ..ray },
            met: R::constant(0.0).lt(ray.t[2]),
            inside: self.0.clear(x, y),
            incidence: length,
        }
    }
}
