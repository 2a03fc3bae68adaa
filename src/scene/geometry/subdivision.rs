//! Loop subdivision surfaces (Loop 1987, "Smooth subdivision surfaces based on triangles"), with
//! creases along open edges (Hoppe et al. 1994, "Piecewise smooth surface reconstruction"), refined
//! a number of times and then moved to the limit surface.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::mesh::Mesh;

/// Neighbour across an open edge, which has no face on the other side.
const NO_FACE: u32 = u32::MAX;

/// Reason why a mesh cannot be subdivided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum SubdivisionError {
    /// An edge of more than two triangles, or of two triangles of inconsistent winding.
    #[error(
        "the edge from vertex {0} to {1} belongs to more than two triangles, or to two \
         of inconsistent winding"
    )]
    NonManifoldEdge(u32, u32),
    /// A vertex where several fans of triangles meet.
    #[error("vertex {0} joins triangles that share no edge")]
    NonManifoldVertex(u32),
    /// A triangle with two equal vertices.
    #[error("triangle {0} names a vertex twice")]
    DegenerateTriangle(u32),
}

/// Control mesh with adjacency.
struct ControlMesh {
    points: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    /// Face across the edge from corner i to corner i + 1, by face and i.
    neighbours: Vec<[u32; 3]>,
    /// One face of each vertex, or [`NO_FACE`]; at a boundary, the first in the order of the fan.
    first_face: Vec<u32>,
}

impl ControlMesh {
    fn new(points: Vec<DVec3>, faces: Vec<[u32; 3]>) -> Result<Self, SubdivisionError> {
        let mut edges: HashMap<(u32, u32), (u32, usize)> = HashMap::new();
        let mut across = vec![[NO_FACE; 3]; faces.len()];
        let mut corners = vec![0u32; points.len()];
        let mut start = vec![NO_FACE; points.len()];
        for (f, face) in faces.iter().enumerate() {
            let [a, b, c] = *face;
            if a == b || b == c || c == a {
                return Err(SubdivisionError::DegenerateTriangle(f as u32));
            }
            for i in 0..3 {
                let (from, to) = (face[i], face[(i + 1) % 3]);
                corners[from as usize] += 1;
                start[from as usize] = f as u32;
                if edges.insert((from, to), (f as u32, i)).is_some() {
                    return Err(SubdivisionError::NonManifoldEdge(from, to));
                }
                if let Some(&(g, j)) = edges.get(&(to, from)) {
                    across[f][i] = g;
                    across[g as usize][j] = f as u32;
                }
            }
        }
        let mut mesh = Self { points, faces, neighbours: across, first_face: start };
        for (v, &count) in corners.iter().enumerate() {
            mesh.rewind_to_boundary(v as u32);
            if mesh.fan(v as u32).count() as u32 != count {
                return Err(SubdivisionError::NonManifoldVertex(v as u32));
            }
        }
        Ok(mesh)
    }

    /// Moves the first face of a vertex back to the open edge, if there is one.
    fn rewind_to_boundary(&mut self, v: u32) {
        let first = self.first_face[v as usize];
        let mut face = first;
        while face != NO_FACE {
            let back = self.neighbours[face as usize][self.corner(face, v)];
            if back == NO_FACE {
                self.first_face[v as usize] = face;
                return;
            }
            face = back;
            if face == first {
                return;
            }
        }
    }

    fn corner(&self, face: u32, v: u32) -> usize {
        self.faces[face as usize].iter().position(|&w| w == v).unwrap_or(0)
    }

    /// Returns the faces around a vertex in winding order, each with the vertex's corner in it.
    fn fan(&self, v: u32) -> impl Iterator<Item = (u32, usize)> {
        let first = self.first_face[v as usize];
        let mut next = first;
        std::iter::from_fn(move || {
            if next == NO_FACE {
                return None;
            }
            let face = next;
            let corner = self.corner(face, v);
            // The face across the edge that ends at the vertex.
            next = self.neighbours[face as usize][(corner + 2) % 3];
            if next == first {
                next = NO_FACE;
            }
            Some((face, corner))
        })
    }

    fn is_boundary(&self, v: u32) -> bool {
        let first = self.first_face[v as usize];
        first != NO_FACE && self.neighbours[first as usize][self.corner(first, v)] == NO_FACE
    }

    /// Collects the neighbours of a vertex in winding order; at a boundary, from edge to edge.
    fn ring(&self, v: u32, ring: &mut Vec<DVec3>) {
        ring.clear();
        let point =
            |face: u32, corner: usize| self.points[self.faces[face as usize][corner % 3] as usize];
        let mut last = None;
        for (face, corner) in self.fan(v) {
            ring.push(point(face, corner + 1));
            last = Some(point(face, corner + 2));
        }
        if self.is_boundary(v) {
            ring.extend(last);
        }
    }

    /// Returns all vertices as weighted means with their neighbours. The weight of each neighbour
    /// is `inner` of their number in the interior; at a boundary it is `outer` for the two along
    /// it.
    fn smoothed(&self, inner: impl Fn(usize) -> f64, outer: f64) -> Vec<DVec3> {
        let mut ring = Vec::new();
        (0..self.points.len() as u32)
            .map(|v| {
                let point = self.points[v as usize];
                self.ring(v, &mut ring);
                match &ring[..] {
                    [] => point,
                    [one, .., other] if self.is_boundary(v) => {
                        point * (1.0 - 2.0 * outer) + (*one + *other) * outer
                    }
                    around => {
                        let weight = inner(around.len());
                        let sum: DVec3 = around.iter().sum();
                        point * (1.0 - around.len() as f64 * weight) + sum * weight
                    }
                }
            })
            .collect()
    }

