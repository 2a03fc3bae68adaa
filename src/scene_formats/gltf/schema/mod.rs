//! Parts of the JSON schema of glTF 2.0 that are read; unknown keys are skipped.
//!
//! Fields have the names of the specification, in Rust's case. Values that only some readers need are
//! checked where they are used, so that messages name their place.

mod accessor;
mod material;
mod node;
mod number;

use serde::Deserialize;
use serde::de::IgnoredAny;

pub(super) use accessor::{Accessor, Buffer, BufferView, ComponentType};
pub(super) use material::{
    Image, Ior, Material, MaterialExtensions, Sampler, Texture, TextureInfo, TextureTransform,
    Volume,
};
pub(super) use node::{Camera, Light, Mesh, Node, Primitive, Scene};
pub(super) use number::{Index, Integer};

/// The document itself.
#[derive(Deserialize)]
#[serde(rename_all = "camelCase")]
pub struct Root {
    pub asset: Asset,
    pub scene: Option<Index>,
    #[serde(default)]
    pub extensions_used: Vec<String>,
    #[serde(default)]
    pub extensions_required: Vec<String>,
    pub extensions: Option<RootExtensions>,
    #[serde(default)]
    pub accessors: Vec<Accessor>,
    #[serde(default)]
    pub animations: Vec<IgnoredAny>,
    #[serde(default)]
    pub buffers: Vec<Buffer>,
    #[serde(default)]
    pub buffer_views: Vec<BufferView>,
    #[serde(default)]
    pub cameras: Vec<Camera>,
    #[serde(default)]
    pub images: Vec<Image>,
    #[serde(default)]
    pub materials: Vec<Material>,
    #[serde(default)]
    pub meshes: Vec<Mesh>,
    #[serde(default)]
    pub nodes: Vec<Node>,
    #[serde(default)]
    pub samplers: Vec<Sampler>,
    #[serde(default)]
    pub scenes: Vec<Scene>,
    #[serde(default)]
    pub skins: Vec<IgnoredAny>,
    #[serde(default)]
    pub textures: Vec<Texture>,
}

#[derive(Deserialize)]
pub struct Asset {
    pub version: String,
}

#[derive(Deserialize)]
pub struct RootExtensions {
    #[serde(rename = "KHR_lights_punctual")]
    pub lights: Option<Lights>,
}

#[derive(Deserialize)]
pub struct Lights {
    #[serde(default)]
    pub lights: Vec<Light>,
}
