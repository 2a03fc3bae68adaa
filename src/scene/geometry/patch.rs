//! Bilinear patches with the vertex data that shading needs, one per lane.
//!
//! The corners of a patch are at (u, v) = (0, 0), (1, 0), (0, 1) and (1, 1).

use super::surface_packet::{SurfaceDerivativesPacket, SurfacePacket};
use super::surface_point::gamma;
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{abs, add, cross, dot, negate, normalize, scale, select, sub};

/// Vertex data of a patch in every lane, in the space of its object.
#[derive(Clone, Copy, Debug)]
pub struct ShadingPatch<R> {
    /// Positions by corner.
    pub positions: [[R; 3]; 4],
    /// Unit shading normals by corner; 0 if there are none.
    pub normals: [[R; 3]; 4],
    /// Texture coordinates by corner.
    pub uvs: [[R; 2]; 4],
    /// -1 if the normal is opposite to the product of the derivatives, otherwise 1.
    pub side: R,
}

/// Returns (1 - s) a + s b.
#[inline(always)]
fn mix<R: Real>(a: [R; 3], b: [R; 3], s: R) -> [R; 3] {
    add(scale(a, R::constant(1.0) - s), scale(b, s))
}

/// Returns the derivatives by u and v of a quantity that is given at the corners.
#[inline(always)]
fn slopes<R: Real>([a, b, c, d]: &[[R; 3]; 4], u: R, v: R) -> [[R; 3]; 2] {
    [mix(sub(*b, *a), sub(*d, *c), v), mix(sub(*c, *a), sub(*d, *b), u)]
}

impl<R: Real<Scalar = f32>> ShadingPatch<R> {
    /// Returns the surface point at `u` and `v`, both from 0 to 1.
    #[inline(always)]
    pub fn point(&self, u: R, v: R) -> SurfacePacket<R> {
        let one = R::splat(1.0);
        let weights = [(one - u) * (one - v), u * (one - v), (one - u) * v, u * v];
        let (mut position, mut size, mut shading) =
            ([R::splat(0.0); 3], [R::splat(0.0); 3], [R::splat(0.0); 3]);
        for corner in 0..4 {
            let term = scale(self.positions[corner], weights[corner]);
            position = add(position, term);
            size = add(size, abs(term));
            shading = add(shading, scale(self.normals[corner], weights[corner]));
        }
        let error = scale(size, R::splat(gamma(10)));
        SurfacePacket::oriented(position, error, self.flat_normal(u, v), shading, self.side)
    }

    /// Returns the unit product of the derivatives, or that of the diagonals where it is 0, as at
    /// two corners in one place.
    #[inline(always)]
    fn flat_normal(&self, u: R, v: R) -> [R; 3] {
        let [a, b, c, d] = self.positions;
        let [du, dv] = slopes(&self.positions, u, v);
        let (flat, regular) = normalize(cross(du, dv));
        let (diagonal, _) = normalize(cross(sub(d, a), sub(c, b)));
        select(regular, flat, diagonal)
    }

    /// Returns the texture coordinates at the point of [`Self::point`], and the derivatives with
    /// respect to them.
    #[inline(always)]
    pub fn derivatives(&self, u: R, v: R) -> SurfaceDerivativesPacket<R> {
        let (zero, one) = (R::splat(0.0), R::splat(1.0));
        let texture = self.uvs.map(|[s, t]| [s, t, zero]);
        let [a, b, c, d] = texture;
        let st = mix(mix(a, b, u), mix(c, d, u), v);
        let [[su, tu, _], [sv, tv, _]] = slopes(&texture, u, v);
        let inverse = one / (su * tv - sv * tu);
        let regular = inverse.abs().lt(R::splat(f32::INFINITY));
        // By the chain rule; by u and v themselves where the texture coordinates do not span.
        let by_texture = |[du, dv]: [[R; 3]; 2]| {
            let ds = scale(sub(scale(du, tv), scale(dv, tu)), inverse);
            let dt = scale(sub(scale(dv, su), scale(du, sv)), inverse);
            [select(regular, ds, du), select(regular, dt, dv)]
        };
        let dp = slopes(&self.positions, u, v);
        let normal = self.point(u, v).shading_normal;
        SurfaceDerivativesPacket {
            uv: [st[0], st[1]],
            dp: by_texture(dp),
            dn: by_texture(self.normal_slopes(dp, normal, u, v)),
        }
    }

