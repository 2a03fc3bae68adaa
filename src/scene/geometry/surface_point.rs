//! Surface point with a bound on its rounding error, surface derivatives, and origins of rays that
//! leave a surface.

use glam::{Affine3A, Vec2, Vec3};

use super::surface_packet::SurfacePacket;

/// Returns the bound on the relative error of n roundings: n e / (1 - n e), e = 2^-24
/// (Higham 2002, Lemma 3.1).
pub const fn gamma(n: u32) -> f32 {
    let e = n as f32 * (f32::EPSILON / 2.0);
    e / (1.0 - e)
}

/// A point of a surface.
#[derive(Clone, Copy, Debug, Default)]
pub struct SurfacePoint {
    /// Position.
    pub position: Vec3,
    /// Bound on the error of the position, by axis, including one more rounding of it.
    pub error: Vec3,
    /// Unit geometric normal, on the side that the scene file defines as outside.
    pub normal: Vec3,
    /// Unit shading normal.
    pub shading_normal: Vec3,
}

/// Texture coordinates at a point of a surface, and the derivatives with respect to them.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SurfaceDerivatives {
    /// Texture coordinates.
    pub uv: Vec2,
    /// Derivatives of the position with respect to u and v.
    pub dp: [Vec3; 2],
    /// Derivatives of the unit shading normal with respect to u and v.
    pub dn: [Vec3; 2],
}

impl SurfaceDerivatives {
    /// Transforms the derivatives from object space to world space, given the matrix and its
    /// inverse. `normal` is the unit shading normal in object space.
    pub fn transform(&self, matrix: &Affine3A, inverse: &Affine3A, normal: Vec3) -> Self {
        let inverse = inverse.matrix3.transpose();
        // The normal stays of unit length, so its derivatives are perpendicular to it.
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
    /// Returns the origin of a ray that leaves in a direction: outside the error box of the point,
    /// on the side of the direction (Pharr, Jakob & Humphreys, "Physically Based Rendering",
    /// 6.8.6). [`Self::error`] includes the rounding of the sum.
    pub fn offset_origin(&self, direction: Vec3) -> Vec3 {
        SurfacePacket::from(*self).offset_origin(direction.into()).into()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn transformed_normal_derivatives_are_those_of_the_transformed_shape() {
        // A sphere of radius 1 scaled to radius 3: a step in u turns the normal by the same angle.
        let patch = SurfaceDerivatives {
            dp: [Vec3::X, Vec3::Y],
            dn: [Vec3::X, Vec3::Y],
            ..SurfaceDerivatives::default()
        };
        let grown = Affine3A::from_scale(Vec3::splat(3.0));
        assert_eq!(patch.transform(&grown, &grown.inverse(), Vec3::Z).dn, patch.dn);
        assert_eq!(
            patch.transform(&grown, &grown.inverse(), Vec3::Z).dp,
            [Vec3::X * 3.0, Vec3::Y * 3.0]
        );
        // An ellipsoid three times as tall: z = 3 - 1.5 r^2 at its pole.
        let tall = Affine3A::from_scale(Vec3::new(1.0, 1.0, 3.0));
        let [du, _] = patch.transform(&tall, &tall.inverse(), Vec3::Z).dn;
        assert!((du - Vec3::X * 3.0).length() < 1e-6, "{du}");
    }
}
