//! Scenes and nodes, and what nodes hold: meshes, cameras and lights.

use std::collections::BTreeMap;

use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::Value;

use super::{Index, Integer};

#[derive(Deserialize)]
pub struct Scene {
    pub nodes: Vec<Index>,
}

#[derive(Deserialize)]
pub struct Node {
    pub name: Option<String>,
    pub camera: Option<Index>,
    pub children: Option<Vec<Index>>,
    /// Column by column.
    pub matrix: Option<[f32; 16]>,
    pub mesh: Option<Index>,
    /// Quaternion x, y, z, w.
    pub rotation: Option<[f32; 4]>,
    pub scale: Option<[f32; 3]>,
    pub translation: Option<[f32; 3]>,
    pub weights: Option<IgnoredAny>,
    pub extensions: Option<NodeExtensions>,
}

#[derive(Deserialize)]
pub struct NodeExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub light: Option<NodeLight>,
    #[serde(rename = "EXT_mesh_gpu_instancing")]
    pub instancing: Option<Value>,
}

#[derive(Deserialize)]
pub struct NodeLight {
    pub light: Index,
}

#[derive(Deserialize)]
pub struct Mesh {
    pub name: Option<String>,
    pub primitives: Vec<Primitive>,
}

#[derive(Deserialize)]
pub struct Primitive {
    pub attributes: BTreeMap<String, Index>,
    pub indices: Option<Index>,
    pub material: Option<Index>,
    pub mode: Option<Integer>,
    pub targets: Option<IgnoredAny>,
    pub extensions: Option<BTreeMap<String, IgnoredAny>>,
}

#[derive(Deserialize)]
pub struct Camera {
    #[serde(rename = "type")]
    pub kind: String,
    pub perspective: Option<Perspective>,
    pub orthographic: Option<Orthographic>,
}

#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Perspective {
    pub aspect_ratio: Option<f32>,
    /// Vertical field of view (rad).
    pub yfov: f32,
}

#[derive(Deserialize)]
pub struct Orthographic {
    pub xmag: f32,
    pub ymag: f32,
}

/// A light of the extension KHR_lights_punctual.
#[derive(Deserialize)]
pub struct Light {
    #[serde(rename = "type")]
    pub kind: String,
    #[serde(default = "white")]
    pub color: [f32; 3],
    #[serde(default = "one")]
    pub intensity: f32,
    pub range: Option<f32>,
    pub spot: Option<Spot>,
}

fn white() -> [f32; 3] {
    [1.0; 3]
}

fn one() -> f32 {
    1.0
}

#[derive(Deserialize)]
#[serde(default, rename_all = "camelCase")]
pub struct Spot {
    /// Angles between the axis and the cones (rad).
    pub inner_cone_angle: f32,
    pub outer_cone_angle: f32,
}

impl Default for Spot {
    fn default() -> Self {
        Self { inner_cone_angle: 0.0, outer_cone_angle: std::f32::consts::FRAC_PI_4 }
    }
}
