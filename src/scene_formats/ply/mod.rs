//! Reader of triangle and quad meshes in PLY files, ascii and binary.
//!
//! Reasons for a reader of our own: millions of faces are read directly into the arrays of a mesh,
//! declared sizes are checked against the file before memory is allocated, and every error states
//! its position.

mod elements;
mod header;
mod polygons;
mod values;

use std::path::{Path, PathBuf};

use elements::{Faces, read_faces, read_vertices};
use header::{Encoding, Header, parse_header};
use petzval_base::io::{ReadContext, path_excerpt};
use petzval_scene::{Mesh, PatchMesh, split_patches};
use polygons::{split_concave_quad, triangulate};
use values::{ValueReader, skip_element};

/// An error that stops the reading of a PLY file.
#[derive(Debug, thiserror::Error)]
#[error("{}: {found}", path_excerpt(path))]
pub struct PlyError {
    /// The file.
    pub path: PathBuf,
    /// The fault.
    pub found: String,
}

/// The meshes of a PLY file.
pub struct PlyMeshes {
    /// Triangles and flat quads.
    pub flat: Mesh,
    /// Quads that are not flat. They are bilinear patches, as in pbrt-v4.
    pub curved: PatchMesh,
}

/// Reads a PLY file, gzipped or not. Vertices that are not finite are kept.
///
/// # Errors
/// Returns an error if the file cannot be read, is not a PLY file or has no faces.
pub fn read(path: &Path, context: &ReadContext) -> Result<PlyMeshes, PlyError> {
    let (mut mesh, quads) = read_faces_of(path, context)?;
    let curved = split_patches(&mut mesh, &quads);
    Ok(PlyMeshes { flat: mesh, curved })
}

/// Reads a PLY file like [`read`], with two triangles in place of each quad.
///
/// # Errors
/// Returns an error like [`read`].
pub fn read_triangles(path: &Path, context: &ReadContext) -> Result<Mesh, PlyError> {
    let (mut mesh, quads) = read_faces_of(path, context)?;
    mesh.triangles.extend(quads.iter().flat_map(|&[a, b, c, d]| [[a, b, d], [a, d, c]]));
    Ok(mesh)
}

/// Returns the vertices and triangles of a PLY file, and its quads.
fn read_faces_of(path: &Path, context: &ReadContext) -> Result<(Mesh, Vec<[u32; 4]>), PlyError> {
    let refuse = |found: String| PlyError { path: path.to_owned(), found };
    let bytes =
        context.bytes(path).map_err(|error| refuse(format!("cannot read it: {}", error.source)))?;
    parse(&bytes, context).map_err(refuse)
}

fn parse(bytes: &[u8], context: &ReadContext) -> Result<(Mesh, Vec<[u32; 4]>), String> {
    let Header { encoding, elements, size } = parse_header(bytes)?;
    let mut values = ValueReader::new(encoding, bytes, size);
    let (mut mesh, mut faces) = (Mesh::default(), Faces::default());
    let mut held = context.hold(0)?;
    for element in &elements {
        // Even an empty list takes a byte, in ascii two with the space.
        let least: usize =
            element
                .properties
                .iter()
                .map(|p| {
                    if encoding == Encoding::Ascii { 2 } else { p.length.unwrap_or(p.value).size() }
                })
                .sum();
        let left = values.remaining();
        if element.count.saturating_mul(least) > left.saturating_add(1) {
            return Err(format!(
                "{} elements \"{}\" are declared, but only {left} bytes follow",
                element.count, element.name
            ));
        }
        let columns = match element.name.as_str() {
            "vertex" | "face" => size_of::<[f32; 3]>() as u64,
            _ => 0,
        };
        // The owner of the mesh claims its memory; this is held until the mesh is whole.
        held.add((element.count as u64).saturating_mul(columns))?;
        match element.name.as_str() {
            "vertex" => read_vertices(element, &mut values, &mut mesh)?,
            "face" => read_faces(element, &mut values, &mut faces, &mut held)?,
            _ => skip_element(element, &mut values)?,
        }
    }
    let Faces { triangles, mut quads, polygons } = faces;
    mesh.triangles = triangles;
    if mesh.positions.is_empty() || mesh.triangles.is_empty() && quads.is_empty() {
        return Err("the mesh has no vertices or no faces".to_owned());
    }
    let count = mesh.positions.len() as u32;
    if let Some(i) = mesh.triangles.iter().position(|t| t.iter().any(|&v| v >= count)) {
        return Err(format!("a face near number {i} names a vertex that does not exist"));
    }
    if quads.iter().flatten().any(|&v| v >= count) {
        return Err("a quad names a vertex that does not exist".to_owned());
    }
    triangulate(&mut mesh, &polygons);
    // A concave quad as a bilinear patch would fold over.
    quads.retain(|&[a, b, d, c]| {
        let halves = split_concave_quad(&mesh.positions, [a, b, c, d]);
        mesh.triangles.extend(halves.into_iter().flatten());
        halves.is_none()
    });
    Ok((mesh, quads))
}

