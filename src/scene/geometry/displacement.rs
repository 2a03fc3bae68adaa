//! Refinement and displacement of triangle meshes.

use std::collections::HashMap;

use glam::Vec3;
use rayon::prelude::*;

use super::mesh::Mesh;

/// Number of new vertices between two checks of their number.
const CHECK_INTERVAL: usize = 1 << 16;

impl Mesh {
    /// Bisects triangles at their longest edges until all edges are shorter than `longest`, as
    /// pbrt-v4 does. An edge that two triangles share gets one vertex, so that no gaps open.
    /// `length` returns the length of an edge, in the units of `longest`. Patches become triangles.
    ///
    /// # Errors
    /// Returns the error of `check`, which is called now and then with the number of vertices.
    pub fn refine<E>(
        &mut self,
        length: impl Fn(Vec3, Vec3) -> f64,
        longest: f64,
        mut check: impl FnMut(usize) -> Result<(), E>,
    ) -> Result<(), E> {
        self.patch_starts = Vec::new();
        let mut middles: HashMap<[u32; 2], u32> = HashMap::new();
        let coarse = std::mem::take(&mut self.triangles);
        let mut todo = Vec::new();
        check(self.positions.len())?;
        for triangle in coarse {
            todo.push(triangle);
            while let Some([a, b, c]) = todo.pop() {
                let [p, q, r] = [a, b, c].map(|i| Vec3::from(self.positions[i as usize]));
                let (ab, bc, ca) = (length(p, q), length(q, r), length(r, p));
                if ab < longest && bc < longest && ca < longest {
                    self.triangles.push([a, b, c]);
                    continue;
                }
                // The first edge is the longest.
                let [a, b, c] = match (ab > bc, ab > ca, bc > ca) {
                    (true, true, _) => [a, b, c],
                    (false, _, true) => [b, c, a],
                    _ => [c, a, b],
                };
                let middle = *middles
                    .entry([a.min(b), a.max(b)])
                    .or_insert_with(|| self.add_midpoint(a as usize, b as usize));
                if self.positions.len().is_multiple_of(CHECK_INTERVAL) {
                    check(self.positions.len())?;
                }
                todo.extend([[middle, b, c], [a, middle, c]]);
            }
        }
        check(self.positions.len())
    }

    /// Adds the vertex in the middle of an edge, and returns its index.
    fn add_midpoint(&mut self, a: usize, b: usize) -> u32 {
        let index = self.positions.len() as u32;
        let middle = |column: &[[f32; 3]]| (Vec3::from(column[a]) + Vec3::from(column[b])) / 2.0;
        self.positions.push(middle(&self.positions).to_array());
        if !self.normals.is_empty() {
            self.normals.push(middle(&self.normals).normalize_or_zero().to_array());
        }
        if !self.uvs.is_empty() {
            let ([s, t], [u, v]) = (self.uvs[a], self.uvs[b]);
            self.uvs.push([(s + u) / 2.0, (t + v) / 2.0]);
        }
        index
    }

    /// Moves each vertex along its normal by `height`, a function of its position, normal and
    /// texture coordinates, and replaces the normals by those of the new surface. Without normals,
    /// vertices move along those of the surface.
    pub fn displace(&mut self, height: impl Fn(Vec3, Vec3, [f32; 2]) -> f32 + Sync) {
        if self.normals.is_empty() {
            self.set_vertex_normals();
        }
        let Self { positions, normals, uvs, .. } = self;
        positions.par_iter_mut().enumerate().for_each(|(i, position)| {
            let (p, n) = (Vec3::from(*position), Vec3::from(normals[i]));
            let uv = uvs.get(i).copied().unwrap_or_default();
            *position = (p + n * height(p, n, uv)).to_array();
        });
        self.set_vertex_normals();
    }

    /// Sets the normal of each vertex to the mean of those of its triangles, each counting alike.
    fn set_vertex_normals(&mut self) {
        let mut sums = vec![Vec3::ZERO; self.positions.len()];
        for (triangle, corners) in (0..).zip(&self.triangles) {
            let [a, b, c] = self.corners(triangle);
            let normal = (b - a).cross(c - b).normalize_or_zero();
            for &corner in corners {
                sums[corner as usize] += normal;
            }
        }
        self.normals = sums.into_iter().map(|sum| sum.normalize_or_zero().to_array()).collect();
    }
}

#[cfg(test)]
mod tests {
    use std::convert::Infallible;

    use super::*;

    /// Returns a square of two triangles of 1 by 1, at z = 0.
    fn square() -> Mesh {
        Mesh {
            positions: vec![[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 0.0]],
            uvs: vec![[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]],
            triangles: vec![[0, 1, 3], [0, 3, 2]],
            ..Mesh::default()
        }
    }

    fn distance(a: Vec3, b: Vec3) -> f64 {
        f64::from(a.distance(b))
    }

    fn any(_: usize) -> Result<(), Infallible> {
        Ok(())
    }

    #[test]
    fn refined_triangles_have_short_edges_and_share_their_vertices() {
        let mut mesh = square();
        mesh.refine(distance, 0.1, any).unwrap();
        let mut uses: HashMap<[u32; 2], usize> = HashMap::new();
        for &[a, b, c] in &mesh.triangles {
            for [from, to] in [[a, b], [b, c], [c, a]] {
                let [p, q] = [from, to].map(|i| Vec3::from(mesh.positions[i as usize]));
                assert!(distance(p, q) < 0.1);
                *uses.entry([from.min(to), from.max(to)]).or_default() += 1;
            }
        }
        // Only edges on the border belong to one triangle.
        let border = uses.values().filter(|&&count| count == 1).count();
        assert!(uses.values().all(|&count| count <= 2) && border == 4 * 16, "{border}");
        let area: f32 = (0..mesh.triangles.len() as u32).map(|i| mesh.area(i)).sum();
        assert!((area - 1.0).abs() < 1e-5);
        for (p, uv) in mesh.positions.iter().zip(&mesh.uvs) {
            assert_eq!([p[0], p[1]], *uv);
        }
    }

    #[test]
    fn a_refused_number_of_vertices_ends_an_endless_refinement() {
        let check = |count: usize| if count < 1 << 18 { Ok(()) } else { Err(count) };
        assert_eq!(square().refine(distance, 1e-30, check), Err(1 << 18));
    }

    #[test]
    fn vertices_move_along_their_normals_and_normals_follow_the_surface() {
        let mut mesh = square();
        mesh.refine(distance, 0.05, any).unwrap();
        mesh.displace(|_, _, [u, _]| 0.5 * u);
        for (p, n) in mesh.positions.iter().zip(&mesh.normals) {
            assert!((p[2] - 0.5 * p[0]).abs() < 1e-6, "{p:?}");
            let expected = Vec3::new(-0.5, 0.0, 1.0).normalize();
            assert!(Vec3::from(*n).distance(expected) < 1e-4, "{n:?}");
        }
    }
}
