//! Reader of glTF 2.0 scenes, `.gltf` and `.glb` (Khronos Group 2021, "glTF 2.0 Specification").
//!
//! Lengths are in metres, +y is up. Luminous quantities become radiometric ones as they are: a
//! luminance of 1 cd/m^2 is a radiance of 1. A camera photographs as a pinhole, or through a real
//! lens if the user mounts one.
//!
//! `schema` describes the JSON; `document` holds it and the buffers, `messages` finds the places of its
//! elements; `nodes` walks the tree and places what `meshes`, `lights` and `cameras` make; `materials`
//! and `images` make surfaces. Features that are not read are warnings; an index or a size that does not
//! fit is an error with its place.

mod accessors;
mod cameras;
mod document;
mod glb;
mod images;
mod instances;
mod lights;
mod material_extensions;
mod material_opacity;
mod material_textures;
mod material_transmission;
mod materials;
mod meshes;
mod messages;
mod nodes;
mod schema;
mod textures;

use std::path::Path;

use glam::Vec3;

use super::pbrt::{Description, FilterSpec, SceneError, SceneErrors};
use cameras::PlacedCamera;
use document::Document;
use materials::Materials;
use petzval_base::io::ReadContext;
use petzval_scene::filter::Profile;
use petzval_scene::motion::Motion;
use petzval_scene::shutter::Shutter;
use petzval_scene::{Light, PathLimits, SceneBuilder, Sky};

/// Returns whether a file is a glTF scene, by its name.
pub fn is_gltf(path: &Path) -> bool {
    let extension = path.extension().and_then(|extension| extension.to_str());
    extension.is_some_and(|e| ["gltf", "glb"].iter().any(|known| e.eq_ignore_ascii_case(known)))
}

/// Reads a glTF scene within a memory budget.
///
/// # Errors
/// Returns an error if a file cannot be read, is not valid, or exceeds the budget.
pub fn read_with(path: &Path, context: &ReadContext) -> Result<Description, SceneErrors> {
    let document = Document::read(path, context)?;
    Ok(describe(&document)?)
}

/// The parts of a scene that are made so far.
struct SceneParts<'a> {
    document: &'a Document,
    builder: SceneBuilder,
    materials: Materials,
    camera: Option<PlacedCamera>,
    /// Number of lights and of meshes that emit light.
    lights: usize,
}

fn describe(document: &Document) -> Result<Description, SceneError> {
    document.warn_unread();
    let mut parts = SceneParts {
        document,
        builder: SceneBuilder::default(),
        materials: Materials::default(),
        camera: None,
        lights: 0,
    };
    parts.place_nodes()?;
    if parts.lights == 0 {
        let message = "the scene has no light: a white sky of radiance 1 lights it";
        document.warn("lights", message);
        parts.builder.add_light(Light::Infinite(Sky::uniform([1.0; 3])));
    }
    let SceneParts { builder, camera, .. } = parts;
    let at = document.location("scenes");
    let scene = builder
        .build()
        .map_err(|source| SceneError::TooLarge { at: document.location("meshes"), source })?;
    let camera = match camera {
        Some(camera) => camera,
        None => {
            let message = "the scene has no camera: one in front of it sees all of it";
            document.warn("cameras", message);
            PlacedCamera::in_front_of(scene.bounds().unwrap_or([Vec3::NEG_ONE, Vec3::ONE]))
        }
    };
    Ok(Description {
        camera_at: camera.at.unwrap_or(at),
        camera: camera.spec,
        film: camera.film,
        world_from_camera: camera.world_from_camera,
        camera_motion: Motion::still(camera.world_from_camera),
        transform_times: [0.0, 1.0],
        shutter: Shutter::default(),
        samples: 16,
        seed: 0,
        filter: FilterSpec { profile: Profile::Gaussian { sigma: 0.5 }, radius: [1.5; 2] },
        path_limits: PathLimits { max_depth: 8, direct_only: false, regularize: false },
        scene,
        warnings: document.take_warnings(),
        files: document.context.files(),
        context: document.context.clone(),
    })
}
