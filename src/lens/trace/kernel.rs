//! Interface of the kernels that take a ray to a surface and through it, and their selection.

use super::asphere::AsphereKernel;
use super::biradial::BiradialKernel;
use super::frame_transform::FrameTransformKernel;
use super::ideal::IdealKernel;
use super::polynomial::PolynomialKernel;
use super::refract::{ConicKernel, CylinderKernel, SphereKernel};
use super::stop::{ClipKernel, ObstructionKernel, OpeningKernel, StopKernel};
use super::surface::{Surface, SurfaceKind};
use crate::prescription::TransverseAxis;
use petzval_base::lanes::Real;

/// A ray, or a packet of rays, inside the lens.
#[derive(Clone, Copy, Debug)]
pub struct LensRay<R> {
    /// Position relative to the vertex of the surface last crossed (mm).
    pub p: [R; 3],
    /// Optical direction cosines: the unit direction times the refractive index of the medium.
    pub t: [R; 3],
    /// Fraction of the light that apertures of partial transmission and lossy surfaces have left.
    pub weight: R,
}

impl<R: Real> LensRay<R> {
    /// Creates a ray of weight 1.
    #[inline(always)]
    pub fn new(p: [R; 3], t: [R; 3]) -> Self {
        Self { p, t, weight: R::constant(1.0) }
    }
}

/// Result of a kernel.
#[derive(Clone, Copy)]
pub(crate) struct KernelOutput<R: Real> {
    /// Ray behind the surface.
    pub ray: LensRay<R>,
    /// Whether the ray meets the sheet of the surface at the vertex, going forward.
    pub met: R::Mask,
    /// Whether the point lies inside the clear aperture or the opening.
    pub inside: R::Mask,
    /// (n cos(theta))^2 before refraction, with theta the angle of incidence. Kernels that do not
    /// refract may return any number.
    pub xi2: R,
}

/// Takes rays to a surface and through it.
pub(crate) trait SurfaceKernel<R: Real> {
    /// Whether the surface refracts, so that total reflection is possible.
    const REFRACTS: bool = true;
    /// Whether the kernel changes the weight.
    const ATTENUATES: bool = false;

    /// Returns the number of approaches before [`Self::cross`]. Each is a loop of its own over the
    /// batch, which hides the latency of an iteration.
    #[inline(always)]
    fn passes(&self) -> usize {
        0
    }

    /// Moves a ray along itself, closer to the surface.
    #[inline(always)]
    fn approach(&self, ray: LensRay<R>, _pass: usize) -> LensRay<R> {
        ray
    }

    /// Takes a ray to the surface and through it.
    fn cross(&self, ray: LensRay<R>) -> KernelOutput<R>;
}

/// Numbers that all surfaces have, in every lane.
#[derive(Clone, Copy)]
pub(crate) struct SurfaceLanes<R> {
    pub advance: R,
    pub c: R,
    pub n2: R,
    pub n2_step: R,
    pub aperture2: R,
}

impl<R: Real> SurfaceLanes<R> {
    #[inline(always)]
    pub fn of(surface: &Surface<R::Scalar>) -> Self {
        Self {
            advance: R::splat(surface.advance),
            c: R::splat(surface.curvature),
            n2: R::splat(surface.n2),
            n2_step: R::splat(surface.n2_step),
            aperture2: R::splat(surface.aperture2),
        }
    }

    /// Takes a ray to the frame of this vertex; with `FAR` also to the plane of the vertex, so that
    /// no precision is lost to the length of the way.
    #[inline(always)]
    pub fn arrive<const FAR: bool>(&self, ray: LensRay<R>) -> LensRay<R> {
        let ([x, y, z], [tx, ty, tz]) = (ray.p, ray.t);
        let z = z - self.advance;
        if FAR {
            let s = -(z / tz);
            return LensRay { p: [s.mul_add(tx, x), s.mul_add(ty, y), R::constant(0.0)], ..ray };
        }
        LensRay { p: [x, y, z], ..ray }
    }

