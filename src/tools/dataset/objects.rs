//! Objects that the pictures of a pair show: names and poses.

use std::collections::{BTreeMap, BTreeSet};

use glam::Affine3A;
use serde_json::{Value, json};

use petzval_base::rays::NO_INDEX;
use petzval_image::ImageLayer;
use petzval_render::aov::Aov;
use petzval_render::job::Job;
use petzval_scene::PlacedShape;

/// Returns the shapes that a layer of objects shows; `None` if there is no such layer.
pub(super) fn seen_in(layers: &[ImageLayer]) -> Option<BTreeSet<PlacedShape>> {
    let layer = layers.iter().find(|layer| layer.name == Aov::Object.name())?;
    let channel = |name: &str| layer.channels.iter().find(|(found, _)| found == name);
    let ((_, shapes), (_, instances)) = (channel("shape")?, channel("instance")?);
    let placed = |(&shape, &instance): (&f32, &f32)| PlacedShape {
        shape: shape as u32,
        instance: if instance < 0.0 { NO_INDEX } else { instance as u32 },
    };
    Some(shapes.iter().zip(instances).filter(|(shape, _)| **shape >= 0.0).map(placed).collect())
}

/// Returns the rows of the objects to which these shapes belong: instances, with all their shapes that are seen, and
/// single shapes. Those stand in the world as the file gives them: their pose is the identity. Those without a name
/// in the file have none.
pub(super) fn rows(job: &Job, seen: &BTreeSet<PlacedShape>) -> Value {
    let time = job.timing.as_ref().map_or(0.0, |timing| timing.first_row_middle()) as f32;
    let mut objects: BTreeMap<(u32, Option<u32>), Vec<PlacedShape>> = BTreeMap::new();
    for &placed in seen {
        let alone = (placed.instance == NO_INDEX).then_some(placed.shape);
        objects.entry((placed.instance, alone)).or_default().push(placed);
    }
    let row = |shapes: &Vec<PlacedShape>| {
        let first = shapes[0];
        let pose = job
            .scene
            .placed_pose(&first, time)
            .map_or(Affine3A::IDENTITY, |pose| pose.world_from_object);
        let columns =
            [pose.matrix3.x_axis, pose.matrix3.y_axis, pose.matrix3.z_axis, pose.translation];
        let pose = [0, 1, 2].map(|row| columns.map(|column| column[row]));
        json!({
            "name": job.scene.given_asset_name(first),
            "shapes": shapes.iter().map(|placed| placed.shape).collect::<Vec<_>>(),
            "instance": if first.instance == NO_INDEX { -1 } else { i64::from(first.instance) },
            "world_from_object": pose,
        })
    };
    objects.values().map(row).collect()
}
