//! Flat bilinear patches as triangles, and the tessellation of others that emit light.
//!
//! A patch is the surface p(u, v) between four corners, linear in u and in v (Ramsey, Potter &
//! Hansen 2004, "Ray bilinear patch intersections"). The distance between the patch and its
//! triangles is known: it is proportional to the square of the cell size.

use glam::{DVec3, Vec2, Vec3};

use super::mesh::Mesh;
use super::patch_mesh::PatchMesh;

/// Largest distance between a patch and its triangles, relative to the longer diagonal of the
/// patch; in the plane of texture coordinates, too.
const TOLERANCE: f64 = 1e-4;
/// Largest difference between the normals of vertices as a patch and as its triangles interpolate
/// them: a thousandth of a unit normal changes shading by less than the noise of a picture.
const NORMAL_TOLERANCE: f64 = 1e-3;
/// Distance that is always allowed, relative to the diagonal of the mesh: a tenth of a pixel if the
/// mesh fills a picture of 5000 pixels.
const MESH_TOLERANCE: f64 = 2e-5;
/// Most cells along one side of a patch.
const MAX_CELLS: u32 = 256;

/// Largest allowed distance between a patch and its triangles: the greater of the two.
#[derive(Clone, Copy)]
struct Tolerance {
    /// Relative to the longer diagonal of the patch.
    relative: f64,
    /// A length.
    absolute: f64,
}

impl Tolerance {
    fn new(mesh: &Mesh) -> Self {
        Self { relative: TOLERANCE, absolute: MESH_TOLERANCE * diagonal(mesh) }
    }

    /// Returns the tolerance of texture coordinates: what f32 cannot express is no twist.
    fn of_texture(&self, uvs: &Corners) -> Self {
        let largest = uvs.0.iter().fold(0.0f64, |largest, uv| largest.max(uv.abs().max_element()));
        Self { relative: self.relative, absolute: f64::from(f32::EPSILON) * largest }
    }

    /// Returns the tolerance of normals.
    fn of_normals(&self) -> Self {
        Self { relative: 0.0, absolute: NORMAL_TOLERANCE * self.relative / TOLERANCE }
    }
}

/// Points, normals or texture coordinates at the corners of a patch.
#[derive(Clone, Copy)]
struct Corners([DVec3; 4]);

impl Corners {
    fn at(&self, u: f64, v: f64) -> DVec3 {
        let [a, b, c, d] = self.0;
        a.lerp(b, u).lerp(c.lerp(d, u), v)
    }

    fn normal(&self, u: f64, v: f64) -> DVec3 {
        let [a, b, c, d] = self.0;
        (b - a).lerp(d - c, v).cross((c - a).lerp(d - b, u))
    }

    /// Returns the mixed derivative with respect to u and v, which is 0 for a parallelogram.
    fn twist(&self) -> DVec3 {
        let [a, b, c, d] = self.0;
        a - b - c + d
    }

    /// Returns the number of cells along a side that keeps the triangles within a tolerance.
    /// `planar` ignores distances within the plane of the patch.
    ///
    /// The distance between the patch and the diagonal of a cell, at the centre of the cell, is a
    /// quarter of the cell's twist.
    fn cells(&self, tolerance: Tolerance, planar: bool) -> u32 {
        let [a, b, c, d] = self.0;
        let diagonal = a.distance(d).max(b.distance(c));
        let twist = self.twist();
        let height = twist.dot((d - a).cross(c - b).normalize_or_zero()).abs();
        let allowed = 4.0 * (tolerance.relative * diagonal).max(tolerance.absolute);
        if planar && height <= allowed {
            return 1;
        }
        let cells = (twist.length() / allowed).sqrt().ceil();
        (cells as u32).clamp(1, MAX_CELLS)
    }
}

/// Adds the flat ones of the patches over the vertices of a mesh to it, as two triangles each, and
/// returns the others. The four vertices of a patch are at (u, v) = (0, 0), (1, 0), (0, 1) and
/// (1, 1). A patch is flat if two triangles keep within the tolerance in its points, its normals and
/// its texture coordinates, which are u and v if the vertices have none.
pub fn split_patches(mesh: &mut Mesh, patches: &[[u32; 4]]) -> PatchMesh {
    let tolerance = Tolerance::new(mesh);
    let mut curved = PatchMesh::default();
    if !patches.is_empty() {
        mesh.patch_starts = (0..mesh.triangles.len() as u32).collect();
    }
    for &patch in patches {
        if cells(mesh, patch, tolerance, false) > 1 {
            curved.patches.push(patch);
            continue;
        }
        let [a, b, c, d] = patch;
        mesh.patch_starts.extend([mesh.triangles.len() as u32; 2]);
        mesh.triangles.extend([[a, b, d], [d, c, a]]);
    }
    curved.vertices.flipped = mesh.flipped;
    let mut copies =
        vec![u32::MAX; if curved.patches.is_empty() { 0 } else { mesh.positions.len() }];
    for vertex in curved.patches.iter_mut().flatten() {
        let i = *vertex as usize;
        if copies[i] == u32::MAX {
            copies[i] = curved.vertices.positions.len() as u32;
            curved.vertices.positions.push(mesh.positions[i]);
            curved.vertices.normals.extend(mesh.normals.get(i));
            curved.vertices.uvs.extend(mesh.uvs.get(i));
        }
        *vertex = copies[i];
    }
    curved
}

