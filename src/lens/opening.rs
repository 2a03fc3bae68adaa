//! Kernels of what only blocks: the stop, the shape of its opening, an obstruction.

use super::iris::{Iris, Mask};
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

/// An iris of a given width, ready for a kernel; mm.
#[derive(Clone, Debug)]
pub struct Shape<T> {
    edges: Edges<T>,
    mask: Option<(Mask, f64)>,
}

/// The arcs that bound an opening: inside, `curvature h^2 + normal . p <= reach` for all.
#[derive(Clone, Debug)]
struct Edges<T> {
    normals: Vec<[T; 2]>,
    curvature: T,
    reach: T,
}

impl<T: Copy> Shape<T> {
    /// The opening of an iris of this clear diameter.
    pub fn new<R: Real<Scalar = T>>(iris: &Iris, diameter: f64) -> Self {
        let corner = diameter / 2.0;
        let open = Edges { normals: Vec::new(), curvature: R::scalar(0.0), reach: R::scalar(0.0) };
        match iris {
            Iris::Round => Self { edges: open, mask: None },
            Iris::Mask(mask) => Self { edges: open, mask: Some((mask.clone(), corner)) },
            &Iris::Blades { count, rotation, curvature } => {
                let half_angle = std::f64::consts::PI / f64::from(count);
                let bend = curvature / corner;
                // The arc bulges over its chord; a is where its middle is.
                let half_chord = corner * half_angle.sin();
                let chord = corner * half_angle.cos();
                let bulge = bend * half_chord * half_chord
                    / (1.0 + (1.0 - (bend * half_chord).powi(2)).max(0.0).sqrt());
                let a = chord + bulge;
                let normals = (0..count).map(|i| {
                    let angle = rotation.to_radians() + half_angle * f64::from(2 * i + 1);
                    let scale = 2.0 * (1.0 - bend * a);
                    [angle.cos(), angle.sin()].map(|n| R::scalar(n * scale))
                });
                let edges = Edges {
                    normals: normals.collect(),
                    curvature: R::scalar(bend),
                    reach: R::scalar(2.0 * a - bend * a * a),
                };
                Self { edges, mask: None }
            }
        }
    }

    /// Share of the light that passes at a point of the stop, mm from the axis.
    #[inline(always)]
    pub fn transmission<R: Real<Scalar = T>>(&self, x: R, y: R) -> R {
        if let Some((mask, corner)) = &self.mask {
            return x.zip(y, |x, y| R::scalar(mask.at(R::to_f64(x), R::to_f64(y), *corner)));
        }
        let (zero, one) = (R::constant(0.0), R::constant(1.0));
        let mut furthest = zero;
        for &[nx, ny] in &self.edges.normals {
            furthest = furthest.max(x.mul_add(R::splat(nx), y * R::splat(ny)));
        }
        let h2 = x.mul_add(x, y * y);
        let reached = R::splat(self.edges.curvature).mul_add(h2, furthest);
        R::select(reached.le(R::splat(self.edges.reach)), one, zero)
    }
}
