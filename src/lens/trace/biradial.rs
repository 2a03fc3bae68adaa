//! Surfaces of two radii: biconics and toroids, with a polynomial.
//!
//! A biconic has the sag Q / (1 + r) + P(h), with Q = cx x^2 + cy y^2, r^2 = 1 - (1 + kx) cx^2 x^2 -
//! (1 + ky) cy^2 y^2 and h^2 = x^2 + y^2. A toroid is the curve g(y), a conic plus P(y), rotated
//! about the axis parallel to y that meets z at 1 / cx: with u = 1 - cx g(y) and r^2 = u^2 - cx^2
//! x^2 its sag is g(y) + cx x^2 / (u + r).
//!
//! Newton's iteration works with F = r (z - sag), so that its gradient has no division by r. It
//! starts from the sphere of the mean curvature.

use super::crossing::{
    ImplicitSurface, Local, SurfaceBounds, cross_implicit, newton_pass, newton_passes, polynomial,
    start_on_conic,
};
use super::kernel::{KernelOutput, LensRay, SurfaceKernel, SurfaceLanes};
use crate::prescription::{CrossSection, Row};
use petzval_base::lanes::Real;

/// Rings, and points on a ring, at which a surface is sampled for its bounds.
const SAMPLES: [u32; 2] = [128, 64];

/// Smallest square of r: beyond the edge of a surface the iteration only has to stay finite.
const FLOOR: f64 = 1e-6;

/// Coefficients and bounds of a surface of two radii, +z along the direction of travel.
#[derive(Clone, Debug, PartialEq)]
pub struct Biradial<T> {
    /// Whether this is a toroid; otherwise it is a biconic.
    pub toroid: bool,
    /// Whether there are odd powers.
    odd: bool,
    /// Curvatures along x and y (1/mm).
    c: [T; 2],
    /// 1 + k along x and y.
    k1: [T; 2],
    /// a_p and p a_p, from the highest power to the square.
    terms: Vec<[T; 2]>,
    /// Curvature of the sphere from which the iteration starts (1/mm).
    start: T,
    /// Bounds of the surface.
    bounds: SurfaceBounds<T>,
    /// Number of steps that almost every ray needs.
    passes: usize,
}

impl<T: Copy> Biradial<T> {
    /// Prepares the surface of a row with a section along x, for rays along +z (`sign` 1) or -z
    /// (-1) of lens space.
    pub fn new<R: Real<Scalar = T>>(row: &Row, across: CrossSection, sign: f64) -> Self {
        let odd = row.asphere.iter().any(|(power, _)| power % 2 == 1);
        let highest = row.asphere.iter().map(|&(power, _)| power).max().unwrap_or(1);
        let coefficient =
            |p: u32| row.asphere.iter().filter(|(q, _)| *q == p).map(|(_, a)| sign * a).sum();
        let terms = (2..=highest)
            .rev()
            .filter(|power| odd || power % 2 == 0)
            .map(|p| (p, coefficient(p)))
            .map(|(p, a): (u32, f64)| [R::from_f64(a), R::from_f64(f64::from(p) * a)])
            .collect();
        let half = row.diameter / 2.0;
        let curvatures = [across.curvature(), row.curvature()];
        let start = (curvatures[0] + curvatures[1]) / 2.0;
        let (mut low, mut high, mut slope, mut departure) = (0.0f64, 0.0f64, 0.0f64, 0.0f64);
        for ring in 0..=SAMPLES[0] {
            let h = half * f64::from(ring) / f64::from(SAMPLES[0]);
            let root = (1.0 - (start * h).powi(2)).max(0.0).sqrt();
            let sphere = start * h * h / (1.0 + root);
            for point in 0..SAMPLES[1] {
                let angle = std::f64::consts::TAU * f64::from(point) / f64::from(SAMPLES[1]);
                let [x, y] = [h * angle.cos(), h * angle.sin()];
                let sag = row.sag_at(x, y);
                departure = departure.max((sag - sphere).abs() / half);
                (low, high) = (low.min(sign * sag), high.max(sign * sag));
                let [along_x, along_y] = row.gradient(x, y);
                slope = slope.max(along_x.hypot(along_y));
            }
        }
        // Between two samples the sag may exceed them by half a step at the steepest slope, and
        // the slope is sampled more coarsely than on a surface of revolution.
        let step = std::f64::consts::PI / f64::from(SAMPLES[1]);
        let margin = half * step * slope.min(1e3) + 1e-6 * half;
        let [kx, ky] = [across.conic(), row.conic];
        Self {
            toroid: matches!(across, CrossSection::Toroid { .. }),
            odd,
            c: curvatures.map(|c| R::from_f64(sign * c)),
            k1: [kx, ky].map(|k| R::from_f64(1.0 + k)),
            terms,
            start: R::from_f64(sign * start),
            bounds: SurfaceBounds::new::<R>([low - margin, high + margin], 1.02 * slope, half),
            passes: newton_passes::<R>(departure),
        }
    }
}

