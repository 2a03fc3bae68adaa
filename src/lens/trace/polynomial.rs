//! Part of a lens as polynomials (Hullin, Hanika & Heidrich 2012, "Polynomial Optics").
//!
//! The polynomials map the point and the direction with which a ray crosses a plane to the point at
//! which it leaves the last surface of the part and its direction there. The direction has three
//! components and its length is corrected afterwards, so that directions across the axis or
//! backwards need no special case.
//!
//! A round part commutes with rotations about the axis. With x and d the two-vectors across the
//! axis of point and direction and r = x.x, s = x.d, q = d.d, vectors behind it are a(r, s, q) x +
//! b(r, s, q) d and components along the axis c(r, s, q). Any other part has all monomials of its
//! four variables.

use super::kernel::{KernelOutput, LensRay, SurfaceKernel, SurfaceLanes};
use petzval_base::lanes::Real;

/// Number of monomials of the three invariants of a round part up to the second degree; vectors are
/// of the fifth degree in point and direction.
pub(crate) const ROUND_TERMS: usize = 10;
/// Number of monomials of four variables up to the third degree.
pub(crate) const GENERAL_TERMS: usize = 35;

/// The polynomials of a part of a lens.
#[derive(Clone, Debug)]
pub struct Polynomial<T> {
    /// Whether the part is rotationally symmetric.
    pub(crate) round: bool,
    /// Factors that scale points (mm) and optical direction cosines to numbers around 1.
    pub(crate) scale: [T; 2],
    /// Coefficients, in six rows. For a round part: a and b of the point, a and b of the direction,
    /// then the two components along the axis. For others: x, y, z of the point and of the
    /// direction.
    pub(crate) rows: Vec<T>,
    /// Refractive index behind the part.
    pub(crate) index: T,
}

/// Returns the monomials of three variables up to the second degree.
#[inline(always)]
pub(crate) fn round_terms<R: Real>([r, s, q]: [R; 3]) -> [R; ROUND_TERMS] {
    [R::constant(1.0), r, s, q, r * r, r * s, r * q, s * s, s * q, q * q]
}

/// Returns the monomials of four variables up to the third degree.
#[inline(always)]
pub(crate) fn general_terms<R: Real>(v: [R; 4]) -> [R; GENERAL_TERMS] {
    let mut terms = [R::constant(1.0); GENERAL_TERMS];
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

/// Returns the invariants r, s and q of a ray at a round part.
#[inline(always)]
pub(crate) fn invariants<R: Real>([x, y, dx, dy]: [R; 4]) -> [R; 3] {
    [x.mul_add(x, y * y), x.mul_add(dx, y * dy), dx.mul_add(dx, dy * dy)]
}

/// Evaluates six rows of coefficients with the same monomials.
#[inline(always)]
fn evaluate<R: Real, const N: usize>(rows: &[R::Scalar], terms: &[R; N]) -> [R; 6] {
    let mut sums = [R::constant(0.0); 6];
    for (sum, row) in sums.iter_mut().zip(rows.chunks_exact(N)) {
        for (coefficient, term) in row.iter().zip(terms) {
            *sum = R::splat(*coefficient).mul_add(*term, *sum);
        }
    }
    sums
}

/// Kernel of a polynomial part.
#[derive(Clone, Copy)]
pub(crate) struct PolynomialKernel<'a, R: Real, const IS_ROUND: bool>(
    pub SurfaceLanes<R>,
    pub &'a Polynomial<R::Scalar>,
);

impl<R: Real, const IS_ROUND: bool> PolynomialKernel<'_, R, IS_ROUND> {
    /// Returns the scaled point and direction with which a ray crosses the entry plane.
    #[inline(always)]
    fn enter(&self, ray: LensRay<R>) -> [R; 4] {
        let ([x, y, z], [tx, ty, tz]) = (ray.p, ray.t);
        let s = (self.0.advance - z) / tz;
        let [point, direction] = self.1.scale.map(R::splat);
        [s.mul_add(tx, x) * point, s.mul_add(ty, y) * point, tx * direction, ty * direction]
    }
}

impl<R: Real, const IS_ROUND: bool> SurfaceKernel<R> for PolynomialKernel<'_, R, IS_ROUND> {
    const REFRACTS: bool = false;

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> KernelOutput<R> {
        let v = self.enter(ray);
        let rows = &self.1.rows;
        let ([x, y, z], t) = if IS_ROUND {
            let [px, pd, tx, td, z, tz] = evaluate(rows, &round_terms(invariants(v)));
            let across = |a: R, b: R| [a.mul_add(v[0], b * v[2]), a.mul_add(v[1], b * v[3])];
            let ([x, y], [tx, ty]) = (across(px, pd), across(tx, td));
            ([x, y, z], [tx, ty, tz])
        } else {
            let [x, y, z, tx, ty, tz] = evaluate(rows, &general_terms(v));
            ([x, y, z], [tx, ty, tz])
        };
        let [tx, ty, tz] = t;
        let length = tx.mul_add(tx, ty.mul_add(ty, tz * tz)).sqrt();
        let along = R::splat(self.1.index) / length;
        KernelOutput {
            ray: LensRay { p: [x, y, z], t: t.map(|t| t * along), ..ray },
            met: R::constant(0.0).lt(ray.t[2]),
            inside: self.0.clear(x, y),
            xi2: length,
        }
    }
}
