//! Triangles with the vertex data that shading needs, one per lane.

use super::mesh::Mesh;
use super::surface_packet::{SurfaceDerivativesPacket, SurfacePacket};
use super::surface_point::gamma;
use petzval_base::lanes::Real;
use petzval_base::lanes::vector::{
    abs, add, clear, cross, dot, normalize, orthonormal_pair, scale, select, sub,
};

/// Vertex data of a triangle in every lane, in the space of its object.
#[derive(Clone, Copy, Debug)]
pub struct ShadingTriangle<R> {
    /// Positions by vertex.
    pub positions: [[R; 3]; 3],
    /// Unit shading normals by vertex; 0 if the mesh has none.
    pub normals: [[R; 3]; 3],
    /// Texture coordinates by vertex.
    pub uvs: [[R; 2]; 3],
    /// -1 if the normal is opposite to the winding, otherwise 1.
    pub side: R,
}

impl<R: Real<Scalar = f32>> ShadingTriangle<R> {
    /// Returns the surface point of barycentric weights `u` and `v` of the second and the third
    /// vertex.
    #[inline(always)]
    pub fn point(&self, u: R, v: R) -> SurfacePacket<R> {
        let [a, b, c] = self.positions;
        let w = R::splat(1.0) - u - v;
        let (aw, bu, cv) = (scale(a, w), scale(b, u), scale(c, v));
        let position = add(add(aw, bu), cv);
        let error = scale(add(add(abs(aw), abs(bu)), abs(cv)), R::splat(gamma(8)));
        let (flat, _) = normalize(cross(sub(b, a), sub(c, a)));
        let [na, nb, nc] = self.normals;
        let shading = add(add(scale(na, w), scale(nb, u)), scale(nc, v));
        SurfacePacket::oriented(position, error, flat, shading, self.side)
    }

    /// Returns the texture coordinates at the point of [`Self::point`], and the derivatives with
    /// respect to them.
    #[inline(always)]
    pub fn derivatives(&self, u: R, v: R) -> SurfaceDerivativesPacket<R> {
        let w = R::splat(1.0) - u - v;
        let [a, b, c] = self.uvs;
        let uv = [a[0] * w + b[0] * u + c[0] * v, a[1] * w + b[1] * u + c[1] * v];
        // Positions and normals are linear in u and v: solve for the derivatives by two edges.
        let (one, other) = ([a[0] - c[0], a[1] - c[1]], [b[0] - c[0], b[1] - c[1]]);
        let inverse = R::splat(1.0) / (one[0] * other[1] - one[1] * other[0]);
        let solve = Slopes { one, other, inverse };
        let [du, dv] = solve.of(&self.positions);
        let [p, q, r] = self.positions;
        // Degenerate texture coordinates: any two directions in the plane.
        let spread = cross(du, dv);
        let area2 = dot(spread, spread);
        let infinity = R::splat(f32::INFINITY);
        let regular =
            R::splat(f32::MIN_POSITIVE).le(area2) & area2.lt(infinity) & dot(du, du).lt(infinity);
        let (flat, some) = normalize(cross(sub(q, p), sub(r, p)));
        let (zero, unit) = (R::splat(0.0), R::splat(1.0));
        let flat = select(some, flat, [zero, zero, unit]);
        let [x, y] = orthonormal_pair(flat);
        let dn = solve.of(&self.normals);
        let clear3 = |n: [R; 3]| [clear(n[0], regular), clear(n[1], regular), clear(n[2], regular)];
        SurfaceDerivativesPacket {
            uv,
            dp: [select(regular, du, x), select(regular, dv, y)],
            dn: [clear3(dn[0]), clear3(dn[1])],
        }
    }
}

/// Solution of two linear equations for the derivatives by u and v.
struct Slopes<R> {
    /// Texture coordinates of the first vertex minus those of the third.
    one: [R; 2],
    /// Texture coordinates of the second vertex minus those of the third.
    other: [R; 2],
    /// Inverse of the determinant.
    inverse: R,
}

