//! Scene files from a few words: what they read as, and what is said of them.

use petzval::scene::pbrt::{self, Description, SceneError};
use petzval::scene::{Roughness, Texture, TexturePoint};

use super::{folder, write};

/// A scene file of this text.
pub fn read(text: &str) -> Result<Description, SceneError> {
    let folder = folder();
    pbrt::read(&write(&folder, "test.pbrt", text))
}

/// A world with a camera in front of it; it must read without a word of warning.
pub fn quietly(world: &str) -> Description {
    let description = loudly(world);
    assert!(description.warnings.is_empty(), "{world}\n{:#?}", description.warnings);
    description
}

/// The same, whatever it warns of.
pub fn loudly(world: &str) -> Description {
    read(&format!("Camera \"perspective\"\nWorldBegin\n{world}")).expect(world)
}

/// The error for a world, without the folder of its file.
pub fn error(world: &str) -> String {
    let text = format!("Camera \"perspective\"\nWorldBegin\n{world}");
    let said = read(&text).map(|_| ()).expect_err(world).to_string();
    said[said.find("test.pbrt").unwrap_or(0)..].to_owned()
}

/// The colour of a texture where all coordinates are 0.
pub fn colour(texture: &Texture) -> [f32; 3] {
    texture.at(&TexturePoint::default())
}

/// Roughness along u and v, and whether it is remapped.
pub fn rough(roughness: &Roughness) -> ([f32; 2], bool) {
    ([0, 1].map(|i| colour(&roughness.uv[i])[0]), roughness.remap)
}
