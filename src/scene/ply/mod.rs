//! Triangle and quad meshes in PLY files, ascii and binary.
//!
//! Our own reader, for three reasons: a mesh of millions of faces goes straight into columns,
//! declared sizes are checked against the file before memory is asked for, and every error
//! names its place.

mod header;

use std::path::{Path, PathBuf};

use super::bilinear::triangulate;
use super::mesh::Mesh;
use crate::memory::budget;
use crate::source::{bytes, excerpt, shown};
use header::{Element, Order, Scalar, header};

/// Why a PLY file was refused.
#[derive(Debug, thiserror::Error)]
#[error("{}: {found}", shown(path))]
pub struct PlyError {
    path: PathBuf,
    found: String,
}

/// Reads a mesh, packed by gzip or not. Triangles and flat quads become the first of the two;
/// quads that are not flat are bilinear patches, as in pbrt-v4, and become the second. Vertices that
/// are not finite stay as they are. All quads together become at most so many triangles, or two each.
///
/// # Errors
/// Where the file cannot be read, is no PLY file or holds no triangle mesh.
pub fn read(path: &Path, most: u64) -> Result<[Mesh; 2], PlyError> {
    let refuse = |found: String| PlyError { path: path.to_owned(), found };
    let bytes = bytes(path).map_err(|error| refuse(format!("cannot read it: {}", error.source)))?;
    parse(&bytes, most).map_err(refuse)
}

fn parse(bytes: &[u8], most: u64) -> Result<[Mesh; 2], String> {
    let (order, elements, start) = header(bytes)?;
    let mut values = Values { order, bytes, next: start };
    let (mut mesh, mut quads) = (Mesh::default(), Vec::new());
    let mut declared = 0u64;
    for element in &elements {
        // Even an empty list takes a byte, in ascii two with the blank.
        let least: usize = element
            .properties
            .iter()
            .map(|p| if order == Order::Ascii { 2 } else { p.length.unwrap_or(p.value).bytes() })
            .sum();
        let left = bytes.len() - values.next;
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
        // Whoever keeps the mesh claims it; here nothing may be allocated beyond the budget.
        declared = declared.saturating_add((element.count as u64).saturating_mul(columns));
        budget::fits(declared)?;
        match element.name.as_str() {
            "vertex" => vertices(element, &mut values, &mut mesh)?,
            "face" => faces(element, &mut values, &mut mesh, &mut quads)?,
            _ => skip(element, &mut values)?,
        }
    }
    if mesh.positions.is_empty() || mesh.triangles.is_empty() && quads.is_empty() {
        return Err("no vertices, or no faces".to_owned());
    }
    let count = mesh.positions.len() as u32;
    if let Some(i) = mesh.triangles.iter().position(|t| t.iter().any(|&v| v >= count)) {
        return Err(format!("a face near number {i} names a vertex that is not there"));
    }
    if quads.iter().flatten().any(|&v| v >= count) {
        return Err("a quad names a vertex that is not there".to_owned());
    }
    let curved = triangulate(&mut mesh, &quads, most);
    Ok([mesh, curved])
}

/// The values behind the header, one after another.
struct Values<'a> {
    order: Order,
    bytes: &'a [u8],
    next: usize,
}