#[cfg(test)]
mod tests {
    use super::{Mesh, PatchMesh, ReadContext};

    fn parse(bytes: &[u8]) -> Result<(Mesh, PatchMesh), String> {
        let (mut mesh, quads) = super::parse(bytes, &ReadContext::default())?;
        let curved = super::split_patches(&mut mesh, &quads);
        Ok((mesh, curved))
    }

    const ASCII: &str = "ply\nformat ascii 1.0\ncomment a square\nelement vertex 4\n\
        property float x\nproperty float y\nproperty float z\nproperty float u\n\
        property float v\nelement face 1\nproperty list uchar int vertex_indices\nend_header\n\
        0 0 0 0 0\n1 0 0 1 0\n1 1 0 1 1\n0 1 0 0 1\n4 0 1 2 3\n";

    fn binary(big: bool) -> Vec<u8> {
        let format = if big { "binary_big_endian" } else { "binary_little_endian" };
        let mut bytes = ASCII.replace("ascii", format).into_bytes();
        let end = "end_header\n";
        let body = bytes.windows(end.len()).position(|w| w == end.as_bytes()).unwrap() + end.len();
        bytes.truncate(body);
        let order = |mut raw: [u8; 4]| {
            if big {
                raw.reverse();
            }
            raw
        };
        let rows = [[0., 0., 0., 0., 0.], [1., 0., 0., 1., 0.], [1., 1., 0., 1., 1.]];
        for row in rows.into_iter().chain([[0., 1., 0., 0., 1.]]) {
            for value in row {
                bytes.extend(order(f32::to_le_bytes(value)));
            }
        }
        bytes.push(4);
        for index in 0..4i32 {
            bytes.extend(order(index.to_le_bytes()));
        }
        bytes
    }

    #[test]
    fn ascii_and_both_byte_orders_give_the_same_mesh() {
        let (ascii, curved) = parse(ASCII.as_bytes()).unwrap();
        assert_eq!(ascii.triangles, [[0, 1, 2], [2, 3, 0]]);
        assert!(curved.patches.is_empty());
        assert_eq!(ascii.positions[2], [1.0, 1.0, 0.0]);
        assert_eq!(ascii.uvs[3], [0.0, 1.0]);
        assert_eq!(parse(&binary(false)).unwrap().0, ascii);
        assert_eq!(parse(&binary(true)).unwrap().0, ascii);
    }

    #[test]
    fn every_truncation_is_an_error_without_a_panic() {
        for bytes in [ASCII.as_bytes().to_vec(), binary(false), binary(true)] {
            // The ascii file is complete without its last newline.
            for end in 0..bytes.len() - 1 {
                assert!(parse(&bytes[..end]).is_err(), "{end} bytes");
            }
        }
    }

    #[test]
    fn declared_sizes_are_checked_before_memory_is_allocated() {
        let huge = ASCII.replace("vertex 4", "vertex 4000000000000");
        let error = parse(huge.as_bytes()).unwrap_err();
        assert!(error.contains("bytes follow"), "{error}");
        let wild = ASCII.replace("4 0 1 2 3", "4 0 1 2 9");
        assert!(parse(wild.as_bytes()).unwrap_err().contains("vertex that does not exist"));
    }

    #[test]
    fn polygons_become_fans_and_faces_of_two_corners_are_left_out() {
        let faces = ASCII.replace("face 1", "face 3") + "5 0 1 2 3 0\n2 0 1\n";
        let (mesh, _) = parse(faces.as_bytes()).unwrap();
        assert_eq!(mesh.triangles[..3], [[0, 1, 2], [0, 2, 3], [0, 3, 0]]);
        assert_eq!(mesh.triangles.len(), 5);
    }

