//! Surface points of curves, with pbrt-v4's frames.
//!
//! dp/du is the derivative of the curve. dp/dv is as long as the width that a ray sees. On a flat
//! curve it is perpendicular to the curve and to the ray. On a cylinder it turns about the curve,
//! by -90 to 90 degrees as v goes from 0 to 1. On a ribbon it is perpendicular to the curve and to
//! the ribbon's normal. The normal is the product of the two.

use std::f64::consts::PI;

use glam::{DVec3, Vec2, Vec3};

use super::set::{CubicPoints, CurveKind, CurveSet};
use crate::geometry::RayPoint;
use crate::geometry::surface_point::{SurfaceDerivatives, SurfacePoint};
use petzval_base::rays::Hit;

/// Derivatives and width at a hit.
struct CurveFrame {
    du: DVec3,
    dv: DVec3,
    width: f64,
}

impl CurveSet {
    /// Returns the point of the surface at a hit: the point of the ray, as in pbrt-v4. Its error is
    /// the width, so that no ray that leaves the curve hits it again at once.
    pub fn point(&self, hit: &Hit, near: &RayPoint) -> SurfacePoint {
        let CurveFrame { du, dv, width } = self.frame(hit, near.direction);
        let normal = du.cross(dv).try_normalize().unwrap_or_else(|| du.any_orthonormal_vector());
        let normal = if self.is_flipped() { -normal } else { normal }.as_vec3();
        SurfacePoint {
            position: near.position.as_vec3(),
            error: Vec3::splat(width as f32),
            normal,
            shading_normal: normal,
        }
    }

    /// Returns the texture coordinates at a hit, and the derivatives with respect to them. Those of
    /// the normal are 0, as in pbrt-v4.
    pub fn derivatives(&self, hit: &Hit, near: &RayPoint) -> SurfaceDerivatives {
        let CurveFrame { du, dv, .. } = self.frame(hit, near.direction);
        let dp = [du, dv].map(|d| d.as_vec3());
        SurfaceDerivatives { uv: Vec2::new(hit.u, hit.v), dp, dn: [Vec3::ZERO; 2] }
    }

    fn frame(&self, hit: &Hit, direction: DVec3) -> CurveFrame {
        let (segment, u) = (hit.primitive, f64::from(hit.u));
        let CubicPoints { control, width } = &self.segments()[segment as usize];
        let direction = direction.normalize_or_zero();
        let du = slope(control.map(|p| Vec3::from(p).as_dvec3()), u);
        let width = f64::from(width[0]) * (1.0 - u) + f64::from(width[1]) * u;
        let width = width * self.facing(segment, u, direction);
        let facing = self.ribbon_normal(segment, u).unwrap_or(direction);
        let along = du.normalize();
        let any = || along.any_orthonormal_vector();
        let across = facing.cross(along).try_normalize().unwrap_or_else(any);
        let across = match self.kind() {
            CurveKind::Flat | CurveKind::Ribbon => across,
            CurveKind::Cylinder => {
                let (sin, cos) = (PI * (f64::from(hit.v) - 0.5)).sin_cos();
                across * cos - along.cross(across) * sin
            }
        };
        CurveFrame { du, dv: across * width, width }
    }
}

/// Returns the derivative of a segment, or its chord or any vector where the derivative is 0.
fn slope([a, b, c, d]: [DVec3; 4], u: f64) -> DVec3 {
    let slope = 3.0 * (b - a).lerp(c - b, u).lerp((c - b).lerp(d - c, u), u);
    let some = |v: &DVec3| v.length_squared() > 0.0;
    Some(slope).filter(some).or(Some(d - a).filter(some)).unwrap_or(DVec3::X)
}
