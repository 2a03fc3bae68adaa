//! Triangle mesh.

use glam::{DAffine3, DVec3, Vec2, Vec3};

use super::surface_point::{SurfaceDerivatives, SurfacePoint, gamma};
use crate::rays::Hit;

/// Triangles over shared vertices, in the space of the object that they belong to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Indices of three vertices for each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Unit shading normals by vertex; empty if there are none.
    pub normals: Vec<[f32; 3]>,
    /// Texture coordinates by vertex; empty if there are none.
    pub uvs: Vec<[f32; 2]>,
    /// Index of the first triangle of its bilinear patch, by triangle; empty without patches.
    pub patch_starts: Vec<u32>,
    /// Whether the normal is opposite to the winding, by ReverseOrientation or a mirroring
    /// transform.
    pub flipped: bool,
}

impl Mesh {
    /// Transforms the mesh. `reversed` says whether the scene file reverses the orientation; a
    /// mirroring transform also reverses the winding.
    pub fn transform(&mut self, matrix: &DAffine3, reversed: bool) {
        let single = |v: DVec3| v.as_vec3().to_array();
        let double = |v: [f32; 3]| Vec3::from(v).as_dvec3();
        for p in &mut self.positions {
            *p = single(matrix.transform_point3(double(*p)));
        }
        let to_normal = matrix.matrix3.inverse().transpose();
        let sign = if reversed { -1.0 } else { 1.0 };
        for n in &mut self.normals {
            *n = single((to_normal * double(*n)).normalize_or_zero() * sign);
        }
        self.flipped = reversed ^ (matrix.matrix3.determinant() < 0.0);
    }

    /// Removes the triangles that have a vertex that is not finite, together with their whole
    /// patches, and returns their number. Such vertices, normals and texture coordinates become 0.
    pub fn drop_non_finite(&mut self) -> usize {
        let finite = |values: &[f32]| values.iter().all(|v| v.is_finite());
        self.normals.iter_mut().filter(|n| !finite(*n)).for_each(|n| *n = [0.0; 3]);
        self.uvs.iter_mut().filter(|uv| !finite(*uv)).for_each(|uv| *uv = [0.0; 2]);
        let bad: Vec<bool> = self.positions.iter().map(|p| !finite(p)).collect();
        if !bad.contains(&true) {
            return 0;
        }
        self.positions
            .iter_mut()
            .zip(&bad)
            .filter(|(_, bad)| **bad)
            .for_each(|(p, _)| *p = [0.0; 3]);
        let all = std::mem::take(&mut self.triangles);
        let patches = std::mem::take(&mut self.patch_starts);
        let first = |i: usize| patches.get(i).map_or(i, |&patch| patch as usize);
        let mut broken = vec![false; all.len()];
        for (i, triangle) in all.iter().enumerate() {
            broken[first(i)] |= triangle.iter().any(|&v| bad[v as usize]);
        }
        let mut start = 0;
        for (i, triangle) in all.iter().enumerate().filter(|(i, _)| !broken[first(*i)]) {
            if first(i) == i {
                start = self.triangles.len() as u32;
            }
            if !patches.is_empty() {
                self.patch_starts.push(start);
            }
            self.triangles.push(*triangle);
        }
        all.len() - self.triangles.len()
    }

    /// Returns the memory of vertices and indices (bytes).
    pub fn bytes(&self) -> u64 {
        let Self { positions, triangles, normals, uvs, patch_starts: patches, flipped: _ } = self;
        let [positions, normals] = [positions, normals].map(|column| size_of_val(&column[..]));
        let indices = size_of_val(&triangles[..]) + size_of_val(&patches[..]);
        (positions + normals + size_of_val(&uvs[..]) + indices) as u64
    }

    /// Returns the corners of a triangle.
    #[inline(always)]
    pub fn corners(&self, triangle: u32) -> [Vec3; 3] {
        self.triangles[triangle as usize].map(|i| Vec3::from(self.positions[i as usize]))
    }

