//! Triangle mesh.

use glam::{DAffine3, DVec3, Vec3};

use super::surface_point::{SurfaceDerivatives, SurfacePoint};
use super::triangle::ShadingTriangle;
use petzval_base::rays::Hit;

/// Triangles over shared vertices, in the space of the object that they belong to.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Mesh {
    /// Vertex positions.
    pub positions: Vec<[f32; 3]>,
    /// Indices of three vertices for each triangle.
    pub triangles: Vec<[u32; 3]>,
    /// Unit shading normals by vertex; empty if there are none.
    pub normals: Vec<[f32; 3]>,
    /// Tangents of the shading frame by vertex, of any length; empty if they follow the texture
    /// coordinates.
    pub tangents: Vec<[f32; 3]>,
    /// Texture coordinates by vertex; empty if there are none.
    pub uvs: Vec<[f32; 2]>,
    /// Colours by vertex, linear RGB and opacity; empty if there are none.
    pub colours: Vec<[f32; 4]>,
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
        for tangent in &mut self.tangents {
            *tangent = single(matrix.transform_vector3(double(*tangent)));
        }
        let to_normal = matrix.matrix3.inverse().transpose();
        let sign = if reversed { -1.0 } else { 1.0 };
        for n in &mut self.normals {
            *n = single((to_normal * double(*n)).normalize_or_zero() * sign);
        }
        self.flipped = reversed ^ (matrix.matrix3.determinant() < 0.0);
    }

    /// Removes the triangles that have a vertex that is not finite, together with their whole
    /// patches, and returns their number. Such vertices, normals, tangents and texture coordinates
    /// become 0.
    pub fn drop_non_finite(&mut self) -> usize {
        let finite = |values: &[f32]| values.iter().all(|v| v.is_finite());
        let vectors = self.normals.iter_mut().chain(&mut self.tangents);
        vectors.filter(|v| !finite(*v)).for_each(|v| *v = [0.0; 3]);
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
        let Self {
            positions,
            triangles,
            normals,
            tangents,
            uvs,
            colours,
            patch_starts: patches,
            flipped: _,
        } = self;
        let vectors: usize =
            [positions, normals, tangents].iter().map(|column| size_of_val(&column[..])).sum();
        let indices = size_of_val(&triangles[..]) + size_of_val(&patches[..]);
        (vectors + size_of_val(&uvs[..]) + size_of_val(&colours[..]) + indices) as u64
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

    /// Returns the vertex data of a triangle.
    #[inline(always)]
    pub fn triangle(&self, index: u32) -> ShadingTriangle<f32> {
        let corners = self.triangles[index as usize];
        ShadingTriangle {
            positions: self.positions_of(corners),
            normals: self.normals_of(corners),
            uvs: self.uvs_of(index, corners),
            side: self.side(),
        }
    }

    /// Returns the positions of the corners of a triangle.
    #[inline(always)]
    pub(super) fn positions_of(&self, corners: [u32; 3]) -> [[f32; 3]; 3] {
        corners.map(|i| self.positions[i as usize])
    }

    /// Returns the shading normals at the corners of a triangle; 0 if there are none.
    #[inline(always)]
    pub(super) fn normals_of(&self, corners: [u32; 3]) -> [[f32; 3]; 3] {
        match self.normals.is_empty() {
            true => [[0.0; 3]; 3],
            false => corners.map(|i| self.normals[i as usize]),
        }
    }

    /// Returns the texture coordinates at the corners of a triangle, given its index too.
    #[inline(always)]
    pub(super) fn uvs_of(&self, index: u32, corners: [u32; 3]) -> [[f32; 2]; 3] {
        if !self.uvs.is_empty() {
            return corners.map(|i| self.uvs[i as usize]);
        }
        match self.patch_starts.get(index as usize) {
            // The second triangle of a patch begins at its corner (1, 1).
            Some(&start) if start != index => [[1.0, 1.0], [0.0, 1.0], [0.0, 0.0]],
            _ => [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]],
        }
    }

    /// Returns -1 if the normal is opposite to the winding, otherwise 1.
    #[inline(always)]
    pub(super) fn side(&self) -> f32 {
        if self.flipped { -1.0 } else { 1.0 }
    }

    /// Returns the tangent of the shading frame at a hit, of any length, or `None` if it follows the
    /// texture coordinates.
    pub fn tangent(&self, hit: &Hit) -> Option<Vec3> {
        let corners = self.triangles[hit.primitive as usize];
        let at =
            |corner: usize| self.tangents.get(corners[corner] as usize).map(|&t| Vec3::from(t));
        let along = at(0)? * (1.0 - hit.u - hit.v) + at(1)? * hit.u + at(2)? * hit.v;
        (along.length_squared() > 0.0).then_some(along)
    }

    /// Returns the colour of the vertices at a hit, or `None` if they have none.
    pub fn colour(&self, hit: &Hit) -> Option<[f32; 4]> {
        let corners = self.triangles[hit.primitive as usize];
        let at = |corner: usize| self.colours.get(corners[corner] as usize);
        let (a, b, c) = (at(0)?, at(1)?, at(2)?);
        let w = 1.0 - hit.u - hit.v;
        Some(std::array::from_fn(|i| a[i] * w + b[i] * hit.u + c[i] * hit.v))
    }

    /// Returns whether bump maps displace the mesh along tangents that follow its vertex normals.
    pub fn is_smooth(&self) -> bool {
        !self.normals.is_empty() && self.patch_starts.is_empty()
    }

    /// Returns the point of the surface at a hit.
    pub fn point(&self, hit: &Hit) -> SurfacePoint {
        self.triangle(hit.primitive).point(hit.u, hit.v).into()
    }

    /// Returns the texture coordinates at a hit, and the derivatives with respect to them.
    pub fn derivatives(&self, hit: &Hit) -> SurfaceDerivatives {
        self.triangle(hit.primitive).derivatives(hit.u, hit.v).into()
    }
}
