//! Fresnel equations of dielectrics and conductors.

use petzval_base::lanes::Real;

/// Reflection and refraction of unpolarised light at a smooth interface between two clear media.
#[derive(Clone, Copy, Debug)]
pub struct Refraction<R> {
    /// Share of the light that is reflected; 1 at total internal reflection.
    pub reflectance: R,
    /// eta times the cosine of the angle of refraction; 0 at total internal reflection.
    pub eta_cos: R,
}

impl<R: Real<Scalar = f32>> Refraction<R> {
    /// Refracts light. `cos` >= 0 is the cosine of the angle of incidence, `eta` the refractive
    /// index beyond the interface over that before it.
    ///
    /// Snell's law is used as (eta cos t)^2 = eta^2 - 1 + cos^2. Unlike 1 - sin^2, this stays
    /// accurate at grazing angles, and it is exactly cos^2 for eta = 1.
    #[inline(always)]
    pub fn new(cos: R, eta: R) -> Self {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let square = cos.mul_add(cos, eta.mul_add(eta, -one));
        let passes = zero.lt(square);
        let eta_cos = R::select(passes, square, zero).sqrt();
        let perpendicular = (cos - eta_cos) / R::select(passes, cos + eta_cos, one);
        let dense = eta.square() * cos;
        let parallel = (dense - eta_cos) / R::select(passes, dense + eta_cos, one);
        let both = parallel.mul_add(parallel, perpendicular.square()) * R::splat(0.5);
        Self { reflectance: R::select(passes, both, one), eta_cos }
    }
}

/// Returns the share of unpolarised light that a metal reflects. `cos` >= 0 is the cosine of the
/// angle of incidence, eta + i k the refractive index relative to the medium before the metal.
///
/// The formula in real arithmetic is from Lagarde 2013, "Memo on Fresnel equations".
#[inline(always)]
pub fn conductor_reflectance<R: Real<Scalar = f32>>(cos: R, eta: R, k: R) -> R {
    let (zero, one) = (R::splat(0.0), R::splat(1.0));
    // Keeps the quotient finite for eta = k = 0.
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
    // The mean of Rs and Rp = Rs (t3 - t4) / (t3 + t4), in one division.
    let mean = (t1 - t2) * t3 / ((t1 + t2) * (t3 + t4)).max(tiny);
    mean.max(zero).min(one)
}
