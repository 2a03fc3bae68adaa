//! What reads files that anybody may hand in, one function a reader: for the mutated inputs of the
//! ordinary tests, and for the fuzzers.
//!
//! An error is as good an answer as a scene; a panic, a hang, or memory out of proportion is none.

use std::fs;
use std::path::Path;

use petzval::image::{Picture, Raster, Transfer};
use petzval::lens::{self, From, Paraxial};
use petzval::scene::{pbrt, ply};

/// A reader: a folder to work in, and what the file holds.
pub type Reader = fn(&Path, &[u8]);

/// All of them, by the folder of their corpus.
pub const READERS: [(&str, Reader); 4] =
    [("scene", scene), ("lens", lens), ("ply", ply), ("image", image)];

fn write(folder: &Path, name: &str, bytes: &[u8]) -> std::path::PathBuf {
    let path = folder.join(name);
    // Some file systems flush what replaces the content of a file, and new files not.
    let _ = fs::remove_file(&path);
    fs::write(&path, bytes).expect("a file in the folder of a test");
    path
}

/// A scene, with what it includes, to its tree.
pub fn scene(folder: &Path, bytes: &[u8]) {
    let _ = pbrt::read(&write(folder, "scene.pbrt", bytes));
}

/// A lens in both formats, to what is traced.
pub fn lens(folder: &Path, bytes: &[u8]) {
    for name in ["lens.dat", "lens.toml"] {
        if let Ok(lens) = lens::read(&write(folder, name, bytes)) {
            let _ = Paraxial::of(&lens);
            let _ = lens::sequence::<f32>(&lens, From::Film(30.0));
        }
    }
}

/// A mesh.
pub fn ply(folder: &Path, bytes: &[u8]) {
    let _ = ply::read(&write(folder, "mesh.ply", bytes));
}

/// A picture, of the format that it begins like.
pub fn image(folder: &Path, bytes: &[u8]) {
    let name = match bytes {
        [0x89, ..] => "picture.png",
        [0xff, ..] => "picture.jpg",
        [b'v', ..] => "picture.exr",
        [b'#', ..] => "picture.hdr",
        [b'P', ..] => "picture.pfm",
        _ => "picture.tga",
    };
    let path = write(folder, name, bytes);
    let _ = Raster::read(&path, Transfer::Srgb).map(Raster::into_picture);
    let _ = Picture::read(&path, true);
}
