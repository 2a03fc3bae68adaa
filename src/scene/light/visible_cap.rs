//! Sampling of spherical lights by the cone of directions that they subtend (Pharr, Jakob &
//! Humphreys, "Physically Based Rendering", 6.2.4; Shirley, Wang & Zimmerman 1996), lane by lane.

use std::f64::consts::TAU;

use crate::geometry::{Sphere, SurfacePacket, gamma};
use petzval_base::lanes::Real;
use petzval_base::lanes::angle::sin_versine;
use petzval_base::lanes::vector::{
    abs, add, dot, max_component, orthonormal_pair, scale, scale_add, sub,
};

/// A whole sphere in every lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpherePacket<R> {
    pub(super) centre: [R; 3],
    pub(super) radius: R,
    /// 1 if the normals point outwards, -1 if they point inwards.
    pub(super) side: R,
}

impl From<&Sphere> for SpherePacket<f32> {
    fn from(sphere: &Sphere) -> Self {
        Self {
            centre: sphere.centre.as_vec3().to_array(),
            radius: sphere.radius as f32,
            side: sphere.side as f32,
        }
    }
}

/// The parts of spheres that are visible from points.
pub(super) struct VisibleCap<R: Real> {
    sphere: SpherePacket<R>,
    /// Unit vector from the centre of the sphere to the point.
    towards: [R; 3],
    /// Squared sine of the half angle that the sphere subtends.
    sin2: R,
    /// Squared cosine of that angle, without cancellation near the sphere.
    cos2: R,
    /// 1 - cosine of that angle, without cancellation.
    versine: R,
    /// Lanes whose point is outside of the sphere. A point inside or, to rounding, on the sphere
    /// may see its inside.
    pub(super) outside: R::Mask,
}

impl<R: Real<Scalar = f32>> VisibleCap<R> {
    /// The parts of spheres that are visible from points.
    #[inline(always)]
    pub(super) fn new(sphere: &SpherePacket<R>, from: [R; 3]) -> Self {
        let one = R::splat(1.0);
        let away = sub(from, sphere.centre);
        let distance = dot(away, away).sqrt();
        let sin = sphere.radius / distance;
        let sin2 = sin * sin;
        let size = max_component(abs(from)).max(max_component(abs(sphere.centre)));
        let slack = R::splat(16.0 * f32::EPSILON) * size;
        let (beyond, sum) = (distance - sphere.radius, distance + sphere.radius);
        let cos2 = (beyond * sum / (distance * distance)).max(R::splat(0.0));
        let versine = sin2 / (one + cos2.sqrt());
        let outside = (sphere.radius + slack).lt(distance)
            & distance.lt(R::splat(f32::INFINITY))
            & R::splat(f32::MIN_POSITIVE).lt(versine);
        Self { sphere: *sphere, towards: scale(away, one / distance), sin2, cos2, versine, outside }
    }

    /// Returns the density of [`Self::sample`] (1/sr), which is constant over the cap.
    #[inline(always)]
    pub(super) fn density(&self) -> R {
        R::splat(1.0) / (R::constant(TAU) * self.versine)
    }

    /// Samples points of the spheres, uniformly by solid angle.
    #[inline(always)]
    pub(super) fn sample(&self, u: [R; 2]) -> SurfacePacket<R> {
        let one = R::splat(1.0);
        let SpherePacket { centre, radius, side } = self.sphere;
        let versine = u[0] * self.versine;
        let cos = one - versine;
        let sin2 = versine * (one + cos);
        // The angle at the centre between the observer and the sampled point, from the two other
        // angles of the triangle: without a difference of distances, which would cancel for a
        // distant sphere.
        let ratio = (sin2 / self.sin2).min(one);
        let cos_centre = sin2 / self.sin2.sqrt() + cos * (one - ratio).sqrt();
        // By the law of sines, and without the difference of two roots.
        let root = (self.sin2 * (one - ratio)).sqrt();
        let sin_centre = ratio.sqrt() * self.cos2 / (cos + root);
        let [x, y] = orthonormal_pair(self.towards);
        let [sin_phi, versine_phi] = sin_versine(u[1] * R::constant(TAU));
        let cos_phi = one - versine_phi;
        let around = scale_add(x, cos_phi, scale(y, sin_phi));
        let normal = scale_add(around, sin_centre, scale(self.towards, cos_centre));
        let position = scale_add(normal, radius, centre);
        let error = scale(add(abs(centre), [radius; 3]), R::splat(gamma(16)));
        let normal = scale(normal, side);
        SurfacePacket { position, error, normal, shading_normal: normal }
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use petzval_base::lanes::f32x8;

    /// A sphere, and points from near its surface to far away.
    fn caps() -> impl Iterator<Item = (SpherePacket<f32>, [f32; 3])> {
        let sphere = SpherePacket { centre: [0.25, -0.5, 0.75], radius: 2.0, side: 1.0 };
        let along = DVec3::new(0.36, 0.48, 0.8);
        [1e-5, 1e-4, 1e-3, 0.01, 0.3, 2.0, 40.0, 1e4].into_iter().map(move |height| {
            let centre = DVec3::new(0.25, -0.5, 0.75);
            (sphere, (centre + along * (2.0 * (1.0 + height))).as_vec3().to_array())
        })
    }

    #[test]
    fn the_versine_of_a_sample_is_the_fraction_u_of_the_cap() {
        for (sphere, from) in caps() {
            let cap = VisibleCap::new(&sphere, from);
            if !cap.outside {
                continue;
            }
            let exact = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
            let (from, centre) = (exact(from), exact(sphere.centre));
            let distance = from.distance(centre);
            let sin2 = (2.0 / distance).powi(2);
            let whole = sin2 / (1.0 + (1.0 - sin2).max(0.0).sqrt());
            assert!((f64::from(cap.versine) / whole - 1.0).abs() < 2e-3, "{distance}");
            for u in [0.01f32, 0.1, 0.5, 0.9, 0.99] {
                let point = exact(cap.sample([u, 0.3]).position);
                assert!((point.distance(centre) - 2.0).abs() < 4e-6, "{distance} {u}");
                let cos = (point - from).normalize().dot((centre - from).normalize());
                let fraction = (1.0 - cos) / whole;
                // Rounding of the position moves a near point by a large angle.
                let near = 4e-7 / (distance - 2.0) + 4e-7 * distance / whole.sqrt();
                let off = (fraction - f64::from(u)).abs();
                assert!(off < 3e-3 + near, "{distance} {u}: {fraction}");
            }
        }
    }

    #[test]
    fn eight_caps_equal_single_ones() {
        for (sphere, from) in caps() {
            let one = VisibleCap::new(&sphere, from).sample([0.4, 0.9]);
            let packet = SpherePacket {
                centre: sphere.centre.map(f32x8::splat),
                radius: f32x8::splat(sphere.radius),
                side: f32x8::splat(sphere.side),
            };
            let eight = VisibleCap::new(&packet, from.map(f32x8::splat));
            let eight = eight.sample([f32x8::splat(0.4), f32x8::splat(0.9)]);
            let bits = |v: f32| v.to_bits();
            let lane = |v: [f32x8; 3]| v.map(|v| bits(v.to_array()[6]));
            assert_eq!(lane(eight.position), one.position.map(bits));
            assert_eq!(lane(eight.normal), one.normal.map(bits));
        }
    }
}