impl PatchMesh {
    /// Returns triangles in place of the patches, for lights, whose emitters are triangles. They have
    /// the normals of the patches if the vertices have none. The tolerance doubles until the patches
    /// become at most `most` triangles, or two each.
    pub fn tessellate(&self, most: u64) -> Mesh {
        let Self { vertices, patches } = self;
        let planar = vertices.uvs.is_empty();
        let count_cells = |tolerance: Tolerance| -> Vec<u32> {
            patches.iter().map(|&patch| cells(vertices, patch, tolerance, planar)).collect()
        };
        let total = |cells: &[u32]| cells.iter().map(|&n| 2 * u64::from(n).pow(2)).sum::<u64>();
        let mut tolerance = Tolerance::new(vertices);
        let mut cells = count_cells(tolerance);
        while total(&cells) > most.max(2 * patches.len() as u64) {
            tolerance.relative *= 2.0;
            tolerance.absolute *= 2.0;
            cells = count_cells(tolerance);
        }
        let mut mesh = Mesh { flipped: vertices.flipped, ..Mesh::default() };
        for (&patch, cells) in patches.iter().zip(cells) {
            add_grid(vertices, patch, cells, &mut mesh);
        }
        mesh
    }
}

/// Returns the length of the diagonal of the box around the finite vertices of a mesh.
fn diagonal(mesh: &Mesh) -> f64 {
    let finite = mesh.positions.iter().map(|p| Vec3::from(*p)).filter(|p| p.is_finite());
    let (low, high) =
        finite.fold((Vec3::MAX, Vec3::MIN), |(low, high), p| (low.min(p), high.max(p)));
    low.as_dvec3().distance(high.as_dvec3())
}

fn corner_points(mesh: &Mesh, patch: [u32; 4]) -> Corners {
    Corners(patch.map(|i| Vec3::from(mesh.positions[i as usize]).as_dvec3()))
}

fn corner_normals(mesh: &Mesh, patch: [u32; 4]) -> Option<Corners> {
    let normal = |i: u32| Vec3::from(mesh.normals[i as usize]).as_dvec3();
    (!mesh.normals.is_empty()).then(|| Corners(patch.map(normal)))
}

fn corner_uvs(mesh: &Mesh, patch: [u32; 4]) -> Option<Corners> {
    let uv = |i: u32| Vec2::from(mesh.uvs[i as usize]).extend(0.0).as_dvec3();
    (!mesh.uvs.is_empty()).then(|| Corners(patch.map(uv)))
}

/// Returns the number of cells along a side of a patch over the vertices of a mesh that keeps the
/// triangles of its points, normals and texture coordinates within the tolerance. `planar` ignores
/// distances of points within the plane of the patch.
fn cells(mesh: &Mesh, patch: [u32; 4], tolerance: Tolerance, planar: bool) -> u32 {
    let points = corner_points(mesh, patch).cells(tolerance, planar);
    let normals = corner_normals(mesh, patch);
    let normals = normals.map_or(1, |normals| normals.cells(tolerance.of_normals(), false));
    let uvs = corner_uvs(mesh, patch);
    let uvs = uvs.map_or(1, |uvs| uvs.cells(tolerance.of_texture(&uvs), false));
    points.max(normals).max(uvs)
}

/// Adds a patch to a mesh, as a grid of cells.
fn add_grid(from: &Mesh, patch: [u32; 4], cells: u32, to: &mut Mesh) {
    let points = corner_points(from, patch);
    let normals = corner_normals(from, patch);
    let uvs = corner_uvs(from, patch).unwrap_or(Corners([
        DVec3::ZERO,
        DVec3::X,
        DVec3::Y,
        DVec3::new(1.0, 1.0, 0.0),
    ]));
    let first = to.positions.len() as u32;
    for row in 0..=cells {
        for column in 0..=cells {
            let [u, v] = [column, row].map(|i| f64::from(i) / f64::from(cells));
            let normal = match &normals {
                Some(normals) => normals.at(u, v),
                None => points.normal(u, v),
            };
            to.positions.push(points.at(u, v).as_vec3().to_array());
            to.normals.push(normal.normalize_or_zero().as_vec3().to_array());
            to.uvs.push(uvs.at(u, v).truncate().as_vec2().to_array());
        }
    }
    let patch_start = [to.triangles.len() as u32; 2];
    for row in 0..cells {
        for column in 0..cells {
            to.patch_starts.extend(patch_start);
            let a = first + row * (cells + 1) + column;
            let c = a + cells + 1;
            to.triangles.extend([[a, a + 1, c + 1], [c + 1, c, a]]);
        }
    }
}
