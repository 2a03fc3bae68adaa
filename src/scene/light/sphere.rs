//! Sampling of spherical lights by the cone of directions that they subtend (Pharr, Jakob &
//! Humphreys, "Physically Based Rendering", 6.2.4; Shirley, Wang & Zimmerman 1996).

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use crate::scene::geometry::{Sphere, SurfacePoint, gamma};

/// The part of a sphere that is visible from a point outside.
pub(super) struct VisibleCap {
    sphere: Sphere,
    /// Unit vector from the centre of the sphere to the point.
    towards: DVec3,
    /// Squared sine of the half angle that the sphere subtends.
    sin2: f64,
    /// 1 - cosine of that angle, without cancellation.
    versine: f64,
}

impl Sphere {
    /// Returns the part that is visible from a point. Returns `None` for a point inside or, to
    /// rounding, on the sphere, which may see its inside.
    pub(super) fn visible_from(&self, from: Vec3) -> Option<VisibleCap> {
        let from = from.as_dvec3();
        let away = from - self.centre;
        let d2 = away.length_squared();
        let sin2 = self.radius * self.radius / d2;
        let slack = 16.0 * f64::from(f32::EPSILON) * from.abs().max_element();
        (d2.sqrt() > self.radius + slack).then(|| {
            let versine = sin2 / (1.0 + (1.0 - sin2).sqrt());
            VisibleCap { sphere: *self, towards: away / d2.sqrt(), sin2, versine }
        })
    }
}

impl VisibleCap {
    /// Returns the density of [`Self::sample`] [1/sr], which is constant over the cap.
    pub(super) fn density(&self) -> f32 {
        (1.0 / (TAU * self.versine)) as f32
    }

    /// Samples a point of the sphere, uniformly by solid angle.
    pub(super) fn sample(&self, u: [f32; 2]) -> SurfacePoint {
        let versine = f64::from(u[0]) * self.versine;
        let cos = 1.0 - versine;
        let sin2 = versine * (1.0 + cos);
        // The angle at the centre between the observer and the sampled point, from the two other
        // angles of the triangle: without a difference of distances, which would cancel for a
        // distant sphere.
        let ratio = (sin2 / self.sin2).min(1.0);
        let cos_centre = sin2 / self.sin2.sqrt() + cos * (1.0 - ratio).sqrt();
        let sin_centre = (1.0 - cos_centre * cos_centre).max(0.0).sqrt();
        let (x, y) = self.towards.any_orthonormal_pair();
        let (sin_phi, cos_phi) = (f64::from(u[1]) * 2.0 * PI).sin_cos();
        let normal = (x * cos_phi + y * sin_phi) * sin_centre + self.towards * cos_centre;
        let position = (self.sphere.centre + normal * self.sphere.radius).as_vec3();
        let normal = (normal * self.sphere.side).as_vec3();
        let error = position.abs() * gamma(3) + f32::MIN_POSITIVE;
        SurfacePoint { position, error, normal, shading_normal: normal }
    }
}
