//! Shapes from their parameters.

use std::f64::consts::TAU;
use std::path::Path;

use glam::DAffine3;

use super::params::Params;
use super::{Notices, SceneError, meshes};
use crate::scene::{Form, Geometry, Mesh, Quadric};

/// Makes a shape, of one part or more; none where it is flattened to nothing.
pub(super) fn make(
    name: &str,
    params: &Params,
    ctm: &DAffine3,
    reversed: bool,
    folder: &Path,
    most: u64,
    notices: &mut Notices,
) -> Result<Vec<Geometry>, SceneError> {
    if let Some(mut meshes) = meshes::make(name, params, folder, most, notices)? {
        let all: usize = meshes.iter().map(|mesh| mesh.triangles.len()).sum();
        let dropped: usize = meshes.iter_mut().map(Mesh::drop_non_finite).sum();
        if dropped > 0 {
            let found = format!("{dropped} of the {all} triangles of a {name}");
            let why = "have vertices that are not finite numbers: they are left out";
            notices.note(&params.at, format!("{found} {why}"));
        }
        for mesh in &mut meshes {
            mesh.transform(ctm, reversed);
            if !mesh.positions.iter().flatten().all(|v| v.is_finite()) {
                let found = "a mesh that its transform throws out of range";
                return Err(SceneError::at(params.at.clone(), found, "check the transform"));
            }
        }
        meshes.retain(|mesh| !mesh.triangles.is_empty());
        return Ok(meshes.into_iter().map(Geometry::Mesh).collect());
    }
    let phi_max = params.positive("phimax", 360.0)?.min(360.0).to_radians();
    let phi_max = if phi_max > TAU - 1e-9 { TAU } else { phi_max };
    let Some(quadric) = Quadric::new(form(name, params)?, phi_max, *ctm, reversed) else {
        let what = format!("a {name} that its transform flattens");
        notices.instead(&params.at, &what, "it is left out");
        return Ok(Vec::new());
    };
    Ok(vec![Geometry::Quadric(quadric)])
}

fn form(name: &str, params: &Params) -> Result<Form, SceneError> {
    let radius = params.positive("radius", 1.0)?;
    let heights = |[low, high]: [f64; 2]| -> Result<[f64; 2], SceneError> {
        let z = [params.float("zmin", low)?, params.float("zmax", high)?];
        Ok([z[0].min(z[1]), z[0].max(z[1])])
    };
    let flat = |found: &str| params.refuse("zmin", found, "zmin below zmax");
    Ok(match name {
        "sphere" => {
            let z = heights([-radius, radius])?.map(|z| z.clamp(-radius, radius));
            if z[0] == z[1] {
                return Err(flat("a sphere of no height"));
            }
            Form::Sphere { radius, z }
        }
        "cylinder" => {
            let z = heights([-1.0, 1.0])?;
            if z[0] == z[1] {
                return Err(flat("a cylinder of no height"));
            }
            Form::Cylinder { radius, z }
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
    })
}
