//! Meshes: the triangles of a primitive, with normals, tangents and texture coordinates.

use super::document::Document;
use super::schema::Primitive;
use crate::pbrt::SceneError;
use petzval_scene::{Bvh, Mesh};

/// How the indices of a primitive form triangles.
#[derive(Clone, Copy)]
enum Mode {
    Triangles,
    TriangleStrip,
    TriangleFan,
}

/// The mesh of a primitive.
pub(super) struct PrimitiveMesh {
    pub mesh: Mesh,
    /// Side of the tangent of each vertex, if the document gives tangents.
    pub sides: Option<Vec<f32>>,
}

/// A mesh, and the side of its texture coordinates.
pub(super) struct SidedMesh {
    pub mesh: Mesh,
    /// Whether v grows to the other side of u than in an image, as seen from outside.
    pub mirrored: bool,
}

/// Returns whether the vertices of a primitive have colours.
pub(super) fn is_coloured(primitive: &Primitive) -> bool {
    primitive.attributes.contains_key("COLOR_0")
}

/// Reads a primitive. Returns `None` if it has no triangles.
pub(super) fn read_mesh(
    document: &Document,
    primitive: &Primitive,
    element: &str,
    uv_set: u32,
) -> Result<Option<PrimitiveMesh>, SceneError> {
    let mode = match primitive.mode.map(|code| code.0) {
        Some(0..=3) => {
            document.warn(element, "points and lines are not read");
            return Ok(None);
        }
        Some(4) | None => Mode::Triangles,
        Some(5) => Mode::TriangleStrip,
        Some(6) => Mode::TriangleFan,
        Some(_) => {
            let expected = "expected 0 to 6";
            return Err(document.error(&format!("{element}/mode"), "an unknown mode", expected));
        }
    };
    if primitive.extensions.as_ref().is_some_and(|all| !all.is_empty()) {
        document.warn(element, "extensions of a primitive are not read");
    }
    if primitive.targets.is_some() {
        document.warn(element, "morph targets are not read: the mesh has its first form");
    }
    let find = |semantic: &str| primitive.attributes.get(semantic).copied();
    let named_at = |name: &str| format!("{element}/attributes/{name}");
    if find("COLOR_1").is_some() {
        document.warn(&named_at("COLOR_1"), "only the first colours of vertices are read");
    }
    let refused = |refusal: String| document.too_large(element, &refusal);
    let mut held = document.context.hold(0).map_err(refused)?;
    let Some(positions) = find("POSITION") else {
        document.warn(element, "a primitive without positions is left out");
        return Ok(None);
    };
    let positions: Vec<[f32; 3]> = document.vectors(positions, &named_at("POSITION"), &mut held)?;
    let fits = |length: usize, name: &str| match length == positions.len() {
        true => Ok(()),
        false => {
            let found = format!("{length} elements");
            let expected = format!("there are {} positions", positions.len());
            Err(document.error(&named_at(name), found, &expected))
        }
    };
    let normals: Vec<[f32; 3]> = match find("NORMAL") {
        Some(normals) => document.vectors(normals, &named_at("NORMAL"), &mut held)?,
        None => Vec::new(),
    };
    let tangents: Vec<[f32; 4]> = match find("TANGENT") {
        Some(tangents) if !normals.is_empty() => {
            document.vectors(tangents, &named_at("TANGENT"), &mut held)?
        }
        _ => Vec::new(),
    };
    let uv_name = format!("TEXCOORD_{uv_set}");
    let uvs: Vec<[f32; 2]> = match find(&uv_name) {
        Some(uvs) => document.vectors(uvs, &named_at(&uv_name), &mut held)?,
        None => Vec::new(),
    };
    let colours = match find("COLOR_0") {
        Some(colours) => document.colours(colours, &named_at("COLOR_0"), &mut held)?,
        None => Vec::new(),
    };
    for (length, name) in [
        (normals.len(), "NORMAL"),
        (tangents.len(), "TANGENT"),
        (uvs.len(), &uv_name),
        (colours.len(), "COLOR_0"),
    ] {
        if length > 0 {
            fits(length, name)?;
        }
    }
    let indices = match primitive.indices {
        Some(indices) => document.indices(indices, &format!("{element}/indices"), &mut held)?,
        None => {
            held.add(size_of::<u32>() as u64 * positions.len() as u64).map_err(refused)?;
            (0..u32::try_from(positions.len()).unwrap_or(u32::MAX)).collect()
        }
    };
    if let Some(&index) = indices.iter().find(|&&index| index as usize >= positions.len()) {
        let expected = format!("there are {} positions", positions.len());
        let found = format!("an index of {index}");
        return Err(document.error(&format!("{element}/indices"), found, &expected));
    }
    // Strips and fans have a triangle for each index; tangents become vectors and sides.
    let triangles_size = (size_of::<[u32; 3]>() * indices.len()) as u64;
    held.add(triangles_size + size_of_val(&tangents[..]) as u64).map_err(refused)?;
    let triangles = triangles(&indices, mode);
    if triangles.is_empty() {
        return Ok(None);
    }
    // Normals and tangents of quantized meshes are not quite of unit length.
    let normals = normals.into_iter().map(unit).collect();
    let sides = (!tangents.is_empty()).then(|| tangents.iter().map(|t| t[3]).collect());
    let tangents = tangents.iter().map(|&[x, y, z, _]| [x, y, z]).collect();
    let mesh = Mesh { positions, triangles, normals, tangents, uvs, colours, ..Mesh::default() };
    let tree = Bvh::BYTES_PER_PRIMITIVE + Bvh::BUILD_BYTES_PER_PRIMITIVE;
    let bytes = mesh.bytes() + mesh.triangles.len() as u64 * tree;
    held.keep(bytes).map_err(refused)?;
    Ok(Some(PrimitiveMesh { mesh, sides }))
}

