//! A lens that obeys first-order optics at any height and slope: a collineation.
//!
//! Heights and slopes (tangents) are linear in those before; what is straight stays straight, and
//! a plane across the axis is imaged to a plane without distortion (Born & Wolf, "Principles of
//! Optics", 4.3). It is a plane where rays leave one straight line for another.

use super::paraxial::Matrix;
use super::refract::{Crossed, Kernel, Lanes, LensRay};
use crate::lanes::Real;

/// What an ideal lens does to rays of one direction of travel.
#[derive(Clone, Debug)]
pub struct Ideal<T> {
    /// By axis, x and y: height from height, height from slope, slope from height, slope from
    /// slope. Heights in mm, slopes relative to the axis.
    planes: [[T; 4]; 2],
    /// The refractive index behind.
    index: T,
}

impl<T: Copy> Ideal<T> {
    /// From the matrices of light on its way to the film, for light on its way there or back. The
    /// indices are in the order of travel.
    pub(super) fn new<R: Real<Scalar = T>>(
        planes: [Matrix; 2],
        to_film: bool,
        [before, behind]: [f64; 2],
    ) -> Self {
        let plane = |m: Matrix| {
            // Turned back, slopes change their sign: the inverse with the sign of b and c changed.
            let Matrix { a, b, c, d } =
                if to_film { m } else { Matrix { a: m.d, b: m.b, c: m.c, d: m.a } };
            [a, b * before, c / behind, d * before / behind].map(R::scalar)
        };
        Self { planes: planes.map(plane), index: R::scalar(behind) }
    }
}

/// An ideal lens in every lane.
#[derive(Clone, Copy)]
pub(super) struct IdealLanes<R> {
    lanes: Lanes<R>,
    planes: [[R; 4]; 2],
    index: R,
}

impl<R: Real> IdealLanes<R> {
    #[inline(always)]
    pub fn of(lanes: Lanes<R>, ideal: &Ideal<R::Scalar>) -> Self {
        let planes = ideal.planes.map(|plane| plane.map(R::splat));
        Self { lanes, planes, index: R::splat(ideal.index) }
    }
}

impl<R: Real> Kernel<R> for IdealLanes<R> {
    const REFRACTS: bool = false;

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> Crossed<R> {
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
        Crossed {
            ray: LensRay { p: [x, y, zero], t: [sx * along, sy * along, along], ..ray },
            met: zero.lt(tz),
            inside,
            incidence: tz * tz,
        }
    }
}
