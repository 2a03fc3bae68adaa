//! Scene files: pbrt, glTF and NanoVDB.

#[path = "../support/mod.rs"]
mod support;

mod assembly;
mod errors;
mod files;
mod foreign;
mod gltf;
mod language;
mod limits;
mod materials;
mod media;
mod nanovdb;
mod older;
mod pbrt_language;
mod textures;
mod tolerance;
mod warnings;
