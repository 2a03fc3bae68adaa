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
    /// What bumps bend: `dp`, but on meshes with shading normals, as pbrt-v4 has it, the part of
    /// its first vector across the normal, and that vector turned by a right angle.
    pub tangents: [Vec3; 2],
    /// Change of the unit shading normal with u and with v.
    pub dn: [Vec3; 2],
}

impl Patch {
    /// The same patch in the space outside an instance.
    pub fn transform(&self, matrix: &Affine3A) -> Self {
        let inverse = matrix.matrix3.inverse().transpose();
        Self {
            uv: self.uv,
            dp: self.dp.map(|d| matrix.matrix3 * d),
            tangents: self.tangents.map(|d| matrix.matrix3 * d),
            dn: self.dn.map(|d| inverse * d),
        }
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