impl<R: Real> Slopes<R> {
    /// Returns the derivatives of a quantity that is given at the vertices.
    #[inline(always)]
    fn of(&self, values: &[[R; 3]; 3]) -> [[R; 3]; 2] {
        let (d, e) = (sub(values[0], values[2]), sub(values[1], values[2]));
        let Self { one, other, inverse } = *self;
        [
            scale(sub(scale(d, other[1]), scale(e, one[1])), inverse),
            scale(sub(scale(e, one[0]), scale(d, other[0])), inverse),
        ]
    }
}

/// Triangles of up to eight lanes, while they are gathered.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub struct TriangleLanes {
    positions: [[[f32; 8]; 3]; 3],
    normals: [[[f32; 8]; 3]; 3],
    uvs: [[[f32; 8]; 2]; 3],
    side: [f32; 8],
}

impl Default for TriangleLanes {
    fn default() -> Self {
        Self {
            positions: [[[0.0; 8]; 3]; 3],
            normals: [[[0.0; 8]; 3]; 3],
            uvs: [[[0.0; 8]; 2]; 3],
            side: [1.0; 8],
        }
    }
}

impl TriangleLanes {
    /// Gathers the triangles of the lanes that have a mesh, each with the index of its triangle; `uvs` says
    /// whether texture coordinates are needed.
    ///
    /// Every kind of data is gathered for all lanes before the next kind, so that the lanes wait for
    /// memory together.
    #[inline(always)]
    pub fn gather(&mut self, meshes: &[Option<(&Mesh, u32)>; 8], uvs: bool) {
        let mut corners = [[0; 3]; 8];
        for (lane, mesh) in meshes.iter().enumerate() {
            if let Some((mesh, index)) = mesh {
                corners[lane] = mesh.triangles[*index as usize];
            }
        }
        for (lane, mesh) in meshes.iter().enumerate() {
            if let Some((mesh, _)) = mesh {
                set_lane(&mut self.positions, lane, &mesh.positions_of(corners[lane]));
                self.side[lane] = mesh.side();
            }
        }
        for (lane, mesh) in meshes.iter().enumerate() {
            if let Some((mesh, _)) = mesh {
                set_lane(&mut self.normals, lane, &mesh.normals_of(corners[lane]));
            }
        }
        if !uvs {
            return;
        }
        for (lane, mesh) in meshes.iter().enumerate() {
            if let Some((mesh, index)) = mesh {
                set_lane(&mut self.uvs, lane, &mesh.uvs_of(*index, corners[lane]));
            }
        }
    }

    /// Returns the triangles of all lanes.
    #[inline(always)]
    pub fn load<R: Real<Scalar = f32>>(&self) -> ShadingTriangle<R> {
        let zero = R::splat(0.0);
        let mut triangle = ShadingTriangle {
            positions: [[zero; 3]; 3],
            normals: [[zero; 3]; 3],
            uvs: [[zero; 2]; 3],
            side: R::load(&self.side),
        };
        for vertex in 0..3 {
            for axis in 0..3 {
                triangle.positions[vertex][axis] = R::load(&self.positions[vertex][axis]);
                triangle.normals[vertex][axis] = R::load(&self.normals[vertex][axis]);
            }
            for axis in 0..2 {
                triangle.uvs[vertex][axis] = R::load(&self.uvs[vertex][axis]);
            }
        }
        triangle
    }
}

/// Sets the vectors of the three vertices in a lane.
#[inline(always)]
fn set_lane<const N: usize>(lanes: &mut [[[f32; 8]; N]; 3], lane: usize, vectors: &[[f32; N]; 3]) {
    for (lanes, vector) in lanes.iter_mut().zip(vectors) {
        for (axis, &value) in lanes.iter_mut().zip(vector) {
            axis[lane] = value;
        }
    }
}
