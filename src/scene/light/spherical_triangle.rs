//! Sampling of triangles uniformly by solid angle (Arvo 1995, "Stratified sampling of spherical
//! triangles").

use glam::{DVec3, Vec3};

/// Projection of a triangle onto the unit sphere about a point.
pub(super) struct SphericalTriangle {
    /// Corners of the triangle relative to the point.
    corners: [DVec3; 3],
    /// Unit vectors to the corners.
    directions: [DVec3; 3],
    /// Solid angle (sr).
    pub(super) solid_angle: f64,
    /// Six times the volume of the tetrahedron that the unit vectors span.
    volume: f64,
}

/// Least and largest solid angle (sr) that is sampled by solid angle, as in pbrt-v4. Below,
/// sampling by area is as good and cheaper; above, the point is practically on the triangle.
const LIMITS: [f64; 2] = [3e-4, 6.22];

impl SphericalTriangle {
    /// Projects a triangle. Returns `None` if it is better sampled by area.
    pub(super) fn new(corners: [Vec3; 3], from: Vec3) -> Option<Self> {
        let corners = corners.map(|corner| corner.as_dvec3() - from.as_dvec3());
        let lengths = corners.map(DVec3::length);
        let directions = [0, 1, 2].map(|i| corners[i] / lengths[i]);
        let [a, b, c] = directions;
        // Van Oosterom & Strackee 1983, "The solid angle of a plane triangle".
        let volume = a.dot(b.cross(c)).abs();
        let denominator = 1.0 + a.dot(b) + b.dot(c) + c.dot(a);
        if volume <= LIMITS[0] / 2.0 * denominator {
            return None;
        }
        let solid_angle = 2.0 * volume.atan2(denominator);
        let in_limits = solid_angle > LIMITS[0] && solid_angle < LIMITS[1];
        in_limits.then_some(Self { corners, directions, solid_angle, volume })
    }

    /// Samples a point uniformly by solid angle. Returns the barycentric weights of the second and
    /// third corner, or `None` if they are not finite.
    pub(super) fn sample(&self, u: [f32; 2]) -> Option<[f32; 2]> {
        let [a, b, c] = self.directions;
        let [u, v] = u.map(f64::from);
        // Angle of the spherical triangle at a.
        let (ab, ca) = (a.cross(b), c.cross(a));
        let lengths = (ab.length_squared() * ca.length_squared()).sqrt();
        let (cos_a, sin_a) = (-ab.dot(ca) / lengths, self.volume / lengths);
        // A point on the side ac such that the part of the triangle up to it has the fraction u of
        // the area.
        let (sin_area, cos_area) = (u * self.solid_angle).sin_cos();
        let s = sin_area * cos_a - cos_area * sin_a;
        let t = cos_area * cos_a + sin_area * sin_a;
        let p = t - cos_a;
        let q = s + sin_a * a.dot(b);
        let cos_side = ((q * t - p * s) * cos_a - q) / ((q * s + p * t) * sin_a);
        // 0 / 0 if u is 0: the point is a itself.
        let cos_side = if cos_side.is_nan() { 1.0 } else { cos_side.clamp(-1.0, 1.0) };
        let corner = a * cos_side + across(c, a) * (1.0 - cos_side * cos_side).sqrt();
        // A point on the arc from b to that point.
        let versine = v * (1.0 - corner.dot(b));
        let sin = (versine * (2.0 - versine)).max(0.0).sqrt();
        let direction = b * (1.0 - versine) + across(corner, b) * sin;
        self.meet(direction)
    }

    /// Intersects a direction with the plane of the triangle (Möller & Trumbore 1997), and clamps
    /// the weights to the triangle against rounding.
    fn meet(&self, direction: DVec3) -> Option<[f32; 2]> {
        let [a, b, c] = self.corners;
        let (one, other) = (b - a, c - a);
        let normal = direction.cross(other);
        let scale = one.dot(normal);
        let wb = -a.dot(normal) / scale;
        let wc = direction.dot(one.cross(a)) / scale;
        if !(wb.is_finite() && wc.is_finite()) {
            return None;
        }
        let (wb, wc) = (wb.clamp(0.0, 1.0), wc.clamp(0.0, 1.0));
        let excess = (wb + wc).max(1.0);
        Some([wb / excess, wc / excess].map(|w| w as f32))
    }
}

/// Returns the unit vector perpendicular to `from` on the side of `v`; 0 if they are parallel.
fn across(v: DVec3, from: DVec3) -> DVec3 {
    (v - from * v.dot(from)).normalize_or_zero()
}
