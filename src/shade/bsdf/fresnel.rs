//! Fresnel's equations.

use crate::lanes::Real;

/// What unpolarised light does at a smooth border between two clear media.
#[derive(Clone, Copy, Debug)]
pub struct Refraction<R> {
    /// The share that is reflected; 1 where reflection is total.
    pub reflectance: R,
    /// eta cos of the angle beyond the border; 0 where reflection is total.
    pub beyond: R,
}

impl<R: Real<Scalar = f32>> Refraction<R> {
    /// `cos` >= 0 of the angle before the border, `eta` the refractive index beyond it over
    /// that before it.
    ///
    /// By Snell's law (eta cos t)^2 = eta^2 - 1 + cos^2, which stays exact at grazing angles
    /// where 1 - sin^2 does not, and is cos^2 itself for eta = 1.
    #[inline(always)]
    pub fn new(cos: R, eta: R) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let square = cos.mul_add(cos, eta.mul_add(eta, -one));
        let passes = zero.lt(square);
        let beyond = R::select(passes, square, zero).sqrt();
        let perpendicular = (cos - beyond) / R::select(passes, cos + beyond, one);
        let dense = eta.square() * cos;
        let parallel = (dense - beyond) / R::select(passes, dense + beyond, one);
        let both = parallel.mul_add(parallel, perpendicular.square()) * R::splat(0.5);
        Self { reflectance: R::select(passes, both, one), beyond }
    }
}

/// The share of unpolarised light that a metal of refractive index eta + i k (relative to the
/// medium before it) reflects; `cos` >= 0 of the angle of incidence.
///
/// Real arithmetic: Lagarde 2013, "Memo on Fresnel equations".
#[inline(always)]
pub fn conductor_reflectance<R: Real<Scalar = f32>>(cos: R, eta: R, k: R) -> R {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    // Keeps the quotient finite where there is no metal at all.
    let tiny = R::splat(1e-30);
    let cos2 = cos.square().min(one);
    let sin2 = one - cos2;
    let (eta2, k2) = (eta.square(), k.square());
    let t0 = eta2 - k2 - sin2;
    let modulus = (t0.mul_add(t0, R::splat(4.0) * eta2 * k2)).sqrt();
    let a = (R::splat(0.5) * (modulus + t0)).max(zero).sqrt();
    let t1 = modulus + cos2;
    let t2 = R::splat(2.0) * cos * a;
    let t3 = cos2.mul_add(modulus, sin2.square());
    let t4 = t2 * sin2;
    // The mean of Rs and Rs (t3 - t4) / (t3 + t4), in one division.
    let mean = (t1 - t2) * t3 / ((t1 + t2) * (t3 + t4)).max(tiny);
    mean.max(zero).min(one)
}
