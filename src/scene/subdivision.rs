//! Loop's subdivision surfaces (Loop 1987, "Smooth subdivision surfaces based on triangles"),
//! with creases along open edges (Hoppe et al. 1994, "Piecewise smooth surface
//! reconstruction"), refined a number of times and then pushed to the limit.

use std::collections::HashMap;
use std::f64::consts::{PI, TAU};

use glam::{DVec3, Vec3};

use super::mesh::Mesh;

/// A face on the other side of an edge that nothing adjoins.
const OPEN: u32 = u32::MAX;

/// Why a mesh cannot be subdivided.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unsmooth {
    /// An edge that more than two triangles share, or two that run along it the same way.
    #[error(
        "the edge from vertex {0} to {1} adjoins more than two triangles, or two that turn differently"
    )]
    Edge(u32, u32),
    /// A vertex where several fans of triangles meet in a point.
    #[error("vertex {0} joins triangles that share no edge")]
    Vertex(u32),
    /// A triangle that names a vertex twice.
    #[error("triangle {0} names a vertex twice")]
    Triangle(u32),
}

/// A control mesh, and what adjoins what in it.
struct Control {
    points: Vec<DVec3>,
    faces: Vec<[u32; 3]>,
    /// The face across the edge from corner i to corner i + 1.
    across: Vec<[u32; 3]>,
    /// One face of each vertex, or [`OPEN`]: at a boundary the first in the sense of turn.
    start: Vec<u32>,
}

impl Control {
    fn new(points: Vec<DVec3>, faces: Vec<[u32; 3]>) -> Result<Self, Unsmooth> {
        let mut edges: HashMap<(u32, u32), (u32, usize)> = HashMap::new();
        let mut across = vec![[OPEN; 3]; faces.len()];
        let mut corners = vec![0u32; points.len()];
        let mut start = vec![OPEN; points.len()];
        for (f, face) in faces.iter().enumerate() {
            let [a, b, c] = *face;
            if a == b || b == c || c == a {
                return Err(Unsmooth::Triangle(f as u32));
            }
            for i in 0..3 {
                let (from, to) = (face[i], face[(i + 1) % 3]);
                corners[from as usize] += 1;
                start[from as usize] = f as u32;
                if edges.insert((from, to), (f as u32, i)).is_some() {
                    return Err(Unsmooth::Edge(from, to));
                }
                if let Some(&(g, j)) = edges.get(&(to, from)) {
                    across[f][i] = g;
                    across[g as usize][j] = f as u32;
                }
            }
        }
        let mut mesh = Self { points, faces, across, start };
        for (v, &count) in corners.iter().enumerate() {
            mesh.open_at_start(v as u32);
            if mesh.fan(v as u32).count() as u32 != count {
                return Err(Unsmooth::Vertex(v as u32));
            }
        }
        Ok(mesh)
    }

