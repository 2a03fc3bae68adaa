//! Shapes from their parameters.

use std::f64::consts::TAU;
use std::path::Path;

use glam::DAffine3;

use super::SceneError;
use super::params::Params;
use crate::scene::{Form, Geometry, Mesh, Quadric, ply};

/// Makes a shape; `None` where it is flattened to nothing.
pub(super) fn make(
    name: &str,
    params: &Params,
    ctm: &DAffine3,
    reversed: bool,
    folder: &Path,
) -> Result<Option<Geometry>, SceneError> {
    let mesh = match name {
        "trianglemesh" => Some(triangle_mesh(params)?),
        "plymesh" => Some(ply_mesh(params, folder)?),
        _ => None,
    };
    if let Some(mut mesh) = mesh {
        mesh.transform(ctm, reversed);
        if !mesh.positions.iter().flatten().all(|v| v.is_finite()) {
            let found = "a mesh that its transform throws out of range";
            return Err(SceneError::at(params.at.clone(), found, "check the transform"));
        }
        return Ok(Some(Geometry::Mesh(mesh)));
    }
    let phi_max = params.positive("phimax", 360.0)?.min(360.0).to_radians();
    let phi_max = if phi_max > TAU - 1e-9 { TAU } else { phi_max };
    let radius = params.positive("radius", 1.0)?;
    let form = match name {
        "sphere" => {
            let z = [params.float("zmin", -radius)?, params.float("zmax", radius)?];
            let z = [z[0].min(z[1]), z[0].max(z[1])].map(|z| z.clamp(-radius, radius));
            if z[0] == z[1] {
                return Err(params.refuse("zmin", "a sphere of no height", "zmin below zmax"));
            }
            Form::Sphere { radius, z }
        }
        "disk" => {
            let inner = params.float("innerradius", 0.0)?;
            if !(0.0..radius).contains(&inner) {
                let found = format!("an inner radius of {inner}");
                return Err(params.refuse("innerradius", found, "expected 0 to below the radius"));
            }
            Form::Disk { radius, inner, height: params.float("height", 0.0)? }
        }
        _ => {
            let height = params.float("height", 1.0)?;
            if height == 0.0 {
                return Err(params.refuse("height", "a cone of height 0", "a disk is flat"));
            }
            Form::Cone { radius, height }
        }
    };
    Ok(Quadric::new(form, phi_max, *ctm, reversed).map(Geometry::Quadric))
}

fn triangle_mesh(params: &Params) -> Result<Mesh, SceneError> {
    let Some(points) = params.numbers("P", &["point3"])? else {
        return Err(params.refuse("P", "a trianglemesh without \"point3 P\"", ""));
    };
    let triples = |numbers: &[f64]| -> Vec<[f32; 3]> {
        numbers.as_chunks::<3>().0.iter().map(|p| p.map(|v| v as f32)).collect()
    };
    let positions = triples(points);
    let count = positions.len();
    let indices: Vec<f64> = match params.numbers("indices", &["integer"])? {
        Some(indices) => indices.to_vec(),
        None if count == 3 => vec![0.0, 1.0, 2.0],
        None => {
            return Err(params.refuse("indices", "a trianglemesh without \"integer indices\"", ""));
        }
    };
    if !indices.len().is_multiple_of(3) {
        let found = format!("{} indices", indices.len());
        return Err(params.refuse("indices", found, "expected three for each triangle"));
    }
    let valid = |v: f64| v.fract() == 0.0 && (0.0..count as f64).contains(&v);
    if let Some(wrong) = indices.iter().find(|&&v| !valid(v)) {
        let found = format!("the index {wrong}");
        return Err(params.refuse("indices", found, format!("there are {count} points, from 0")));
    }
    let matching = |name: &str, found: usize| {
        if found == count {
            return Ok(());
        }
        let found = format!("{found} values of \"{name}\" for {count} points");
        Err(params.refuse(name, found, "expected one for each point"))
    };
    let mut mesh = Mesh { positions, ..Mesh::default() };
    mesh.triangles = indices.as_chunks::<3>().0.iter().map(|t| t.map(|v| v as u32)).collect();
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
    Ok(mesh)
}

fn ply_mesh(params: &Params, folder: &Path) -> Result<Mesh, SceneError> {
    let Some(name) = params.text("filename")? else {
        return Err(params.refuse("filename", "a plymesh without \"string filename\"", ""));
    };
    ply::read(&folder.join(name)).map_err(|source| {
        let at = params.find("filename").map_or(&params.at, |param| &param.at);
        SceneError::Mesh { at: at.clone(), source }
    })
}
