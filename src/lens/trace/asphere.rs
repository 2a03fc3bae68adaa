//! Aspheres: a conic of revolution plus a polynomial in the height.
//!
//! With P(h) the polynomial and w = z - P(h), a point lies on the surface if
//! c (h^2 + (1 + k) w^2) = 2 w on the sheet 1 - c (1 + k) w > 0. This equation has no square root,
//! and a step of Newton's iteration costs one division. The iteration starts from the conic;
//! [`super::crossing`] has the rest.

use super::crossing::{
    ImplicitSurface, Local, SurfaceBounds, cross_implicit, newton_pass, newton_passes, polynomial,
    start_on_conic,
};
use super::kernel::{KernelOutput, LensRay, SurfaceKernel, SurfaceLanes};
use crate::prescription::Row;
use petzval_base::lanes::Real;

/// Coefficients and bounds of an asphere, +z along the direction of travel.
#[derive(Clone, Debug, PartialEq)]
pub struct Asphere<T> {
    /// Whether there are odd powers.
    pub odd: bool,
    /// 1 + k.
    k1: T,
    /// a_p and p a_p, from the highest power to the square.
    terms: Vec<[T; 2]>,
    /// Bounds of the surface.
    bounds: SurfaceBounds<T>,
    /// Number of steps that almost every ray needs.
    passes: usize,
}

impl<T: Copy> Asphere<T> {
    /// Prepares the asphere of a row for rays along +z (`sign` 1) or -z (-1) of lens space.
    pub fn new<R: Real<Scalar = T>>(row: &Row, sign: f64) -> Self {
        let odd = row.asphere.iter().any(|(power, _)| power % 2 == 1);
        let highest = row.asphere.iter().map(|&(power, _)| power).max().unwrap_or(2);
        let coefficient =
            |p: u32| row.asphere.iter().filter(|(q, _)| *q == p).map(|(_, a)| sign * a).sum();
        let terms = (2..=highest)
            .rev()
            .filter(|power| odd || power % 2 == 0)
            .map(|p| (p, coefficient(p)))
            .map(|(p, a): (u32, f64)| [R::from_f64(a), R::from_f64(f64::from(p) * a)])
            .collect();
        let half = row.diameter / 2.0;
        let heights = (0..=SAMPLES).map(|i| half * f64::from(i) / f64::from(SAMPLES));
        let (mut low, mut high, mut slope) = (0.0f64, 0.0f64, 0.0f64);
        let mut departure = 0.0f64;
        let conic = Row { asphere: Vec::new(), ..row.clone() };
        for h in heights {
            departure = departure.max((row.sag(h) - conic.sag(h)).abs() / half);
            let sag = sign * row.sag(h);
            (low, high) = (low.min(sag), high.max(sag));
            slope = slope.max(row.slope(h).abs());
        }
        // Between two samples the sag may exceed them by half a step at the steepest slope.
        let margin = half / f64::from(SAMPLES) * slope.min(1e3) + 1e-6 * half;
        Self {
            odd,
            k1: R::from_f64(1.0 + row.conic),
            terms,
            bounds: SurfaceBounds::new::<R>([low - margin, high + margin], slope, half),
            passes: newton_passes::<R>(departure),
        }
    }
}

/// Number of heights at which a surface is sampled for its bounds.
const SAMPLES: u32 = 512;

/// Kernel of an asphere.
pub(crate) struct AsphereKernel<'a, R: Real, const ODD: bool, const FAR: bool>(
    pub SurfaceLanes<R>,
    pub &'a Asphere<R::Scalar>,
);

impl<R: Real, const ODD: bool, const FAR: bool> ImplicitSurface<R>
    for AsphereKernel<'_, R, ODD, FAR>
{
    #[inline(always)]
    fn lanes(&self) -> &SurfaceLanes<R> {
        &self.0
    }

    #[inline(always)]
    fn bounds(&self) -> &SurfaceBounds<R::Scalar> {
        &self.1.bounds
    }

    /// The function is w - c (h^2 + (1 + k) w^2) / 2.
    #[inline(always)]
    fn local(&self, [x, y, z]: [R; 3]) -> Local<R> {
        let (c, k1) = (self.0.c, R::splat(self.1.k1));
        let h2 = x.mul_add(x, y * y);
        let (p, q) = polynomial::<R>(&self.1.terms, ODD, h2);
        let w = z - p;
        let half_c = c * R::constant(0.5);
        let over = (-half_c).mul_add((k1 * w).mul_add(w, h2), w);
        let normal_z = (-(c * k1)).mul_add(w, R::constant(1.0));
        let across = -q.mul_add(normal_z, c);
        Local { over, normal: [across * x, across * y, normal_z] }
    }

    #[inline(always)]
    fn height_over(&self, [x, y, z]: [R; 3]) -> R {
        let (c, k1) = (self.0.c, R::splat(self.1.k1));
        let half = R::splat(self.1.bounds.half);
        let h2 = x.mul_add(x, y * y).min(half * half);
        let (p, _) = polynomial::<R>(&self.1.terms, ODD, h2);
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        let root = (-(k1 * c * c)).mul_add(h2, one).max(zero).sqrt();
        z - p - c * h2 / (one + root)
    }
}

impl<R: Real, const ODD: bool, const FAR: bool> SurfaceKernel<R>
    for AsphereKernel<'_, R, ODD, FAR>
{
    #[inline(always)]
    fn passes(&self) -> usize {
        self.1.passes
    }

    /// Moves the ray to the conic in the first pass, and by a Newton step in each later one.
    #[inline(always)]
    fn approach(&self, ray: LensRay<R>, pass: usize) -> LensRay<R> {
        if pass == 0 {
            start_on_conic(self.0.arrive::<FAR>(ray), self.0.c, R::splat(self.1.k1))
        } else {
            newton_pass(self, ray)
        }
    }

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> KernelOutput<R> {
        cross_implicit(self, ray)
    }
}