    #[test]
    fn a_concave_quad_has_its_own_area_whatever_its_first_corner() {
        let arrow = ASCII.replace("1 1 0 1 1", "0.25 0.25 0 1 1");
        for corners in ["0 1 2 3", "1 2 3 0", "2 3 0 1", "3 0 1 2", "3 2 1 0", "0 3 2 1"] {
            let (mesh, curved) =
                parse(arrow.replace("4 0 1 2 3", &format!("4 {corners}")).as_bytes()).unwrap();
            assert!(curved.patches.is_empty());
            let area: f32 = (0..2).map(|i| mesh.area(i)).sum();
            assert!((area - 0.25).abs() < 1e-6, "{corners}: {area}");
            let normal = |i: u32| {
                let [a, b, c] = mesh.corners(i);
                (b - a).cross(c - a).z
            };
            assert!(normal(0) * normal(1) > 0.0, "{corners}: the halves face opposite sides");
        }
    }

    #[test]
    fn faces_may_stand_before_their_vertices() {
        let text = "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_index\n\
            element vertex 5\nproperty float x\nproperty float y\nproperty float z\nend_header\n\
            5 0 1 2 3 4\n0 0 0\n2 0 0\n2 2 0\n1 0.5 0\n0 2 0\n";
        let (mesh, _) = parse(text.as_bytes()).unwrap();
        let area: f32 = (0..3).map(|i| mesh.area(i)).sum();
        assert!((area - 2.5).abs() < 1e-6, "{area}");
    }

    #[test]
    fn lines_may_end_with_carriage_returns() {
        let expected = parse(ASCII.as_bytes()).unwrap().0;
        for end in ["\r", "\r\n"] {
            assert_eq!(parse(ASCII.replace('\n', end).as_bytes()).unwrap().0, expected);
            for big in [false, true] {
                let bytes = binary(big);
                let body = bytes.len() - 4 * 5 * 4 - 17;
                let mut changed = String::from_utf8(bytes[..body].to_vec())
                    .unwrap()
                    .replace('\n', end)
                    .into_bytes();
                changed.extend(&bytes[body..]);
                assert_eq!(parse(&changed).unwrap().0, expected, "{end:?}");
            }
        }
        let wrong = ASCII.replace("1 1 0 1 1", "1 x 0 1 1").replace('\n', "\r");
        assert!(parse(wrong.as_bytes()).unwrap_err().starts_with("line 15: "));
    }

    #[test]
    fn a_quad_without_texture_coordinates_has_those_of_its_patch() {
        let text = ASCII.replace("property float u\nproperty float v\n", "");
        let text = ["0 0 0 0 0", "1 0 0 1 0", "1 1 0 1 1", "0 1 0 0 1"]
            .iter()
            .fold(text, |text, row| text.replace(row, &row[..5]));
        let (mesh, curved) = parse(text.as_bytes()).unwrap();
        assert!(mesh.uvs.is_empty() && curved.patches.is_empty());
        for i in 0..2 {
            let triangle = mesh.triangle(i);
            for (p, uv) in triangle.positions.iter().zip(triangle.uvs) {
                assert_eq!(p[..2], uv);
            }
        }
    }

    #[test]
    fn a_flat_quad_whose_texture_coordinates_are_twisted_is_a_patch() {
        let twisted = ASCII.replace("1 1 0 1 1", "1 1 0 0 1").replace("0 1 0 0 1", "0 1 0 1 1");
        let (mesh, curved) = parse(twisted.as_bytes()).unwrap();
        assert!(mesh.triangles.is_empty());
        assert_eq!(curved.patches.len(), 1);
    }

    #[test]
    fn a_quad_that_is_not_flat_is_a_patch() {
        let bent = ASCII.replace("1 1 0 1 1", "1 1 1 1 1");
        let (mesh, curved) = parse(bent.as_bytes()).unwrap();
        assert!(mesh.triangles.is_empty());
        // The quad runs around: its last corner is that of (0, 1).
        let corners = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [1.0, 1.0, 1.0]];
        assert_eq!(curved.corners(0).map(|p| p.to_array()), corners);
    }
}
