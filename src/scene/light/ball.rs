//! Whole spheres as lights: sampled by the cone of directions in which they are seen (Pharr,
//! Jakob & Humphreys, "Physically Based Rendering", 6.2.4; Shirley, Wang & Zimmerman 1996).

use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use crate::scene::point::{SurfacePoint, gamma};

/// A sphere in world space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ball {
    /// Its centre.
    pub centre: DVec3,
    /// Its radius.
    pub radius: f64,
    /// 1, or -1 where its normals point inwards.
    pub side: f64,
}

/// A ball as a point outside sees it.
pub(super) struct Disc {
    ball: Ball,
    /// Unit vector from the ball's centre to the point.
    towards: DVec3,
    /// Sine, squared, of the angle between its centre and its rim.
    sin2: f64,
    /// 1 - cosine of that angle, without cancellation.
    versine: f64,
}

impl Ball {
    /// How a point sees the ball; `None` from inside, and from where rounding may have put a
    /// point of the ball itself: that sees its inside.
    pub(super) fn seen(&self, from: Vec3) -> Option<Disc> {
        let from = from.as_dvec3();
        let away = from - self.centre;
        let d2 = away.length_squared();
        let sin2 = self.radius * self.radius / d2;
        let slack = 16.0 * f64::from(f32::EPSILON) * from.abs().max_element();
        (d2.sqrt() > self.radius + slack).then(|| {
            let versine = sin2 / (1.0 + (1.0 - sin2).sqrt());
            Disc { ball: *self, towards: away / d2.sqrt(), sin2, versine }
        })
    }
}

impl Disc {
    /// Density by solid angle of [`Self::sample`], the same everywhere in the disc.
    pub(super) fn density(&self) -> f32 {
        (1.0 / (TAU * self.versine)) as f32
    }

    /// A point of the ball, uniform by solid angle.
    pub(super) fn sample(&self, u: [f32; 2]) -> SurfacePoint {
        let versine = f64::from(u[0]) * self.versine;
        let cos = 1.0 - versine;
        let sin2 = versine * (1.0 + cos);
        // The angle at the centre between the observer and the point, from the two others of
        // the triangle: no distance is subtracted from another, however far the ball is.
        let share = (sin2 / self.sin2).min(1.0);
        let cos_centre = sin2 / self.sin2.sqrt() + cos * (1.0 - share).sqrt();
        let sin_centre = (1.0 - cos_centre * cos_centre).max(0.0).sqrt();
        let (x, y) = self.towards.any_orthonormal_pair();
        let (sin_phi, cos_phi) = (f64::from(u[1]) * 2.0 * PI).sin_cos();
        let normal = (x * cos_phi + y * sin_phi) * sin_centre + self.towards * cos_centre;
        let position = (self.ball.centre + normal * self.ball.radius).as_vec3();
        let normal = (normal * self.ball.side).as_vec3();
        let error = position.abs() * gamma(3) + f32::MIN_POSITIVE;
        SurfacePoint { position, error, normal, shading: normal }
    }
}