    /// Turns back from the start of a vertex to the open edge, if there is one.
    fn open_at_start(&mut self, v: u32) {
        let first = self.start[v as usize];
        let mut face = first;
        while face != OPEN {
            let back = self.across[face as usize][self.corner(face, v)];
            if back == OPEN {
                self.start[v as usize] = face;
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

    /// The faces about a vertex, in the sense of turn, each with the vertex's corner in it.
    fn fan(&self, v: u32) -> impl Iterator<Item = (u32, usize)> {
        let first = self.start[v as usize];
        let mut next = first;
        std::iter::from_fn(move || {
            if next == OPEN {
                return None;
            }
            let face = next;
            let corner = self.corner(face, v);
            // Across the edge that arrives at the vertex.
            next = self.across[face as usize][(corner + 2) % 3];
            if next == first {
                next = OPEN;
            }
            Some((face, corner))
        })
    }

    fn is_open(&self, v: u32) -> bool {
        let first = self.start[v as usize];
        first != OPEN && self.across[first as usize][self.corner(first, v)] == OPEN
    }

    /// The neighbours of a vertex in the sense of turn; at a boundary from edge to edge.
    fn ring(&self, v: u32, ring: &mut Vec<DVec3>) {
        ring.clear();
        let point =
            |face: u32, corner: usize| self.points[self.faces[face as usize][corner % 3] as usize];
        let mut last = None;
        for (face, corner) in self.fan(v) {
            ring.push(point(face, corner + 1));
            last = Some(point(face, corner + 2));
        }
        if self.is_open(v) {
            ring.extend(last);
        }
    }

    /// Every vertex moved towards its neighbours: inside by `inner` for each of them by their
    /// number, at a boundary by `outer` for the two along it.
    fn moved(&self, inner: impl Fn(usize) -> f64, outer: f64) -> Vec<DVec3> {
        let mut ring = Vec::new();
        (0..self.points.len() as u32)
            .map(|v| {
                let point = self.points[v as usize];
                self.ring(v, &mut ring);
                match &ring[..] {
                    [] => point,
                    [one, .., other] if self.is_open(v) => {
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

    /// One step of refinement: four faces for each.
    fn refined(&self) -> Self {
        let mut points = self.moved(beta, 1.0 / 8.0);
        let mut middles = vec![[OPEN; 3]; self.faces.len()];
        for f in 0..self.faces.len() {
            for i in 0..3 {
                if middles[f][i] != OPEN {
                    continue;
                }
                let middle = points.len() as u32;
                middles[f][i] = middle;
                let [from, to, beyond] = self.turned(f as u32, i);
                let g = self.across[f][i];
                points.push(if g == OPEN {
                    (from.1 + to.1) / 2.0
                } else {
                    let j = self.corner(g, to.0);
                    middles[g as usize][j] = middle;
                    let opposite = self.turned(g, j)[2].1;
                    (from.1 + to.1) * (3.0 / 8.0) + (beyond.1 + opposite) / 8.0
                });
            }
        }
        let mut faces = Vec::with_capacity(4 * self.faces.len());
        let mut across = Vec::with_capacity(4 * self.faces.len());
        let mut start = vec![OPEN; points.len()];
        // Of face f, child 4 f + i keeps corner i, and child 4 f + 3 lies in the middle.
        let child = |face: u32, v: u32| match face {
            OPEN => OPEN,
            face => 4 * face + self.corner(face, v) as u32,
        };
        for f in 0..self.faces.len() {
            let ([a, b, c], [ab, bc, ca]) = (self.faces[f], middles[f]);
            let [x, y, z] = self.across[f];
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
        let mut mesh = Self { points, faces, across, start };
        (0..mesh.points.len() as u32).for_each(|v| mesh.open_at_start(v));
        mesh
    }

    /// The corners of a face from the i-th on: their numbers and points.
    fn turned(&self, face: u32, i: usize) -> [(u32, DVec3); 3] {
        [0, 1, 2].map(|k| {
            let v = self.faces[face as usize][(i + k) % 3];
            (v, self.points[v as usize])
        })
    }

    /// The normal at a vertex of a mesh that was pushed to the limit, from two tangents (Hoppe
    /// et al. 1994, appendix). It points where pbrt's does: against the turn of the faces.
    fn normal(&self, v: u32, ring: &mut Vec<DVec3>) -> DVec3 {
        self.ring(v, ring);
        let point = self.points[v as usize];
        let n = ring.len();
        let (along, inwards) = if !self.is_open(v) {
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

/// The share of each neighbour in a vertex inside (Loop 1987 as simplified by Warren 1995).
fn beta(neighbours: usize) -> f64 {
    if neighbours == 3 { 3.0 / 16.0 } else { 3.0 / (8.0 * neighbours as f64) }
}

/// The share of the two neighbours along a boundary in what counts as its limit: pbrt's figure.
/// The curve that refinement alone tends to, a cubic B-spline, has 1/6.
const BOUNDARY_LIMIT: f64 = 1.0 / 5.0;

/// The share of each neighbour in the limit of a vertex inside.
fn limit(neighbours: usize) -> f64 {
    1.0 / (neighbours as f64 + 3.0 / (8.0 * beta(neighbours)))
}

/// Refines triangles a number of times and pushes their vertices to the limit surface, with
/// its normals. Vertices that no triangle names stay where they are.
///
/// # Errors
/// Where the triangles are no surface, with or without boundary.
pub fn subdivide(mesh: &Mesh, levels: u32) -> Result<Mesh, Unsmooth> {
    let points = mesh.positions.iter().map(|p| Vec3::from(*p).as_dvec3()).collect();
    let mut control = Control::new(points, mesh.triangles.clone())?;
    for _ in 0..levels {
        control = control.refined();
    }
    control.points = control.moved(limit, BOUNDARY_LIMIT);
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