impl Values<'_> {
    fn read(&mut self, kind: Scalar) -> Result<f64, String> {
        if self.order == Order::Ascii {
            return self.word();
        }
        let size = kind.bytes();
        let Some(slice) = self.bytes.get(self.next..self.next + size) else {
            return Err("the file ends too early".to_owned());
        };
        self.next += size;
        let mut raw = [0; 8];
        raw[..size].copy_from_slice(slice);
        if self.order == Order::Big {
            raw[..size].reverse();
        }
        let [a, b, c, d, ..] = raw;
        Ok(match kind {
            Scalar::I8 => f64::from(a as i8),
            Scalar::U8 => f64::from(a),
            Scalar::I16 => f64::from(i16::from_le_bytes([a, b])),
            Scalar::U16 => f64::from(u16::from_le_bytes([a, b])),
            Scalar::I32 => f64::from(i32::from_le_bytes([a, b, c, d])),
            Scalar::U32 => f64::from(u32::from_le_bytes([a, b, c, d])),
            Scalar::F32 => f64::from(f32::from_le_bytes([a, b, c, d])),
            Scalar::F64 => f64::from_le_bytes(raw),
        })
    }

    fn word(&mut self) -> Result<f64, String> {
        let rest = &self.bytes[self.next..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace());
        let Some(start) = start else { return Err("the file ends too early".to_owned()) };
        let length = rest[start..].iter().position(u8::is_ascii_whitespace);
        let end = length.map_or(rest.len(), |n| start + n);
        self.next += end;
        let text = String::from_utf8_lossy(&rest[start..end]);
        text.parse().map_err(|_| {
            let line = 1 + self.bytes[..self.next].iter().filter(|&&b| b == b'\n').count();
            format!("line {line}: \"{}\" is no number", excerpt(&text))
        })
    }

    fn length(&mut self, kind: Scalar) -> Result<usize, String> {
        let length = self.read(kind)?;
        if length >= 0.0 && length.fract() == 0.0 && length <= self.bytes.len() as f64 {
            return Ok(length as usize);
        }
        Err(format!("a list of {length} values"))
    }
}

fn skip(element: &Element, values: &mut Values) -> Result<(), String> {
    for _ in 0..element.count {
        for property in &element.properties {
            let count = property.length.map_or(Ok(1), |kind| values.length(kind))?;
            for _ in 0..count {
                values.read(property.value)?;
            }
        }
    }
    Ok(())
}

fn vertices(element: &Element, values: &mut Values, mesh: &mut Mesh) -> Result<(), String> {
    // Where each property goes: position, normal, texture coordinate.
    let slots: Vec<Option<usize>> = element
        .properties
        .iter()
        .map(|p| match p.name.as_str() {
            "x" => Some(0),
            "y" => Some(1),
            "z" => Some(2),
            "nx" => Some(3),
            "ny" => Some(4),
            "nz" => Some(5),
            "u" | "s" | "texture_u" | "texture_s" => Some(6),
            "v" | "t" | "texture_v" | "texture_t" => Some(7),
            _ => None,
        })
        .collect();
    let has = |wanted: std::ops::Range<usize>| wanted.into_iter().all(|i| slots.contains(&Some(i)));
    if !has(0..3) {
        return Err("its vertices lack x, y or z".to_owned());
    }
    let (normals, uvs) = (has(3..6), has(6..8));
    mesh.positions.reserve_exact(element.count);
    for _ in 0..element.count {
        let mut row = [0.0f32; 8];
        for (property, slot) in element.properties.iter().zip(&slots) {
            if let Some(length) = property.length {
                for _ in 0..values.length(length)? {
                    values.read(property.value)?;
                }
                continue;
            }
            let value = values.read(property.value)? as f32;
            if let Some(slot) = slot {
                row[*slot] = value;
            }
        }
        let [x, y, z, nx, ny, nz, u, v] = row;
        mesh.positions.push([x, y, z]);
        if normals {
            mesh.normals.push([nx, ny, nz]);
        }
        if uvs {
            mesh.uvs.push([u, v]);
        }
    }
    Ok(())
}

/// Corners that a polygon may have to become a fan, as most programs have it.
const MOST_FAN: usize = 16;

/// Cuts a polygon in halves until triangles are left. A fan of many corners would be slivers that all
/// lie over each other, on which trees take long to build and to walk.
fn halve(corners: &[u32], triangles: &mut Vec<[u32; 3]>) {
    let mut todo = vec![corners];
    while let Some(part) = todo.pop() {
        let [first, .., last] = *part else { continue };
        let middle = part.len() / 2;
        if part.len() > 2 {
            triangles.push([first, part[middle], last]);
            todo.extend([&part[middle..], &part[..=middle]]);
        }
    }
}

