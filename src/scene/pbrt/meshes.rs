//! What becomes a mesh, from its parameters: triangles, bilinear patches, subdivision surfaces,
//! curves, PLY files.

use std::path::Path;

use super::claims::mesh_fits;
use super::params::Params;
use super::{Notices, SceneError, curves, resolve};
use crate::scene::{Mesh, ply, subdivide, triangulate};

/// Triangles that a subdivision surface may become.
const MOST_TRIANGLES: u64 = 1 << 25;

/// Makes the meshes of a shape; `None` where it is of another kind. Bilinear patches become at most so
/// many triangles.
pub(super) fn make(
    name: &str,
    params: &Params,
    folder: &Path,
    most: u64,
    notices: &mut Notices,
) -> Result<Option<Vec<Mesh>>, SceneError> {
    Ok(Some(match name {
        "trianglemesh" => vec![triangle_mesh(params)?],
        "plymesh" => ply_mesh(params, folder, most)?.into(),
        "bilinearmesh" => patches(params, most)?.into(),
        "curve" => vec![curves::make(params)?],
        "loopsubdiv" => vec![subdivision(params, notices)?],
        _ => return Ok(None),
    }))
}

/// The vertices that a mesh is given, and `N` corners for each of its faces.
fn vertices<const N: usize>(params: &Params) -> Result<(Mesh, Vec<[u32; N]>), SceneError> {
    let Some(points) = params.numbers("P", &["point3"])? else {
        return Err(params.refuse("P", "a mesh without \"point3 P\"", ""));
    };
    let triples = |numbers: &[f64]| -> Vec<[f32; 3]> {
        numbers.as_chunks::<3>().0.iter().map(|p| p.map(|v| v as f32)).collect()
    };
    let mut mesh = Mesh { positions: triples(points), ..Mesh::default() };
    let count = mesh.positions.len();
    let faces = match params.numbers("indices", &["integer"])? {
        Some(indices) => faces(params, indices, count)?,
        None if count == N => vec![std::array::from_fn(|i| i as u32)],
        None => return Err(params.refuse("indices", "a mesh without \"integer indices\"", "")),
    };
    let matching = |name: &str, found: usize| {
        if found == count {
            return Ok(());
        }
        let found = format!("{found} values of \"{name}\" for {count} points");
        Err(params.refuse(name, found, "expected one for each point"))
    };
    if let Some(normals) = params.numbers("N", &["normal"])? {
        mesh.normals = triples(normals);
        matching("N", mesh.normals.len())?;
    }
    for name in ["uv", "st"] {
        if let Some(uvs) = params.numbers(name, &["point2", "float"])? {
            mesh.uvs = uvs.as_chunks::<2>().0.iter().map(|uv| uv.map(|v| v as f32)).collect();
            matching(name, mesh.uvs.len())?;
        }
    }
    Ok((mesh, faces))
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
        return Err(params.refuse("indices", found, format!("there are {count} points, from 0")));
    }
    Ok(faces.iter().map(|face| face.map(|v| v as u32)).collect())
}

fn triangle_mesh(params: &Params) -> Result<Mesh, SceneError> {
    let (mesh, triangles) = vertices(params)?;
    Ok(Mesh { triangles, ..mesh })
}

fn patches(params: &Params, most: u64) -> Result<[Mesh; 2], SceneError> {
    let (mut mesh, mut patches) = vertices::<4>(params)?;
    if mesh.uvs.is_empty() {
        // Each patch has its own corners of the unit square.
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
    let curved = triangulate(&mut mesh, &patches, most);
    Ok([mesh, curved])
}

fn subdivision(params: &Params, notices: &mut Notices) -> Result<Mesh, SceneError> {
    let name = if params.find("levels").is_some() { "levels" } else { "nlevels" };
    let levels = params.float(name, 3.0)?;
    let (mesh, triangles) = vertices(params)?;
    let most = MOST_TRIANGLES / triangles.len().max(1) as u64;
    if levels < 0.0 || levels.fract() != 0.0 || 4f64.powf(levels) > most as f64 {
        let found = format!("{} triangles refined {levels} times", triangles.len());
        let expected = "expected a whole number of times, and at most 33 million in the end";
        return Err(params.refuse(name, found, expected));
    }
    let refined = triangles.len() as u64 * 4u64.pow(levels as u32);
    let what = format!("{refined} triangles");
    // There are half as many vertices, and twice those while they are moved.
    mesh_fits(&params.at, &what, [refined, refined])?;
    let mesh = Mesh { positions: mesh.positions, triangles, ..Mesh::default() };
    subdivide(&mesh, levels as u32).or_else(|why| {
        notices.instead(&params.at, &format!("a loopsubdiv where {why}"), "it is not refined");
        Ok(mesh)
    })
}

fn ply_mesh(params: &Params, folder: &Path, most: u64) -> Result<[Mesh; 2], SceneError> {
    let Some(name) = params.text("filename")? else {
        return Err(params.refuse("filename", "a plymesh without \"string filename\"", ""));
    };
    ply::read(&resolve(folder, name), most).map_err(|source| {
        let at = params.find("filename").map_or(&params.at, |param| &param.at);
        SceneError::Mesh { at: at.clone(), source }
    })
}
