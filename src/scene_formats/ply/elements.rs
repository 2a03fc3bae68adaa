//! Vertices and faces of a PLY file.

use super::header::PlyElement;
use super::polygons::Polygon;
use super::values::ValueReader;
use petzval_base::io::HeldMemory;
use petzval_scene::Mesh;

/// Reads vertices: positions, and normals and texture coordinates if all their components are
/// given.
pub(super) fn read_vertices(
    element: &PlyElement,
    values: &mut ValueReader,
    mesh: &mut Mesh,
) -> Result<(), String> {
    // The place of each property in a row: position, normal, texture coordinates.
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
        return Err("the vertices lack x, y or z".to_owned());
    }
    let (normals, uvs) = (has(3..6), has(6..8));
    mesh.positions.reserve_exact(element.count);
    for _ in 0..element.count {
        let mut row = [0.0f32; 8];
        for (property, slot) in element.properties.iter().zip(&slots) {
            if let Some(length) = property.length {
                for _ in 0..values.list_length(length)? {
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

/// The faces of a PLY file.
#[derive(Default)]
pub(super) struct Faces {
    /// Triangles, and the fans of `polygons`.
    pub(super) triangles: Vec<[u32; 3]>,
    /// Faces of four corners, in the order of bilinear patches.
    pub(super) quads: Vec<[u32; 4]>,
    /// Faces of more corners.
    pub(super) polygons: Vec<Polygon>,
}

/// Reads faces. Faces of fewer than three corners are left out. The memory of polygons is added to `held`.
pub(super) fn read_faces(
    element: &PlyElement,
    values: &mut ValueReader,
    faces: &mut Faces,
    held: &mut HeldMemory,
) -> Result<(), String> {
    let mut corners: Vec<u32> = Vec::new();
    for i in 0..element.count {
        for property in &element.properties {
            let count = property.length.map_or(Ok(1), |kind| values.list_length(kind))?;
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
                [a, b, c] => faces.triangles.push([a, b, c]),
                [a, b, c, d] => faces.quads.push([a, b, d, c]),
                [] | [_] | [_, _] => {}
                _ => {
                    let fan = corners.len() * size_of::<[u32; 3]>();
                    held.add((fan + size_of::<Polygon>()) as u64)?;
                    faces.polygons.extend(Polygon::add_fan(&corners, &mut faces.triangles));
                }
            }
        }
    }
    Ok(())
}
