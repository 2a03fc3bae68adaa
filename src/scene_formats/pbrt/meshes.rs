//! Shapes that become meshes: triangle meshes, bilinear patches, subdivision surfaces, PLY files.

use std::path::Path;

use super::memory::{MeshSize, require_memory};
use super::parametric_shapes::{height_field, hyperboloid, nurbs, paraboloid};
use super::params::Params;
use super::{SceneError, WarningLog, resolve};
use crate::ply;
use crate::ply::{PlyError, PlyMeshes};
use petzval_base::io::ReadContext;
use petzval_scene::{Mesh, PatchMesh, split_patches, subdivide};

/// The kinds of meshes.
#[derive(Clone, Copy)]
pub(super) enum MeshKind {
    Triangles,
    BilinearPatches,
    LoopSubdivision,
    Paraboloid,
    Hyperboloid,
    HeightField,
    Nurbs,
}

/// Limit of the triangles of a subdivision surface.
const MAX_SUBDIVIDED: u64 = 1 << 25;

/// Makes the triangles and the patches of a shape.
pub(super) fn make(
    kind: MeshKind,
    params: &Params,
    warnings: &mut WarningLog,
) -> Result<(Mesh, PatchMesh), SceneError> {
    let triangles = match kind {
        MeshKind::Triangles => triangle_mesh(params)?,
        MeshKind::BilinearPatches => return bilinear_patches(params),
        MeshKind::LoopSubdivision => subdivision(params, warnings)?,
        MeshKind::Paraboloid => paraboloid(params)?,
        MeshKind::Hyperboloid => hyperboloid(params)?,
        MeshKind::HeightField => height_field(params)?,
        MeshKind::Nurbs => nurbs(params)?,
    };
    Ok((triangles, PatchMesh::default()))
}

/// Returns a mesh of the given vertices, without triangles, and the `N` corners of each face.
fn vertices<const N: usize>(params: &Params) -> Result<(Mesh, Vec<[u32; N]>), SceneError> {
    let Some(points) = params.numbers("P", &["point3"])? else {
        return Err(params.refuse("P", "a mesh without \"point3 P\"", "expected its vertices"));
    };
    let mut mesh = Mesh { positions: triples(points), ..Mesh::default() };
    let count = mesh.positions.len();
    let faces = match params.numbers("indices", &["integer"])? {
        Some(indices) => faces(params, indices, count)?,
        None if count == N => vec![std::array::from_fn(|i| i as u32)],
        None => {
            return Err(params.refuse(
                "indices",
                "a mesh without \"integer indices\"",
                "expected its faces",
            ));
        }
    };
    if let Some(normals) = params.numbers("N", &["normal"])? {
        mesh.normals = triples(normals);
        require_each(params, "N", mesh.normals.len(), count)?;
    }
    for name in ["uv", "st"] {
        if let Some(uvs) = params.numbers(name, &["point2", "float"])? {
            mesh.uvs = uvs.as_chunks::<2>().0.iter().map(|uv| uv.map(|v| v as f32)).collect();
            require_each(params, name, mesh.uvs.len(), count)?;
        }
    }
    Ok((mesh, faces))
}

fn triples(numbers: &[f64]) -> Vec<[f32; 3]> {
    numbers.as_chunks::<3>().0.iter().map(|p| p.map(|v| v as f32)).collect()
}

/// Requires that a parameter has one value for each of `count` points.
fn require_each(params: &Params, name: &str, found: usize, count: usize) -> Result<(), SceneError> {
    if found == count {
        return Ok(());
    }
    let found = format!("{found} values of \"{name}\" for {count} points");
    Err(params.refuse(name, found, "expected one for each point"))
}

