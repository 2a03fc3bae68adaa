//! Bilinear patches, cut into triangles.
//!
//! A patch is the surface p(u, v) between four corners, linear in u and in v (Ramsey, Potter &
//! Hansen 2004, "Ray bilinear patch intersections"). Its distance from the triangles that it is
//! cut into is known: halving the cells quarters it.

use glam::{DVec2, DVec3, Vec2, Vec3};

use super::mesh::Mesh;

/// How far a patch may be from its triangles, in shares of its longer diagonal.
const TOLERANCE: f64 = 1e-4;
/// How far it may be in any case, in shares of the diagonal of its mesh: a tenth of a pixel where the
/// mesh fills a picture of 5000 pixels.
const MESH_TOLERANCE: f64 = 2e-5;
/// Most cells along one side of a patch.
const MOST_CELLS: u32 = 256;

/// The points at the corners of a patch, or the normals there.
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

    /// What keeps the patch from being a parallelogram.
    fn twist(&self) -> DVec3 {
        let [a, b, c, d] = self.0;
        a - b - c + d
    }

    /// The cells along a side that bring the triangles to within a share of the diagonal, or a
    /// distance, whichever is more.
    ///
    /// In the middle of a cell the patch is a quarter of the cell's twist from the diagonal.
    fn cells(&self, [share, distance]: [f64; 2], flat: bool) -> u32 {
        let [a, b, c, d] = self.0;
        let diagonal = a.distance(d).max(b.distance(c));
        let twist = self.twist();
        // Without texture coordinates only what leaves the plane counts.
        let height = twist.dot((d - a).cross(c - b).normalize_or_zero()).abs();
        let allowed = 4.0 * (share * diagonal).max(distance);
        if flat && height <= allowed {
            return 1;
        }
        let cells = (twist.length() / allowed).sqrt().ceil();
        (cells as u32).clamp(1, MOST_CELLS)
    }
}

/// Cuts patches over the vertices of a mesh, four each at (u, v) = (0, 0), (1, 0), (0, 1) and
/// (1, 1). Flat ones become two triangles of the mesh; answers another mesh of all that the
/// others become, which has the normals of the patches where the vertices have none.
///
/// Where the vertices have texture coordinates, these are kept to the same tolerance. It gives way where
/// they would become more triangles than `most`; two are the least that a patch becomes.
pub fn triangulate(mesh: &mut Mesh, patches: &[[u32; 4]], most: u64) -> Mesh {
    let flat = mesh.uvs.is_empty();
    let cut = |tolerance: [f64; 2]| -> Vec<u32> {
        patches.iter().map(|&patch| points(mesh, patch).cells(tolerance, flat)).collect()
    };
    let total = |cells: &[u32]| cells.iter().map(|&n| 2 * u64::from(n).pow(2)).sum::<u64>();
    let mut tolerance = [TOLERANCE, MESH_TOLERANCE * diagonal(mesh)];
    let mut cells = cut(tolerance);
    while total(&cells) > most.max(2 * patches.len() as u64) {
        tolerance = tolerance.map(|tolerance| 2.0 * tolerance);
        cells = cut(tolerance);
    }
    let mut curved = Mesh::default();
    if !patches.is_empty() {
        mesh.patches = (0..mesh.triangles.len() as u32).collect();
    }
    for (&patch, cells) in patches.iter().zip(cells) {
        let [a, b, c, d] = patch;
        match cells {
            1 => {
                mesh.patches.extend([mesh.triangles.len() as u32; 2]);
                mesh.triangles.extend([[a, b, d], [d, c, a]]);
            }
            _ => lattice(mesh, patch, cells, &mut curved),
        }
    }
    curved
}

/// The diagonal of the box around the vertices of a mesh that are finite.
fn diagonal(mesh: &Mesh) -> f64 {
    let finite = mesh.positions.iter().map(|p| Vec3::from(*p)).filter(|p| p.is_finite());
    let (low, high) =
        finite.fold((Vec3::MAX, Vec3::MIN), |(low, high), p| (low.min(p), high.max(p)));
    low.as_dvec3().distance(high.as_dvec3())
}

fn points(mesh: &Mesh, patch: [u32; 4]) -> Corners {
    Corners(patch.map(|i| Vec3::from(mesh.positions[i as usize]).as_dvec3()))
}

/// Adds a patch as a lattice of cells to a mesh.
fn lattice(from: &Mesh, patch: [u32; 4], cells: u32, to: &mut Mesh) {
    let points = points(from, patch);
    let normals = (!from.normals.is_empty())
        .then(|| Corners(patch.map(|i| Vec3::from(from.normals[i as usize]).as_dvec3())));
    let uvs = match from.uvs.is_empty() {
        true => [DVec2::ZERO, DVec2::X, DVec2::Y, DVec2::ONE],
        false => patch.map(|i| Vec2::from(from.uvs[i as usize]).as_dvec2()),
    };
    let first = to.positions.len() as u32;
    for row in 0..=cells {
        for column in 0..=cells {
            let [u, v] = [column, row].map(|i| f64::from(i) / f64::from(cells));
            let normal = match &normals {
                Some(normals) => normals.at(u, v),
                None => points.normal(u, v),
            };
            let uv = uvs[0].lerp(uvs[1], u).lerp(uvs[2].lerp(uvs[3], u), v);
            to.positions.push(points.at(u, v).as_vec3().to_array());
            to.normals.push(normal.normalize_or_zero().as_vec3().to_array());
            to.uvs.push(uv.as_vec2().to_array());
        }
    }
    let whole = [to.triangles.len() as u32; 2];
    for row in 0..cells {
        for column in 0..cells {
            to.patches.extend(whole);
            let a = first + row * (cells + 1) + column;
            let c = a + cells + 1;
            to.triangles.extend([[a, a + 1, c + 1], [c + 1, c, a]]);
        }
    }
}
