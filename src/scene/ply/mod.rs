//! Reader of triangle and quad meshes in PLY files, ascii and binary.
//!
//! Reasons for a reader of our own: millions of faces are read directly into the arrays of a mesh,
//! declared sizes are checked against the file before memory is allocated, and every error states
//! its position.

mod elements;
mod header;
mod values;

use std::path::{Path, PathBuf};

use super::geometry::{Mesh, PatchMesh, split_patches};
use crate::io::{ReadContext, path_excerpt};
use elements::{read_faces, read_vertices};
use header::{Encoding, Header, parse_header};
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
    let (mut mesh, mut quads) = (Mesh::default(), Vec::new());
    let mut declared = 0u64;
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
        // The owner of the mesh claims its memory; this only keeps allocations within the budget.
        declared = declared.saturating_add((element.count as u64).saturating_mul(columns));
        context.check(declared)?;
        match element.name.as_str() {
            "vertex" => read_vertices(element, &mut values, &mut mesh)?,
            "face" => read_faces(element, &mut values, &mut mesh, &mut quads, context)?,
            _ => skip_element(element, &mut values)?,
        }
    }
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
    Ok((mesh, quads))
}

#[cfg(test)]
mod tests {
    use super::elements::bisect_polygon;
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
    fn a_polygon_of_many_corners_becomes_triangles_of_its_own_area() {
        let corners: Vec<u32> = (0..1000).collect();
        let mut triangles = Vec::new();
        bisect_polygon(&corners, &mut triangles);
        assert_eq!(triangles.len(), 998);
        let at = |i: u32| glam::DVec2::from_angle(f64::from(i) * std::f64::consts::TAU / 1000.0);
        let area = |[a, b, c]: [u32; 3]| (at(b) - at(a)).perp_dot(at(c) - at(a)) / 2.0;
        assert!(triangles.iter().all(|&t| area(t) > 0.0), "they turn as the polygon does");
        let sum: f64 = triangles.iter().map(|&t| area(t)).sum();
        let exact = 500.0 * (std::f64::consts::TAU / 1000.0).sin();
        assert!((sum - exact).abs() < 1e-9, "{sum} of {exact}");
        // Of a fan, each would be as long as the polygon.
        let short = triangles.iter().filter(|t| at(t[0]).distance(at(t[2])) < 0.1).count();
        assert!(short > 800, "{short}");
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