fn faces<const N: usize>(
    params: &Params,
    indices: &[f64],
    count: usize,
) -> Result<Vec<[u32; N]>, SceneError> {
    let (faces, []) = indices.as_chunks::<N>() else {
        let found = format!("{} indices", indices.len());
        return Err(params.refuse("indices", found, format!("expected {N} for each face")));
    };
    let valid = |v: f64| v.fract() == 0.0 && (0.0..count as f64).contains(&v);
    if let Some(wrong) = indices.iter().find(|&&v| !valid(v)) {
        let found = format!("the index {wrong}");
        return Err(params.refuse(
            "indices",
            found,
            format!("expected indices from 0 to below {count}"),
        ));
    }
    Ok(faces.iter().map(|face| face.map(|v| v as u32)).collect())
}

fn triangle_mesh(params: &Params) -> Result<Mesh, SceneError> {
    let (mut mesh, triangles) = vertices(params)?;
    if let Some(tangents) = params.numbers("S", &["vector3", "vector"])? {
        mesh.tangents = triples(tangents);
        require_each(params, "S", mesh.tangents.len(), mesh.positions.len())?;
    }
    Ok(Mesh { triangles, ..mesh })
}

fn bilinear_patches(params: &Params) -> Result<(Mesh, PatchMesh), SceneError> {
    let (mut mesh, mut patches) = vertices::<4>(params)?;
    if mesh.uvs.is_empty() {
        // Each patch covers the unit square, so that patches share no vertices.
        let shared = std::mem::take(&mut mesh);
        for patch in &mut patches {
            for (corner, uv) in
                [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].into_iter().enumerate()
            {
                let vertex = patch[corner] as usize;
                patch[corner] = mesh.positions.len() as u32;
                mesh.positions.push(shared.positions[vertex]);
                mesh.normals.extend(shared.normals.get(vertex));
                mesh.uvs.push(uv);
            }
        }
    }
    let curved = split_patches(&mut mesh, &patches);
    Ok((mesh, curved))
}

fn subdivision(params: &Params, warnings: &mut WarningLog) -> Result<Mesh, SceneError> {
    let name = if params.find("levels").is_some() { "levels" } else { "nlevels" };
    let levels = params.float(name, 3.0)?;
    let (mesh, triangles) = vertices(params)?;
    let max_factor = MAX_SUBDIVIDED / triangles.len().max(1) as u64;
    if levels < 0.0 || levels.fract() != 0.0 || 4f64.powf(levels) > max_factor as f64 {
        let found = format!("{} triangles refined {levels} times", triangles.len());
        let expected =
            "expected a whole number of levels, and at most 33 million triangles in the end";
        return Err(params.refuse(name, found, expected));
    }
    let refined = triangles.len() as u64 * 4u64.pow(levels as u32);
    let what = format!("{refined} triangles");
    // The mesh has half as many vertices as triangles, and a second copy of them for a time.
    let _held = require_memory(params, &what, MeshSize { vertices: refined, triangles: refined })?;
    let mesh = Mesh { positions: mesh.positions, triangles, ..Mesh::default() };
    subdivide(&mesh, levels as u32).or_else(|why| {
        let feature = format!("a loopsubdiv where {why}");
        warnings.unsupported(&params.at, &feature, "it is not refined");
        Ok(mesh)
    })
}

/// Reads the triangles and patches of a PLY file.
pub(super) fn ply_mesh(params: &Params) -> Result<PlyMeshes, SceneError> {
    read_ply(params, ply::read)
}

/// Reads a PLY file as triangles.
pub(super) fn ply_triangles(params: &Params) -> Result<Mesh, SceneError> {
    read_ply(params, ply::read_triangles)
}

fn read_ply<T>(
    params: &Params,
    read: impl FnOnce(&Path, &ReadContext) -> Result<T, PlyError>,
) -> Result<T, SceneError> {
    let Some(name) = params.text("filename")? else {
        return Err(params.refuse(
            "filename",
            "a plymesh without \"string filename\"",
            "expected the name of a file",
        ));
    };
    read(&resolve(&params.folder, name), &params.context).map_err(|source| {
        let at = params.location("filename");
        SceneError::Mesh { at, source }
    })
}
