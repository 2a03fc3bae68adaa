//! Kernels of what only blocks: the stop, the shape of its opening, an obstruction.

use super::iris::Shape;
use super::refract::{Crossed, Kernel, Lanes, LensRay};
use crate::lanes::Real;

/// The plane of a stop.
#[derive(Clone, Copy)]
pub(super) struct Stop<R>(pub Lanes<R>);

impl<R: Real> Kernel<R> for Stop<R> {
    const REFRACTS: bool = false;

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> Crossed<R> {
        let ([x, y, z], [tx, ty, tz]) = (ray.p, ray.t);
        let s = (self.0.advance - z) / tz;
        let (x, y) = (s.mul_add(tx, x), s.mul_add(ty, y));
        let zero = R::constant(0.0);
        Crossed {
            ray: LensRay { p: [x, y, zero], ..ray },
            met: zero.lt(tz),
            inside: self.0.clear(x, y),
            incidence: tz * tz,
        }
    }
}

/// The opening of a shaped stop, where the ray stands in its plane.
#[derive(Clone, Copy)]
pub(super) struct Opening<'a, R: Real>(pub &'a Shape<R::Scalar>);

impl<R: Real> Kernel<R> for Opening<'_, R> {
    const REFRACTS: bool = false;
    const SHADES: bool = true;

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> Crossed<R> {
        let [x, y, _] = ray.p;
        let transmission = self.0.transmission::<R>(x, y);
        let weight = ray.weight * transmission;
        Crossed {
            ray: LensRay { weight, ..ray },
            met: x.same(x),
            inside: R::constant(0.0).lt(transmission) & x.same(x),
            incidence: weight,
        }
    }
}

/// An opaque disk around the axis of the surface on which the ray stands.
#[derive(Clone, Copy)]
pub(super) struct Disk<R>(pub R);

impl<R: Real> Kernel<R> for Disk<R> {
    const REFRACTS: bool = false;

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> Crossed<R> {
        let [x, y, _] = ray.p;
        let h2 = x.mul_add(x, y * y);
        Crossed { ray, met: x.same(x), inside: self.0.le(h2), incidence: h2 }
    }
}
