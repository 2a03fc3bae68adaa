//! Readers of scene files: pbrt-v4, glTF 2.0, PLY and NanoVDB. [`pbrt::SceneAssembly`] makes a scene of the
//! arrays of a program.

#![cfg_attr(not(test), warn(clippy::disallowed_methods))]

pub mod gltf;
pub mod nanovdb;
pub mod pbrt;
pub mod ply;

use std::path::Path;

use petzval_base::io::ReadContext;

/// Reads a scene file in the language of pbrt, or in glTF if its name ends in `.gltf` or `.glb`.
///
/// # Errors
/// Returns all errors of the scene that one reading finds.
pub fn read(path: &Path) -> Result<pbrt::Description, pbrt::SceneErrors> {
    read_with(path, &ReadContext::default())
}

/// Reads a scene file within a memory budget; see [`read`].
///
/// # Errors
/// Returns all errors of the scene that one reading finds.
pub fn read_with(
    path: &Path,
    context: &ReadContext,
) -> Result<pbrt::Description, pbrt::SceneErrors> {
    match gltf::is_gltf(path) {
        true => gltf::read_with(path, context),
        false => pbrt::read_with(path, context),
    }
}
