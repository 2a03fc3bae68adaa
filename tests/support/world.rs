//! Readers of scenes given as text, and their warnings and errors.

use petzval_scene::{Roughness, Texture, TexturePoint};
use petzval_scene_formats::pbrt;
use petzval_scene_formats::pbrt::{Description, SceneErrors};

use super::{folder, write};

/// Reads a scene file of this text, named test.pbrt.
pub fn read(text: &str) -> Result<Description, SceneErrors> {
    let folder = folder();
    pbrt::read(&write(&folder, "test.pbrt", text))
}

/// Reads the world part of a scene behind a camera, which must not cause a warning.
pub fn read_world(world: &str) -> Description {
    let description = read_world_with_warnings(world);
    assert!(description.warnings.is_empty(), "{world}\n{:#?}", description.warnings);
    description
}

/// Reads the world part of a scene behind a camera, whatever warnings it causes.
pub fn read_world_with_warnings(world: &str) -> Description {
    read(&format!("Camera \"perspective\"\nWorldBegin\n{world}")).expect(world)
}

/// Returns the error message for the world part of a scene, from the name of the file on.
pub fn error(world: &str) -> String {
    let text = format!("Camera \"perspective\"\nWorldBegin\n{world}");
    let message = read(&text).map(|_| ()).expect_err(world).to_string();
    message[message.find("test.pbrt").unwrap_or(0)..].to_owned()
}

/// Returns the colour of a texture where all coordinates are 0.
pub fn colour(texture: &Texture) -> [f32; 3] {
    texture.colour(&TexturePoint::default())
}

/// Returns the roughness along u and v, and whether it is remapped.
pub fn roughness_and_remap(roughness: &Roughness) -> ([f32; 2], bool) {
    ([0, 1].map(|i| colour(&roughness.uv[i])[0]), roughness.remap)
}
