//! Kernels that only block: the stop, the shape of its opening, an obstruction.

use super::kernel::{KernelOutput, LensRay, SurfaceKernel, SurfaceLanes};
use crate::prescription::iris::{ApertureMask, Iris};
use crate::prescription::surface_aperture::{ApertureForm, SurfaceAperture};
use petzval_base::lanes::Real;

/// Kernel of the plane of a stop.
#[derive(Clone, Copy)]
pub(crate) struct StopKernel<R>(pub SurfaceLanes<R>);

impl<R: Real> SurfaceKernel<R> for StopKernel<R> {
    const REFRACTS: bool = false;

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> KernelOutput<R> {
        let ([x, y, z], [tx, ty, tz]) = (ray.p, ray.t);
        let s = (self.0.advance - z) / tz;
        let (x, y) = (s.mul_add(tx, x), s.mul_add(ty, y));
        let zero = R::constant(0.0);
        KernelOutput {
            ray: LensRay { p: [x, y, zero], ..ray },
            met: zero.lt(tz),
            inside: self.0.clear(x, y),
            xi2: tz * tz,
        }
    }
}

/// Kernel of the opening of a shaped stop, for rays in its plane.
#[derive(Clone, Copy)]
pub(crate) struct OpeningKernel<'a, R: Real>(pub &'a ApertureShape<R::Scalar>);

impl<R: Real> SurfaceKernel<R> for OpeningKernel<'_, R> {
    const REFRACTS: bool = false;
    const ATTENUATES: bool = true;

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> KernelOutput<R> {
        let [x, y, _] = ray.p;
        let transmission = self.0.transmission::<R>(x, y);
        let weight = ray.weight * transmission;
        KernelOutput {
            ray: LensRay { weight, ..ray },
            met: x.equals(x),
            inside: R::constant(0.0).lt(transmission) & x.equals(x),
            xi2: weight,
        }
    }
}

/// Kernel of an opaque disk around the vertex of the surface on which the ray is, with the square
/// of its radius.
#[derive(Clone, Copy)]
pub(crate) struct ObstructionKernel<R>(pub R);

impl<R: Real> SurfaceKernel<R> for ObstructionKernel<R> {
    const REFRACTS: bool = false;

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> KernelOutput<R> {
        let [x, y, _] = ray.p;
        let h2 = x.mul_add(x, y * y);
        KernelOutput { ray, met: x.equals(x), inside: self.0.le(h2), xi2: h2 }
    }
}

/// A rectangle or ellipse that clips, ready for a kernel; mm.
#[derive(Clone, Copy, Debug)]
pub struct ClipShape<T> {
    rectangle: bool,
    obscures: bool,
    centre: [T; 2],
    /// Cosine and sine of its rotation.
    turn: [T; 2],
    per_half_width: [T; 2],
}

impl<T> ClipShape<T> {
    /// Prepares an aperture.
    pub fn new<R: Real<Scalar = T>>(aperture: &SurfaceAperture) -> Self {
        Self {
            rectangle: aperture.form == ApertureForm::Rectangle,
            obscures: aperture.obscures,
            centre: aperture.centre.map(R::from_f64),
            turn: {
                let (sin, cos) = aperture.rotation.to_radians().sin_cos();
                [cos, sin].map(R::from_f64)
            },
            per_half_width: aperture.half_widths.map(|half| R::from_f64(half.recip())),
        }
    }
}

/// Kernel of a rectangle or ellipse on the surface on which the ray is.
#[derive(Clone, Copy)]
pub(crate) struct ClipKernel<'a, R: Real>(pub &'a ClipShape<R::Scalar>);

impl<R: Real> SurfaceKernel<R> for ClipKernel<'_, R> {
    const REFRACTS: bool = false;

    #[inline(always)]
    fn cross(&self, ray: LensRay<R>) -> KernelOutput<R> {
        let [x, y, _] = ray.p;
        let shape = self.0;
        let [x, y] = [(x, 0), (y, 1)].map(|(p, i)| p - R::splat(shape.centre[i]));
        let [cos, sin] = shape.turn.map(R::splat);
        let [u, v] = [x.mul_add(cos, y * sin), y.mul_add(cos, -(x * sin))];
        let [u, v] = [(u, 0), (v, 1)].map(|(p, i)| p * R::splat(shape.per_half_width[i]));
        // 1 on the edge, less inside.
        let place = if shape.rectangle { u.abs().max(v.abs()) } else { u.mul_add(u, v * v) };
        let one = R::constant(1.0);
        let inside = if shape.obscures { one.le(place) } else { place.le(one) };
        let [x, ..] = ray.p;
        KernelOutput { ray, met: x.equals(x), inside: inside & x.equals(x), xi2: place }
    }
}

/// The opening of an iris of a given diameter, ready for a kernel; mm.
#[derive(Clone, Debug)]
pub struct ApertureShape<T> {
    edges: Edges<T>,
    mask: Option<(ApertureMask, f64)>,
}

/// The arcs that bound an opening: points inside fulfil `curvature h^2 + normal . p <= reach` for
/// every normal.
#[derive(Clone, Debug)]
struct Edges<T> {
    normals: Vec<[T; 2]>,
    curvature: T,
    reach: T,
}

impl<T: Copy> ApertureShape<T> {
    /// Prepares the opening of an iris of a clear diameter (mm).
    pub fn new<R: Real<Scalar = T>>(iris: &Iris, diameter: f64) -> Self {
        let corner = diameter / 2.0;
        let open =
            Edges { normals: Vec::new(), curvature: R::from_f64(0.0), reach: R::from_f64(0.0) };
        match iris {
            Iris::Round => Self { edges: open, mask: None },
            Iris::Mask(mask) => Self { edges: open, mask: Some((mask.clone(), corner)) },
            &Iris::Blades { count, rotation, curvature } => {
                let half_angle = std::f64::consts::PI / f64::from(count);
                let bend = curvature / corner;
                // The arc bulges over its chord; a is the distance of its middle from the axis.
                let half_chord = corner * half_angle.sin();
                let chord = corner * half_angle.cos();
                let bulge = bend * half_chord * half_chord
                    / (1.0 + (1.0 - (bend * half_chord).powi(2)).max(0.0).sqrt());
                let a = chord + bulge;
                let normals = (0..count).map(|i| {
                    let angle = rotation.to_radians() + half_angle * f64::from(2 * i + 1);
                    let scale = 2.0 * (1.0 - bend * a);
                    [angle.cos(), angle.sin()].map(|n| R::from_f64(n * scale))
                });
                let edges = Edges {
                    normals: normals.collect(),
                    curvature: R::from_f64(bend),
                    reach: R::from_f64(2.0 * a - bend * a * a),
                };
                Self { edges, mask: None }
            }
        }
    }

    /// Returns the transmission at a point of the stop [mm from the axis].
    #[inline(always)]
    pub fn transmission<R: Real<Scalar = T>>(&self, x: R, y: R) -> R {
        if let Some((mask, corner)) = &self.mask {
            return x.zip(y, |x, y| R::from_f64(mask.at(R::to_f64(x), R::to_f64(y), *corner)));
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
