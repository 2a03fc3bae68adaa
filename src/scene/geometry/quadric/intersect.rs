//! Intersection of rays with a quadric, one or eight at a time, in f64.

use glam::{DAffine3, DVec3};

use super::{Quadric, QuadricForm, TAU, bounds, phi};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{dot, scale_add, transform};

/// A quadric as rays meet it: its form and its place, without what shading needs.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct QuadricSurface {
    form: QuadricForm,
    phi_max: f64,
    /// From the space of the rays to the quadric's own space.
    form_from_rays: DAffine3,
}

impl Quadric {
    /// Returns the surface for rays in object space.
    #[inline(always)]
    pub(crate) fn surface(&self) -> QuadricSurface {
        let Self { form, phi_max, form_from_object, .. } = *self;
        QuadricSurface { form, phi_max, form_from_rays: form_from_object }
    }

    /// Returns the surface for rays in world space, and the least box around it there, apart from a
    /// limit of its angle. `None` if the transform cannot be inverted.
    pub(crate) fn instanced(
        &self,
        world_from_object: &DAffine3,
    ) -> Option<(QuadricSurface, [DVec3; 2])> {
        let bounds = bounds::transformed(&self.form, &(*world_from_object * self.object_from_form));
        let form_from_rays = self.form_from_object * world_from_object.inverse();
        let surface = QuadricSurface { form_from_rays, ..self.surface() };
        form_from_rays.is_finite().then_some((surface, bounds))
    }
}

impl QuadricSurface {
    /// Returns the distances to the first intersections of rays with 0 < t < `t_max`, or NaN.
    #[inline(always)]
    pub(crate) fn intersect<R: Real<Scalar = f64>>(
        &self,
        origin: [R; 3],
        direction: [R; 3],
        t_max: R,
    ) -> R {
        let splat = |v: DVec3| [R::splat(v.x), R::splat(v.y), R::splat(v.z)];
        let matrix = &self.form_from_rays.matrix3;
        let columns = [splat(matrix.x_axis), splat(matrix.y_axis), splat(matrix.z_axis)];
        let shift = splat(self.form_from_rays.translation);
        let o = transform(&columns, origin);
        let o = [o[0] + shift[0], o[1] + shift[1], o[2] + shift[2]];
        let d = transform(&columns, direction);
        let (never, zero) = (R::splat(f64::NAN), R::splat(0.0));
        let [near, far] = self.roots(o, d);
        let meets = |t: R| zero.lt(t) & t.lt(t_max) & self.contains(scale_add(d, t, o));
        R::select(meets(near), near, R::select(meets(far), far, never))
    }

    /// Returns the intersections with the unclipped surface in ascending order; NaN if there are
    /// none.
    #[inline(always)]
    fn roots<R: Real<Scalar = f64>>(&self, o: [R; 3], d: [R; 3]) -> [R; 2] {
        match self.form {
            QuadricForm::Disk { height, .. } => {
                [(R::splat(height) - o[2]) / d[2], R::splat(f64::NAN)]
            }
            QuadricForm::Sphere { radius, .. } => round_roots(radius, o, d),
            QuadricForm::Cylinder { radius, .. } => {
                let zero = R::splat(0.0);
                round_roots(radius, [o[0], o[1], zero], [d[0], d[1], zero])
            }
            QuadricForm::Cone { radius, height } => {
                let k = R::splat((radius / height).powi(2));
                let rise = o[2] - R::splat(height);
                let a = d[0] * d[0] + d[1] * d[1] - k * d[2] * d[2];
                let half_b = -(o[0] * d[0] + o[1] * d[1] - k * rise * d[2]);
                let c = o[0] * o[0] + o[1] * o[1] - k * rise * rise;
                quadratic(a, half_b, c, half_b * half_b - a * c)
            }
        }
    }

    /// Returns whether points of the unclipped surface are within the clipping limits.
    #[inline(always)]
    fn contains<R: Real<Scalar = f64>>(&self, p: [R; 3]) -> R::Mask {
        let zero = R::splat(0.0);
        let between = |z: [f64; 2]| R::splat(z[0]).le(p[2]) & p[2].le(R::splat(z[1]));
        let inside = match self.form {
            QuadricForm::Sphere { radius, z } if z == [-radius, radius] => zero.le(zero),
            QuadricForm::Sphere { z, .. } | QuadricForm::Cylinder { z, .. } => between(z),
            QuadricForm::Disk { radius, inner, .. } => {
                let r2 = p[0] * p[0] + p[1] * p[1];
                R::splat(inner * inner).le(r2) & r2.le(R::splat(radius * radius))
            }
            QuadricForm::Cone { height, .. } => between([height.min(0.0), height.max(0.0)]),
        };
        if self.phi_max >= TAU {
            return inside;
        }
        inside & p[0].zip(p[1], phi).le(R::splat(self.phi_max))
    }
}

/// Returns the intersections with a sphere about the origin, or in two dimensions with a cylinder.
#[inline(always)]
fn round_roots<R: Real<Scalar = f64>>(radius: f64, o: [R; 3], d: [R; 3]) -> [R; 2] {
    let a = dot(d, d);
    let half_b = -dot(o, d);
    let radius2 = R::splat(radius * radius);
    // The discriminant from the point nearest to the centre does not cancel (Haines et al. 2019,
    // "Precision improvements for ray/sphere intersection").
    let nearest = scale_add(d, half_b / a, o);
    quadratic(a, half_b, dot(o, o) - radius2, a * (radius2 - dot(nearest, nearest)))
}

/// Returns the roots of a t^2 - 2 b t + c in ascending order, without cancellation, with b =
/// `half_b`; NaN if there are none. The caller computes `discriminant` = b^2 - a c as exactly as it
/// can.
#[inline(always)]
fn quadratic<R: Real<Scalar = f64>>(a: R, half_b: R, c: R, discriminant: R) -> [R; 2] {
    let root = discriminant.sqrt();
    let q = half_b + R::select(half_b.lt(R::splat(0.0)), -root, root);
    let (one, other) = (c / q, q / a);
    let ascending = one.lt(other);
    [R::select(ascending, one, other), R::select(ascending, other, one)]
}
