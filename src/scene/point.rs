//! Points of surfaces, how exactly they are known, and rays that leave them.

use glam::{Affine3A, Vec2, Vec3};

/// The bound on the relative error of n roundings: n e / (1 - n e), e = 2^-24
/// (Higham 2002, Lemma 3.1).
pub const fn gamma(n: u32) -> f32 {
    let e = n as f32 * (f32::EPSILON / 2.0);
    e / (1.0 - e)
}

/// Where a ray met a surface.
#[derive(Clone, Copy, Debug, Default)]
pub struct SurfacePoint {
    /// Position.
    pub position: Vec3,
    /// Bound on the error of the position, by axis, with room for one more rounding of it.
    pub error: Vec3,
    /// Unit normal of the surface itself, on the side the scene file calls outside.
    pub normal: Vec3,
    /// Unit normal for shading.
    pub shading: Vec3,
}

/// How a surface is laid out in texture coordinates about a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Patch {
    /// Texture coordinates.
    pub uv: Vec2,
    /// Change of the position with u and with v.
    pub dp: [Vec3; 2],
    /// Change of the unit shading normal with u and with v.
    pub dn: [Vec3; 2],
}

impl Patch {
    /// The same patch in the space outside an instance; `normal` is the unit shading normal inside.
    pub fn transform(&self, matrix: &Affine3A, normal: Vec3) -> Self {
        let inverse = matrix.matrix3.inverse().transpose();
        // The normal outside is of unit length again, and so changes across itself only.
        let outside = inverse * normal;
        let (length, unit) = (outside.length(), outside.normalize_or_zero());
        let across = |d: Vec3| {
            let change = inverse * d / length;
            change - unit * unit.dot(change)
        };
        Self { uv: self.uv, dp: self.dp.map(|d| matrix.matrix3 * d), dn: self.dn.map(across) }
    }
}

impl SurfacePoint {
    /// The same point in the space outside an instance.
    pub fn transform(&self, matrix: &Affine3A) -> Self {
        let m = matrix.matrix3;
        let inverse = m.inverse().transpose();
        let magnitude = |v: Vec3| {
            let v = v.abs();
            Vec3::from(m.x_axis.abs() * v.x + m.y_axis.abs() * v.y + m.z_axis.abs() * v.z)
        };
        let error = magnitude(self.error) * (1.0 + gamma(3))
            + (magnitude(self.position) + Vec3::from(matrix.translation.abs())) * gamma(4);
        Self {
            position: matrix.transform_point3(self.position),
            error,
            normal: (inverse * self.normal).normalize(),
            shading: (inverse * self.shading).normalize(),
        }
    }

    /// The origin of a ray that leaves in a direction: outside the box in which the true
    /// point lies, on the right side (Pharr, Jakob & Humphreys, "Physically Based
    /// Rendering", 6.8.6). The rounding of the sum is within the box: see [`Self::error`].
    pub fn leave(&self, direction: Vec3) -> Vec3 {
        let reach = self.normal.abs().dot(self.error);
        self.position + self.normal * reach.copysign(direction.dot(self.normal))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_normals_of_an_instance_turn_as_those_of_the_shape_that_it_is() {
        // A ball of radius 1 that is made one of radius 3: normals turn as much for a step in u.
        let patch = Patch { dp: [Vec3::X, Vec3::Y], dn: [Vec3::X, Vec3::Y], ..Patch::default() };
        let grown = Affine3A::from_scale(Vec3::splat(3.0));
        assert_eq!(patch.transform(&grown, Vec3::Z).dn, patch.dn);
        assert_eq!(patch.transform(&grown, Vec3::Z).dp, [Vec3::X * 3.0, Vec3::Y * 3.0]);
        // An ellipsoid three times as tall: z = 3 - 1.5 r^2 at its pole.
        let tall = Affine3A::from_scale(Vec3::new(1.0, 1.0, 3.0));
        let [du, _] = patch.transform(&tall, Vec3::Z).dn;
        assert!((du - Vec3::X * 3.0).length() < 1e-6, "{du}");
    }
}
