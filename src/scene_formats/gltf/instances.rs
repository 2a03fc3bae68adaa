//! Instances of the extension EXT_mesh_gpu_instancing.

use std::collections::BTreeMap;

use glam::{DAffine3, DQuat, DVec3};
use serde::Deserialize;

use super::document::Document;
use super::schema::{Index, Node};
use crate::pbrt::SceneError;
use petzval_base::io::HeldMemory;

/// The extension.
#[derive(Deserialize)]
struct Instancing {
    attributes: BTreeMap<String, Index>,
}

/// Returns the poses of the copies of a node's mesh, in the space of the node; one if the node has
/// no such extension. Their memory is added to `held`.
pub(super) fn copies(
    document: &Document,
    node: &Node,
    element: &str,
    held: &mut HeldMemory,
) -> Result<Vec<DAffine3>, SceneError> {
    let name = "EXT_mesh_gpu_instancing";
    let value = node.extensions.as_ref().and_then(|all| all.instancing.as_ref());
    let Some(value) = value else { return Ok(vec![DAffine3::IDENTITY]) };
    let element = format!("{element}/extensions/{name}");
    let instancing = Instancing::deserialize(value).map_err(|error| {
        document.error(&element, error.to_string(), "expected the attributes of instances")
    })?;
    let named_at = |name: &str| format!("{element}/attributes/{name}");
    let find = |name: &str| instancing.attributes.get(name).copied();
    let mut vectors = |name: &str| -> Result<Option<Vec<[f32; 3]>>, SceneError> {
        find(name).map(|index| document.vectors(index, &named_at(name), held)).transpose()
    };
    let (translations, scales) = (vectors("TRANSLATION")?, vectors("SCALE")?);
    let rotations: Option<Vec<[f32; 4]>> = find("ROTATION")
        .map(|index| document.vectors(index, &named_at("ROTATION"), held))
        .transpose()?;
    let lengths = [
        translations.as_ref().map(Vec::len),
        scales.as_ref().map(Vec::len),
        rotations.as_ref().map(Vec::len),
    ];
    let mut given = lengths.into_iter().flatten();
    let count = given.next().unwrap_or(0);
    if given.any(|other| other != count) {
        let expected = "expected as many of each attribute";
        return Err(document.error(&element, "attributes of different counts", expected));
    }
    held.add((size_of::<DAffine3>() * count) as u64)
        .map_err(|refusal| document.too_large(&element, &refusal))?;
    let triple = |all: &Option<Vec<[f32; 3]>>, i: usize, default: DVec3| {
        all.as_ref().map_or(default, |all| DVec3::from_array(all[i].map(f64::from)))
    };
    let pose = |i: usize| {
        let rotation = rotations.as_ref().map_or(DQuat::IDENTITY, |all| quaternion(all[i]));
        let scale = triple(&scales, i, DVec3::ONE);
        DAffine3::from_scale_rotation_translation(
            scale,
            rotation,
            triple(&translations, i, DVec3::ZERO),
        )
    };
    Ok((0..count).map(pose).collect())
}

/// Returns the rotation of four numbers x, y, z and w of any length.
pub(super) fn quaternion(numbers: [f32; 4]) -> DQuat {
    let whole = DQuat::from_array(numbers.map(f64::from));
    if whole.length_squared() > 0.0 { whole.normalize() } else { DQuat::IDENTITY }
}