    /// Returns the mesh after one step of refinement, with four faces for each.
    fn refine(&self) -> Self {
        let mut points = self.smoothed(refinement_weight, 1.0 / 8.0);
        let mut middles = vec![[NO_FACE; 3]; self.faces.len()];
        for f in 0..self.faces.len() {
            for i in 0..3 {
                if middles[f][i] != NO_FACE {
                    continue;
                }
                let middle = points.len() as u32;
                middles[f][i] = middle;
                let [from, to, beyond] = self.corners_from(f as u32, i);
                let g = self.neighbours[f][i];
                points.push(if g == NO_FACE {
                    (from.1 + to.1) / 2.0
                } else {
                    let j = self.corner(g, to.0);
                    middles[g as usize][j] = middle;
                    let opposite = self.corners_from(g, j)[2].1;
                    (from.1 + to.1) * (3.0 / 8.0) + (beyond.1 + opposite) / 8.0
                });
            }
        }
        let mut faces = Vec::with_capacity(4 * self.faces.len());
        let mut across = Vec::with_capacity(4 * self.faces.len());
        let mut start = vec![NO_FACE; points.len()];
        // Child 4 f + i of face f keeps corner i, and child 4 f + 3 is in the middle.
        let child = |face: u32, v: u32| match face {
            NO_FACE => NO_FACE,
            face => 4 * face + self.corner(face, v) as u32,
        };
        for f in 0..self.faces.len() {
            let ([a, b, c], [ab, bc, ca]) = (self.faces[f], middles[f]);
            let [x, y, z] = self.neighbours[f];
            let inner = 4 * f as u32 + 3;
            faces.extend([[a, ab, ca], [ab, b, bc], [ca, bc, c], [ab, bc, ca]]);
            across.extend([
                [child(x, a), inner, child(z, a)],
                [child(x, b), child(y, b), inner],
                [inner, child(y, c), child(z, c)],
                [inner - 2, inner - 1, inner - 3],
            ]);
        }
        for (f, face) in faces.iter().enumerate() {
            for &v in face {
                start[v as usize] = f as u32;
            }
        }
        let mut mesh = Self { points, faces, neighbours: across, first_face: start };
        (0..mesh.points.len() as u32).for_each(|v| mesh.rewind_to_boundary(v));
        mesh
    }

    /// Returns the vertex indices and points of a face's corners, starting at the i-th.
    fn corners_from(&self, face: u32, i: usize) -> [(u32, DVec3); 3] {
        [0, 1, 2].map(|k| {
            let v = self.faces[face as usize][(i + k) % 3];
            (v, self.points[v as usize])
        })
    }

    /// Returns the normal at a vertex on the limit surface, from two tangents (Hoppe et al. 1994,
    /// appendix). Like pbrt's, it is opposite to the winding.
    fn normal(&self, v: u32, ring: &mut Vec<DVec3>) -> DVec3 {
        self.ring(v, ring);
        let point = self.points[v as usize];
        let n = ring.len();
        let (along, inwards) = if !self.is_boundary(v) {
            let turn = |j: usize| TAU * j as f64 / n as f64;
            let sum = |weight: fn(f64) -> f64| -> DVec3 {
                ring.iter().enumerate().map(|(j, p)| *p * weight(turn(j))).sum()
            };
            (sum(f64::cos), sum(f64::sin))
        } else {
            let (first, last) = (ring[0], ring[n - 1]);
            let inwards = match n {
                2 => first + last - 2.0 * point,
                3 => ring[1] - point,
                4 => 2.0 * (ring[1] + ring[2]) - first - last - 2.0 * point,
                _ => {
                    let theta = PI / (n - 1) as f64;
                    let mut sum = (first + last) * theta.sin();
                    for (k, p) in ring.iter().enumerate().take(n - 1).skip(1) {
                        sum += *p * ((2.0 * theta.cos() - 2.0) * (k as f64 * theta).sin());
                    }
                    -sum
                }
            };
            (first - last, inwards)
        };
        inwards.cross(along).normalize_or_zero()
    }
}

/// Returns the weight of each neighbour in a refined interior vertex (Loop 1987, simplified by
/// Warren 1995).
fn refinement_weight(neighbours: usize) -> f64 {
    if neighbours == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * neighbours as f64) }
}

/// Weight of each of the two neighbours along a boundary in the limit of a vertex, as in pbrt. The
/// true limit of the refinement, a cubic B-spline, has 1/6.
const BOUNDARY_LIMIT: f64 = 1.0 / 5.0;

/// Returns the weight of each neighbour in the limit of an interior vertex.
fn limit_weight(neighbours: usize) -> f64 {
    1.0 / (neighbours as f64 + 3.0 / (8.0 * refinement_weight(neighbours)))
}

/// Refines a mesh a number of times, moves its vertices to the limit surface, and adds the normals
/// of that surface. Vertices without triangles do not move.
///
/// # Errors
/// Returns an error if the triangles do not form a manifold, with or without boundary.
pub fn subdivide(mesh: &Mesh, levels: u32) -> Result<Mesh, SubdivisionError> {
    let points = mesh.positions.iter().map(|p| Vec3::from(*p).as_dvec3()).collect();
    let mut control = ControlMesh::new(points, mesh.triangles.clone())?;
    for _ in 0..levels {
        control = control.refine();
    }
    control.points = control.smoothed(limit_weight, BOUNDARY_LIMIT);
    let mut ring = Vec::new();
    let normals = (0..control.points.len() as u32).map(|v| control.normal(v, &mut ring));
    let single = |p: DVec3| p.as_vec3().to_array();
    Ok(Mesh {
        normals: normals.map(single).collect(),
        positions: control.points.into_iter().map(single).collect(),
        triangles: control.faces,
        ..Mesh::default()
    })
}