/// Kernel of a surface of two radii.
pub(crate) struct BiradialKernel<'a, R: Real, const TOROID: bool, const FAR: bool>(
    pub SurfaceLanes<R>,
    pub &'a Biradial<R::Scalar>,
);

impl<R: Real, const TOROID: bool, const FAR: bool> BiradialKernel<'_, R, TOROID, FAR> {
    /// Returns the sag at a point, r, and -r times the gradient of the sag.
    #[inline(always)]
    fn sag(&self, x: R, y: R) -> (R, R, [R; 2]) {
        let ([cx, cy], [kx, ky]) = (self.1.c.map(R::splat), self.1.k1.map(R::splat));
        let (one, floor) = (R::constant(1.0), R::constant(FLOOR));
        let (bx, by) = (cx * x, cy * y);
        let (x2, y2) = (x * x, y * y);
        if TOROID {
            let (p, q) = polynomial::<R>(&self.1.terms, self.1.odd, y2);
            let root = (-(ky * by)).mul_add(by, one).max(floor).sqrt();
            let g = cy.mul_add(y2 / (one + root), p);
            let slope = y * (cy / root + q);
            let u = (-cx).mul_add(g, one);
            let r = u.mul_add(u, -(bx * bx)).max(floor).sqrt();
            ((cx * x2 / (u + r)) + g, r, [-bx, -(u * slope)])
        } else {
            let (p, q) = polynomial::<R>(&self.1.terms, self.1.odd, x2 + y2);
            let (ex, ey) = (kx * bx, ky * by);
            let r = (-ex).mul_add(bx, (-ey).mul_add(by, one)).max(floor).sqrt();
            let per = one / (one + r);
            let base = bx.mul_add(x, by * y) * per;
            let (twice, q_r) = (r + r, q * r);
            let gradient = [
                -((bx * twice + ex * cx * base) * per + q_r * x),
                -((by * twice + ey * cy * base) * per + q_r * y),
            ];
            (base + p, r, gradient)
        }
    }
}

impl<R: Real, const TOROID: bool, const FAR: bool> ImplicitSurface<R>
    for BiradialKernel<'_, R, TOROID, FAR>
{
    #[inline(always)]
    fn lanes(&self) -> &SurfaceLanes<R> {
        &self.0
    }

    #[inline(always)]
    fn bounds(&self) -> &SurfaceBounds<R::Scalar> {
        &self.1.bounds
    }

    #[inline(always)]
    fn local(&self, [x, y, z]: [R; 3]) -> Local<R> {
        let (sag, r, [nx, ny]) = self.sag(x, y);
        Local { over: (z - sag) * r, normal: [nx, ny, r] }
    }

    #[inline(always)]
    fn height_over(&self, [x, y, z]: [R; 3]) -> R {
        let half = R::splat(self.1.bounds.half);
        let h = x.mul_add(x, y * y).sqrt().max(half);
        let scale = half / h;
        let (sag, ..) = self.sag(scale * x, scale * y);
        z - sag
    }
}

impl<R: Real, const TOROID: bool, const FAR: bool> SurfaceKernel<R>
    for BiradialKernel<'_, R, TOROID, FAR>
{
    #[inline(always)]
    fn passes(&self) -> usize {
        self.1.passes
    }

    /// Moves the ray to the mean sphere in the first pass, and by a Newton step in each later one.
    #[inline(always)]
    fn approach(&self, ray: LensRay<R>, pass: usize) -> LensRay<R> {
        if pass == 0 {
            let start = R::splat(self.1.start);
            start_on_conic(self.0.arrive::<FAR>(ray), start, R::constant(1.0))
        } else {
            newton_pass(self, ray)
        }
    }

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> KernelOutput<R> {
        cross_implicit(self, ray)
    }
}