    /// Returns whether a point is inside the clear aperture.
    #[inline(always)]
    pub fn clear(&self, x: R, y: R) -> R::Mask {
        x.mul_add(x, y * y).le(self.aperture2)
    }
}

/// Operation on the kernel of a surface; compiled anew for every kernel.
pub(super) trait KernelVisitor<R: Real> {
    type Output;
    fn visit(self, kernel: impl SurfaceKernel<R>) -> Self::Output;
}

/// Applies an operation to the kernel of a surface.
#[inline(always)]
pub(super) fn dispatch<R: Real, V: KernelVisitor<R>>(
    surface: &Surface<R::Scalar>,
    visitor: V,
) -> V::Output {
    use TransverseAxis::{X, Y};
    let lanes = SurfaceLanes::of(surface);
    match (&surface.kind, surface.far) {
        (SurfaceKind::Stop, _) => visitor.visit(StopKernel(lanes)),
        (SurfaceKind::Sphere, false) => match surface.entrance {
            false => visitor.visit(SphereKernel::<R, false, false>::of(surface)),
            true => visitor.visit(SphereKernel::<R, false, true>::of(surface)),
        },
        (SurfaceKind::Sphere, true) => visitor.visit(SphereKernel::<R, true, false>::of(surface)),
        (SurfaceKind::Conic(k1), false) => match surface.entrance {
            false => visitor.visit(ConicKernel::<R, false, false>(lanes, R::splat(*k1))),
            true => visitor.visit(ConicKernel::<R, false, true>(lanes, R::splat(*k1))),
        },
        (SurfaceKind::Conic(k1), true) => {
            visitor.visit(ConicKernel::<R, true, false>(lanes, R::splat(*k1)))
        }
        (SurfaceKind::Cylinder(X), false) => visitor.visit(CylinderKernel::<R, true, false>(lanes)),
        (SurfaceKind::Cylinder(X), true) => visitor.visit(CylinderKernel::<R, true, true>(lanes)),
        (SurfaceKind::Cylinder(Y), false) => {
            visitor.visit(CylinderKernel::<R, false, false>(lanes))
        }
        (SurfaceKind::Cylinder(Y), true) => visitor.visit(CylinderKernel::<R, false, true>(lanes)),
        (SurfaceKind::Asphere(asphere), far) => match (asphere.odd, far) {
            (false, false) => visitor.visit(AsphereKernel::<R, false, false>(lanes, asphere)),
            (false, true) => visitor.visit(AsphereKernel::<R, false, true>(lanes, asphere)),
            (true, false) => visitor.visit(AsphereKernel::<R, true, false>(lanes, asphere)),
            (true, true) => visitor.visit(AsphereKernel::<R, true, true>(lanes, asphere)),
        },
        (SurfaceKind::Biradial(surface), far) => match (surface.toroid, far) {
            (false, false) => visitor.visit(BiradialKernel::<R, false, false>(lanes, surface)),
            (false, true) => visitor.visit(BiradialKernel::<R, false, true>(lanes, surface)),
            (true, false) => visitor.visit(BiradialKernel::<R, true, false>(lanes, surface)),
            (true, true) => visitor.visit(BiradialKernel::<R, true, true>(lanes, surface)),
        },
        (SurfaceKind::Ideal(ideal), _) => visitor.visit(IdealKernel::<R>::of(lanes, ideal)),
        (SurfaceKind::Polynomial(part), _) => match part.round {
            true => visitor.visit(PolynomialKernel::<R, true>(lanes, part)),
            false => visitor.visit(PolynomialKernel::<R, false>(lanes, part)),
        },
        (SurfaceKind::Iris(shape), _) => visitor.visit(OpeningKernel::<R>(shape)),
        (SurfaceKind::Obstruction(radius2), _) => {
            visitor.visit(ObstructionKernel(R::splat(*radius2)))
        }
        (SurfaceKind::Clip(shape), _) => visitor.visit(ClipKernel::<R>(shape)),
        (SurfaceKind::FrameTransform(transform), _) => {
            visitor.visit(FrameTransformKernel::<R>::of(transform))
        }
    }
}
