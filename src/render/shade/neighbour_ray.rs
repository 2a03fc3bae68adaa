//! Rays of neighbouring samples: their intersection with a surface, and their reflection and
//! refraction.

use glam::Vec3;

use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{add, clear, dot, scale_add, select, splat};
use petzval_base::rays::{Ray, RayDifferential};
use petzval_scene::{SurfaceDerivativesPacket, SurfacePacket};

/// Ray of a neighbouring sample, at the distance at which a sample's own ray hits a surface, in
/// every lane.
#[derive(Clone, Copy, Debug)]
pub(super) struct NeighbourRay<R = f32> {
    /// Position relative to the own ray's hit point.
    pub(super) offset: [R; 3],
    /// Direction, of any length.
    pub(super) direction: [R; 3],
    /// Direction minus that of the own ray, at the same length.
    pub(super) direction_change: [R; 3],
}

/// Specular reflection or refraction of a ray.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpecularBounce {
    /// Unit shading normal, on either side of the surface.
    pub(super) normal: Vec3,
    /// Unit direction after the surface.
    pub(super) next: Vec3,
    /// Squared refractive index beyond the surface over that before it, for refraction.
    pub(super) eta2: f32,
}

impl<R: Real<Scalar = f32>> NeighbourRay<R> {
    /// Returns the intersection with the tangent plane of the surface, relative to the own ray's
    /// hit point; infinite if there is none. `normal` is the geometric one.
    #[inline(always)]
    pub(super) fn tangent_plane_offset(&self, normal: [R; 3]) -> [R; 3] {
        let distance = dot(normal, self.offset) / dot(normal, self.direction);
        scale_add(self.direction, -distance, self.offset)
    }

    /// Returns the change of (u, v) from the own ray's hit point to this ray's; 0 if it misses the
    /// tangent plane. `normal` is the geometric one, `dp` the derivatives of the position.
    #[inline(always)]
    pub(super) fn texture_step(&self, normal: [R; 3], dp: &[[R; 3]; 2]) -> [R; 2] {
        let [du, dv] = *dp;
        let offset = self.tangent_plane_offset(normal);
        // Least squares in the plane of the surface.
        let (uu, uv, vv) = (dot(du, du), dot(du, dv), dot(dv, dv));
        let determinant = uu * vv - uv * uv;
        let (u, v) = (dot(offset, du), dot(offset, dv));
        let slopes = [(u * vv - v * uv) / determinant, (v * uu - u * uv) / determinant];
        let infinity = R::splat(f32::INFINITY);
        [
            clear(slopes[0], slopes[0].abs().lt(infinity)),
            clear(slopes[1], slopes[1].abs().lt(infinity)),
        ]
    }

    /// Returns `known` in the lanes of a mask, and this ray elsewhere.
    #[inline(always)]
    pub(super) fn or(&self, mask: R::Mask, known: &Self) -> Self {
        Self {
            offset: select(mask, known.offset, self.offset),
            direction: select(mask, known.direction, self.direction),
            direction_change: select(mask, known.direction_change, self.direction_change),
        }
    }
}

impl NeighbourRay {
    /// No ray.
    pub(super) const NONE: Self =
        Self { offset: [0.0; 3], direction: [0.0; 3], direction_change: [0.0; 3] };

    /// Returns the ray in every lane.
    pub(super) fn splat<R: Real<Scalar = f32>>(&self) -> NeighbourRay<R> {
        NeighbourRay {
            offset: splat(self.offset),
            direction: splat(self.direction),
            direction_change: splat(self.direction_change),
        }
    }

    /// Returns the neighbours of a ray that hits a surface at `t`, or `None` if its differential is
    /// unknown.
    pub(super) fn transferred(
        ray: &Ray,
        t: f32,
        differential: &RayDifferential,
    ) -> Option<[Self; 2]> {
        let neighbour = |axis: usize| {
            let direction_change = differential.direction[axis];
            Self {
                offset: scale_add(direction_change, t, differential.origin[axis]),
                direction: add(ray.direction, direction_change),
                direction_change,
            }
        };
        (*differential != RayDifferential::UNKNOWN).then(|| [neighbour(0), neighbour(1)])
    }

    /// Returns the origin and direction of this ray after a specular bounce, minus those of the own
    /// ray, whose direction before the bounce is `along` (Igehy 1999, eqs. 14 to 18).
    pub(super) fn after_bounce(
        &self,
        along: Vec3,
        point: &SurfacePacket<f32>,
        patch: &SurfaceDerivativesPacket<f32>,
        bounce: &SpecularBounce,
    ) -> [Vec3; 2] {
        let SpecularBounce { normal, next, eta2 } = *bounce;
        let [u, v] = self.texture_step(point.normal, &patch.dp);
        let [du, dv] = patch.dn.map(Vec3::from);
        let normal_change = du * u + dv * v;
        let cos = along.dot(normal);
        let direction = Vec3::from(self.direction);
        let change = direction.normalize_or_zero()
            - (direction - Vec3::from(self.direction_change)).normalize_or_zero();
        let cos_change = change.dot(normal) + along.dot(normal_change);
        // next = ratio * along + share * normal; ratio is constant, all else changes.
        let (ratio, share, share_change) = if cos * next.dot(normal) < 0.0 {
            (1.0, -2.0 * cos, -2.0 * cos_change)
        } else {
            let cos_next = next.dot(normal);
            let ratio = 1.0 / eta2.sqrt();
            let cos_next_change = cos * cos_change / (eta2 * cos_next);
            (ratio, cos_next - ratio * cos, cos_next_change - ratio * cos_change)
        };
        [
            self.tangent_plane_offset(point.normal).into(),
            change * ratio + normal_change * share + normal * share_change,
        ]
    }
}