/// Faces become triangles; those of four corners are kept as patches, and more corners make several.
/// A polygon of fewer than three corners is no face.
fn faces(
    element: &Element,
    values: &mut Values,
    mesh: &mut Mesh,
    quads: &mut Vec<[u32; 4]>,
) -> Result<(), String> {
    let mut corners: Vec<u32> = Vec::new();
    for i in 0..element.count {
        for property in &element.properties {
            let count = property.length.map_or(Ok(1), |kind| values.length(kind))?;
            let wanted = matches!(property.name.as_str(), "vertex_indices" | "vertex_index");
            corners.clear();
            for _ in 0..count {
                let value = values.read(property.value)?;
                if wanted {
                    if value < 0.0 || value.fract() != 0.0 || value >= f64::from(u32::MAX) {
                        return Err(format!("face {i} names vertex {value}"));
                    }
                    corners.push(value as u32);
                }
            }
            match corners[..] {
                _ if !wanted => {}
                [a, b, c] => mesh.triangles.push([a, b, c]),
                [a, b, c, d] => quads.push([a, b, d, c]),
                [] | [_] | [_, _] => {}
                [a, ref rest @ ..] if corners.len() <= MOST_FAN => {
                    mesh.triangles.extend(rest.windows(2).map(|edge| [a, edge[0], edge[1]]));
                }
                _ => {
                    let count = (mesh.triangles.len() + corners.len()) as u64;
                    budget::fits(count * size_of::<[u32; 3]>() as u64)?;
                    halve(&corners, &mut mesh.triangles);
                }
            }
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::{Mesh, halve};

    fn parse(bytes: &[u8]) -> Result<[Mesh; 2], String> {
        super::parse(bytes, 1 << 20)
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
    fn ascii_and_both_binary_orders_say_the_same() {
        let [ascii, curved] = parse(ASCII.as_bytes()).unwrap();
        assert_eq!(ascii.triangles, [[0, 1, 2], [2, 3, 0]]);
        assert!(curved.triangles.is_empty());
        assert_eq!(ascii.positions[2], [1.0, 1.0, 0.0]);
        assert_eq!(ascii.uvs[3], [0.0, 1.0]);
        assert_eq!(parse(&binary(false)).unwrap()[0], ascii);
        assert_eq!(parse(&binary(true)).unwrap()[0], ascii);
    }

    #[test]
    fn every_truncation_is_an_error_and_no_panic() {
        for bytes in [ASCII.as_bytes().to_vec(), binary(false), binary(true)] {
            // Without its last newline the ascii file is still whole.
            for end in 0..bytes.len() - 1 {
                assert!(parse(&bytes[..end]).is_err(), "{end} bytes");
            }
        }
    }

    #[test]
    fn declared_sizes_are_checked_before_memory_is_asked_for() {
        let huge = ASCII.replace("vertex 4", "vertex 4000000000000");
        let error = parse(huge.as_bytes()).unwrap_err();
        assert!(error.contains("bytes follow"), "{error}");
        let wild = ASCII.replace("4 0 1 2 3", "4 0 1 2 9");
        assert!(parse(wild.as_bytes()).unwrap_err().contains("vertex that is not there"));
    }

    #[test]
    fn polygons_are_fans_and_what_has_two_corners_is_nothing() {
        let faces = ASCII.replace("face 1", "face 3") + "5 0 1 2 3 0\n2 0 1\n";
        let [mesh, _] = parse(faces.as_bytes()).unwrap();
        assert_eq!(mesh.triangles[..3], [[0, 1, 2], [0, 2, 3], [0, 3, 0]]);
        assert_eq!(mesh.triangles.len(), 5);
    }

    #[test]
    fn a_polygon_of_many_corners_becomes_triangles_of_its_own_area() {
        let corners: Vec<u32> = (0..1000).collect();
        let mut triangles = Vec::new();
        halve(&corners, &mut triangles);
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
        let [mesh, curved] = parse(bent.as_bytes()).unwrap();
        assert!(mesh.triangles.is_empty() && curved.triangles.len() > 100);
        // On the patch z = x y.
        for [x, y, z] in &curved.positions {
            assert!((z - x * y).abs() < 1e-6, "{x} {y} {z}");
        }
    }
}