    /// Returns the derivatives of the unit shading normal by u and v.
    #[inline(always)]
    fn normal_slopes(&self, [du, dv]: [[R; 3]; 2], normal: [R; 3], u: R, v: R) -> [[R; 3]; 2] {
        let zero = R::splat(0.0);
        let [a, b, c, d] = self.normals;
        let smooth = zero.lt(dot(a, a) + dot(b, b) + dot(c, c) + dot(d, d));
        // Without vertex normals: of the product of the derivatives, whose own derivatives are
        // those of p_uv, the only second derivative that is not 0.
        let [p, q, r, s] = self.positions;
        let twist = add(sub(p, q), sub(s, r));
        let product = cross(du, dv);
        let inverse = R::splat(1.0) / dot(product, product).sqrt();
        let inverse = R::select(inverse.lt(R::splat(f32::INFINITY)), inverse, zero);
        let inverse = R::select(dot(product, normal).lt(zero), -inverse, inverse);
        let across = |change: [R; 3]| {
            let change = scale(change, inverse);
            sub(change, scale(normal, dot(normal, change)))
        };
        let own = [across(cross(du, twist)), across(negate(cross(dv, twist)))];
        let [nu, nv] = slopes(&self.normals, u, v);
        [select(smooth, nu, own[0]), select(smooth, nv, own[1])]
    }
}

#[cfg(test)]
mod tests {
    use glam::Vec3;

    use super::*;

    /// A twisted patch. Its texture coordinates are turned and stretched.
    fn twisted() -> ShadingPatch<f32> {
        ShadingPatch {
            positions: [[0.0, 0.0, 0.0], [2.0, 0.1, 0.3], [-0.2, 1.5, 0.8], [1.8, 1.7, -0.4]],
            normals: [[0.0; 3]; 4],
            uvs: [[0.0, 0.0], [0.5, 1.0], [-2.0, 0.5], [-1.3, 1.6]],
            side: 1.0,
        }
    }

    #[test]
    fn derivatives_are_those_of_the_surface() {
        let (patch, [u, v], h) = (twisted(), [0.3, 0.6], 1e-3);
        let found = patch.derivatives(u, v);
        let at = |u: f32, v: f32| {
            let uv = patch.derivatives(u, v).uv;
            let point = patch.point(u, v);
            (Vec3::from(point.position), Vec3::from(point.normal), uv)
        };
        for (u2, v2) in [(u + h, v), (u, v + h)] {
            let ((p, n, st), (p2, n2, st2)) = (at(u, v), at(u2, v2));
            let step = [st2[0] - st[0], st2[1] - st[1]];
            let expected =
                |d: [[f32; 3]; 2]| Vec3::from(d[0]) * step[0] + Vec3::from(d[1]) * step[1];
            assert!((p2 - p - expected(found.dp)).length() < 2e-6, "{:?}", p2 - p);
            assert!((n2 - n - expected(found.dn)).length() < 2e-6, "{:?}", n2 - n);
        }
    }

    #[test]
    fn the_normal_is_on_the_side_of_the_file() {
        let patch = twisted();
        let [du, dv] = slopes(&patch.positions, 0.5, 0.5);
        let outside = Vec3::from(cross(du, dv));
        let normal = |patch: ShadingPatch<f32>| Vec3::from(patch.point(0.5, 0.5).normal);
        assert!(normal(patch).dot(outside) > 0.0);
        assert!(normal(ShadingPatch { side: -1.0, ..patch }).dot(outside) < 0.0);
        let down = (-outside.normalize()).to_array();
        assert!(normal(ShadingPatch { normals: [down; 4], ..patch }).dot(outside) < 0.0);
    }

    #[test]
    fn a_patch_with_two_corners_in_one_place_has_a_normal() {
        let mut patch = twisted();
        patch.positions[1] = patch.positions[0];
        let normal = Vec3::from(patch.point(0.5, 0.0).normal);
        assert!((normal.length() - 1.0).abs() < 1e-6, "{normal}");
    }
}
