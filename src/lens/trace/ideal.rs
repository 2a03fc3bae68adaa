//! Ideal lens: first-order optics at any height and slope, a collineation.
//!
//! Heights and slopes (tangents) behind the lens are linear in those before it. Straight lines stay
//! straight, and a plane across the axis is imaged to a plane without distortion (Born & Wolf,
//! "Principles of Optics", 4.3). Rays change direction and height in one plane.

use super::kernel::{KernelOutput, LensRay, SurfaceKernel, SurfaceLanes};
use crate::focus::paraxial::RayTransferMatrix;
use petzval_base::lanes::Real;

/// An ideal lens for rays of one direction of travel.
#[derive(Clone, Debug)]
pub struct Ideal<T> {
    /// Matrix a, b, c, d for x and for y: height = a height + b slope, slope = c height + d slope.
    /// Heights in mm, slopes relative to the axis.
    planes: [[T; 4]; 2],
    /// Refractive index behind the lens.
    index: T,
}

impl<T: Copy> Ideal<T> {
    /// Prepares the lens of these matrices, which are those of light on its way to the film. The
    /// indices are in the order of travel.
    pub(crate) fn new<R: Real<Scalar = T>>(
        planes: [RayTransferMatrix; 2],
        to_film: bool,
        [before, behind]: [f64; 2],
    ) -> Self {
        let plane = |m: RayTransferMatrix| {
            // Slopes change sign with the direction of travel: the inverse with -b and -c.
            let RayTransferMatrix { a, b, c, d } =
                if to_film { m } else { RayTransferMatrix { a: m.d, b: m.b, c: m.c, d: m.a } };
            [a, b * before, c / behind, d * before / behind].map(R::from_f64)
        };
        Self { planes: planes.map(plane), index: R::from_f64(behind) }
    }
}

/// Kernel of an ideal lens.
#[derive(Clone, Copy)]
pub(crate) struct IdealKernel<R> {
    lanes: SurfaceLanes<R>,
    planes: [[R; 4]; 2],
    index: R,
}

impl<R: Real> IdealKernel<R> {
    #[inline(always)]
    pub fn of(lanes: SurfaceLanes<R>, ideal: &Ideal<R::Scalar>) -> Self {
        let planes = ideal.planes.map(|plane| plane.map(R::splat));
        Self { lanes, planes, index: R::splat(ideal.index) }
    }
}

impl<R: Real> SurfaceKernel<R> for IdealKernel<R> {
    const REFRACTS: bool = false;

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> KernelOutput<R> {
        let ([x, y, z], [tx, ty, tz]) = (ray.p, ray.t);
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        let per_z = one / tz;
        let (slope_x, slope_y) = (tx * per_z, ty * per_z);
        let ahead = self.lanes.advance - z;
        let (x, y) = (ahead.mul_add(slope_x, x), ahead.mul_add(slope_y, y));
        let inside = self.lanes.clear(x, y);
        let [[ax, bx, cx, dx], [ay, by, cy, dy]] = self.planes;
        let (sx, sy) = (cx.mul_add(x, dx * slope_x), cy.mul_add(y, dy * slope_y));
        let (x, y) = (ax.mul_add(x, bx * slope_x), ay.mul_add(y, by * slope_y));
        let along = self.index / sx.mul_add(sx, sy.mul_add(sy, one)).sqrt();
        KernelOutput {
            ray: LensRay { p: [x, y, zero], t: [sx * along, sy * along, along], ..ray },
            met: zero.lt(tz),
            inside,
            xi2: tz * tz,
        }
    }
}