fn unit(v: [f32; 3]) -> [f32; 3] {
    let length = v.iter().map(|x| x * x).sum::<f32>().sqrt();
    if length > 0.0 { v.map(|x| x / length) } else { v }
}

/// Returns the triangles of a list, a strip or a fan.
fn triangles(indices: &[u32], mode: Mode) -> Vec<[u32; 3]> {
    match mode {
        Mode::TriangleStrip => indices
            .windows(3)
            .enumerate()
            .map(|(i, w)| if i % 2 == 0 { [w[0], w[1], w[2]] } else { [w[1], w[0], w[2]] })
            .collect(),
        Mode::TriangleFan => match indices {
            [first, rest @ ..] => rest.windows(2).map(|pair| [*first, pair[0], pair[1]]).collect(),
            [] => Vec::new(),
        },
        Mode::Triangles => indices.as_chunks::<3>().0.to_vec(),
    }
}

/// Splits a mesh by the side of its texture coordinates, on which the y axis of a normal map
/// depends. `sides` is the side of the tangent of each vertex, if the document gives tangents.
pub(super) fn split_by_side(mesh: Mesh, sides: Option<&[f32]>) -> Vec<SidedMesh> {
    if mesh.uvs.is_empty() {
        return vec![SidedMesh { mesh, mirrored: false }];
    }
    let is_mirrored = |triangle: &[u32; 3]| match sides {
        Some(sides) => sides[triangle[0] as usize] < 0.0,
        None => {
            let [a, b, c] = triangle.map(|i| mesh.uvs[i as usize]);
            let [u1, v1] = [b[0] - a[0], b[1] - a[1]];
            let [u2, v2] = [c[0] - a[0], c[1] - a[1]];
            // v grows downwards, so that triangles turn the other way in an upright image.
            u1 * v2 - u2 * v1 > 0.0
        }
    };
    let (mirrored, upright): (Vec<_>, Vec<_>) = mesh.triangles.iter().partition(|t| is_mirrored(t));
    match (upright.is_empty(), mirrored.is_empty()) {
        (_, true) => vec![SidedMesh { mesh, mirrored: false }],
        (true, false) => vec![SidedMesh { mesh, mirrored: true }],
        (false, false) => [(upright, false), (mirrored, true)]
            .into_iter()
            .map(|(triangles, mirrored)| SidedMesh {
                mesh: Mesh { triangles, ..mesh.clone() },
                mirrored,
            })
            .collect(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn strips_and_fans_keep_the_winding() {
        let indices = [0, 1, 2, 3, 4];
        assert_eq!(triangles(&indices, Mode::Triangles), [[0, 1, 2]]);
        assert_eq!(triangles(&indices, Mode::TriangleStrip), [[0, 1, 2], [2, 1, 3], [2, 3, 4]]);
        assert_eq!(triangles(&indices, Mode::TriangleFan), [[0, 1, 2], [0, 2, 3], [0, 3, 4]]);
        assert!(triangles(&[], Mode::TriangleFan).is_empty());
    }

    #[test]
    fn a_mesh_with_mirrored_halves_is_split() {
        // Two triangles in the plane z = 0, whose images are mirrored to each other.
        let mesh = Mesh {
            positions: vec![[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0]],
            triangles: vec![[0, 1, 2], [0, 2, 3]],
            uvs: vec![[0.0, 1.0], [1.0, 1.0], [0.0, 0.0], [1.0, 1.0]],
            ..Mesh::default()
        };
        let parts = split_by_side(mesh.clone(), None);
        let found: Vec<_> = parts.iter().map(|p| (p.mesh.triangles.clone(), p.mirrored)).collect();
        assert_eq!(found, [(vec![[0, 1, 2]], false), (vec![[0, 2, 3]], true)]);
        // The document's own tangents decide if there are any.
        let parts = split_by_side(mesh, Some(&[-1.0; 4]));
        assert!(parts.len() == 1 && parts[0].mirrored);
    }
}