    /// Returns the area of a triangle.
    pub fn area(&self, triangle: u32) -> f32 {
        let [a, b, c] = self.corners(triangle).map(|v| v.as_dvec3());
        ((b - a).cross(c - a).length() / 2.0) as f32
    }

    /// Returns, for every triangle, its area or that of its bilinear patch.
    pub fn patch_areas(&self) -> Vec<f32> {
        let areas = (0..self.triangles.len() as u32).map(|triangle| self.area(triangle));
        if self.patch_starts.is_empty() {
            return areas.collect();
        }
        let mut sums = vec![0.0; self.triangles.len()];
        for (&patch, area) in self.patch_starts.iter().zip(areas) {
            sums[patch as usize] += area;
        }
        self.patch_starts.iter().map(|&patch| sums[patch as usize]).collect()
    }

    /// Returns the point of the surface at a hit.
    pub fn point(&self, hit: &Hit) -> SurfacePoint {
        let [a, b, c] = self.corners(hit.primitive);
        let (wb, wc) = (hit.u, hit.v);
        let wa = 1.0 - wb - wc;
        let position = a * wa + b * wb + c * wc;
        let error = ((a * wa).abs() + (b * wb).abs() + (c * wc).abs()) * gamma(8);
        let mut normal = (b - a).cross(c - a).normalize_or_zero();
        let mut shading = None;
        if !self.normals.is_empty() {
            let corners = self.triangles[hit.primitive as usize];
            let [na, nb, nc] = corners.map(|i| Vec3::from(self.normals[i as usize]));
            shading = (na * wa + nb * wb + nc * wc).try_normalize();
        }
        match shading {
            Some(n) => normal *= n.dot(normal).signum(),
            None if self.flipped => normal = -normal,
            None => {}
        }
        SurfacePoint { position, error, normal, shading_normal: shading.unwrap_or(normal) }
    }

    /// Returns the texture coordinates at a hit, and the derivatives with respect to them.
    pub fn derivatives(&self, hit: &Hit) -> SurfaceDerivatives {
        let corners = self.triangles[hit.primitive as usize];
        let [a, b, c] = match self.uvs.is_empty() {
            true => [Vec2::ZERO, Vec2::X, Vec2::ONE],
            false => corners.map(|i| Vec2::from(self.uvs[i as usize])),
        };
        let uv = a * (1.0 - hit.u - hit.v) + b * hit.u + c * hit.v;
        // Positions and normals are linear in u and v: solve for the derivatives by two edges.
        let (one, other) = (a - c, b - c);
        let determinant = one.perp_dot(other);
        let slopes = |values: [Vec3; 3]| {
            let (d, e) = (values[0] - values[2], values[1] - values[2]);
            [d * other.y - e * one.y, e * one.x - d * other.x].map(|slope| slope / determinant)
        };
        let [p, q, r] = self.corners(hit.primitive);
        let mut dp = slopes([p, q, r]);
        let mut dn = [Vec3::ZERO; 2];
        let normal = (q - p).cross(r - p);
        if !dp[0].cross(dp[1]).length_squared().is_normal() || !dp[0].is_finite() {
            // Degenerate texture coordinates: any two directions in the plane.
            let (u, v) = normal.normalize_or(Vec3::Z).any_orthonormal_pair();
            dp = [u, v];
        } else if !self.normals.is_empty() {
            dn = slopes(corners.map(|i| Vec3::from(self.normals[i as usize])));
        }
        SurfaceDerivatives { uv, dp, dn }
    }

    /// Samples a point of a triangle uniformly by area. Returns it as a hit.
    pub fn sample(&self, triangle: u32, u: [f32; 2]) -> Hit {
        // Heitz 2019, "A low-distortion map between triangle and square".
        let (mut b, mut c) = (u[0] * 0.5, u[1] * 0.5);
        let offset = c - b;
        if offset > 0.0 {
            c += offset
        } else {
            b -= offset
        }
        Hit { t: 0.0, u: b, v: c, primitive: triangle, ..Hit::MISS }
    }
}
