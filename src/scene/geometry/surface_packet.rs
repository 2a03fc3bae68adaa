//! Surface points and their derivatives, lane by lane.

use glam::{Affine3A, Vec2, Vec3};

use super::surface_point::{SurfaceDerivatives, SurfacePoint, gamma};
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{
    abs, add, dot, normalize, scale, scale_add, select, splat, sub, transform,
};

/// A [`SurfacePoint`] in every lane.
#[derive(Clone, Copy, Debug)]
pub struct SurfacePacket<R> {
    /// Position.
    pub position: [R; 3],
    /// Bound on the error of the position, by axis.
    pub error: [R; 3],
    /// Unit geometric normal.
    pub normal: [R; 3],
    /// Unit shading normal.
    pub shading_normal: [R; 3],
}

/// [`SurfaceDerivatives`] in every lane.
#[derive(Clone, Copy, Debug)]
pub struct SurfaceDerivativesPacket<R> {
    /// Texture coordinates.
    pub uv: [R; 2],
    /// Derivatives of the position with respect to u and v.
    pub dp: [[R; 3]; 2],
    /// Derivatives of the unit shading normal with respect to u and v.
    pub dn: [[R; 3]; 2],
}

impl<R: Real<Scalar = f32>> SurfacePacket<R> {
    /// Returns points with a unit normal that may be on either side, and an interpolated shading
    /// normal of any length. The shading normal decides on which side the normal is; where it is 0,
    /// the sign of `side` does.
    #[inline(always)]
    pub(super) fn oriented(
        position: [R; 3],
        error: [R; 3],
        flat: [R; 3],
        shading: [R; 3],
        side: R,
    ) -> Self {
        let (shading, smooth) = normalize(shading);
        let zero = R::splat(0.0);
        let against = R::select(smooth, dot(shading, flat), side).lt(zero);
        let normal = select(against, sub([zero; 3], flat), flat);
        Self { position, error, normal, shading_normal: select(smooth, shading, normal) }
    }

    /// Transforms the points from object space to world space, given the matrix and its inverse.
    #[inline(always)]
    pub fn transform(&self, matrix: &Affine3A, inverse: &Affine3A) -> Self {
        let columns = matrix.matrix3.to_cols_array_2d();
        let sizes = columns.map(|column| splat(column.map(f32::abs)));
        let (columns, moved) = (columns.map(splat), matrix.translation.to_array());
        let normals = inverse.matrix3.transpose().to_cols_array_2d().map(splat);
        let size = add(transform(&sizes, abs(self.position)), splat(moved.map(f32::abs)));
        let error = scale(transform(&sizes, self.error), R::splat(1.0 + gamma(3)));
        Self {
            position: add(transform(&columns, self.position), splat(moved)),
            error: scale_add(size, R::splat(gamma(4)), error),
            normal: normalize(transform(&normals, self.normal)).0,
            shading_normal: normalize(transform(&normals, self.shading_normal)).0,
        }
    }

    /// Returns the origin of a ray that leaves in a direction; see
    /// [`SurfacePoint::offset_origin`].
    #[inline(always)]
    pub fn offset_origin(&self, direction: [R; 3]) -> [R; 3] {
        let reach = dot(abs(self.normal), self.error);
        let below = dot(direction, self.normal).lt(R::splat(0.0));
        scale_add(self.normal, R::select(below, -reach, reach), self.position)
    }
}

impl From<SurfacePacket<f32>> for SurfacePoint {
    fn from(packet: SurfacePacket<f32>) -> Self {
        Self {
            position: packet.position.into(),
            error: packet.error.into(),
            normal: packet.normal.into(),
            shading_normal: packet.shading_normal.into(),
        }
    }
}

impl From<SurfacePoint> for SurfacePacket<f32> {
    fn from(point: SurfacePoint) -> Self {
        Self {
            position: point.position.into(),
            error: point.error.into(),
            normal: point.normal.into(),
            shading_normal: point.shading_normal.into(),
        }
    }
}

impl From<SurfaceDerivativesPacket<f32>> for SurfaceDerivatives {
    fn from(packet: SurfaceDerivativesPacket<f32>) -> Self {
        Self {
            uv: Vec2::from(packet.uv),
            dp: packet.dp.map(Vec3::from),
            dn: packet.dn.map(Vec3::from),
        }
    }
}

impl From<SurfaceDerivatives> for SurfaceDerivativesPacket<f32> {
    fn from(derivatives: SurfaceDerivatives) -> Self {
        Self {
            uv: derivatives.uv.into(),
            dp: derivatives.dp.map(Into::into),
            dn: derivatives.dn.map(Into::into),
        }
    }
}
