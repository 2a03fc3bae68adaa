//! What reads files that anybody may hand in, one function a reader: for the mutated inputs of the
//! ordinary tests, and for the fuzzers.
//!
//! An error is as good an answer as a scene; a panic, a hang, or memory out of proportion is none.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::Ordering;

use petzval::checkpoint::Saved;
use petzval::image::{Picture, Raster, Transfer};
use petzval::job::{Changes, prepare};
use petzval::lens::{self, From, Paraxial};
use petzval::render::{Backend, Job, Progress, Until, merge, render_kept};
use petzval::scene::{pbrt, ply};

/// A reader: a folder to work in, and what the file holds.
pub type Reader = fn(&Path, &[u8]);

/// All of them, by the folder of their corpus.
pub const READERS: [(&str, Reader); 5] =
    [("scene", scene), ("lens", lens), ("ply", ply), ("image", image), ("checkpoint", checkpoint)];

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
    let _ = ply::read(&write(folder, "mesh.ply", bytes), 1 << 20);
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

/// The picture that checkpoints of the corpus are of. They were written by
/// `petzval render scene.pbrt -o part.petzval --shard 1/1`, and by interrupting it with `--spp 1000000`
/// and with `--noise 1e-5`.
const PICTURE: &str = r#"
    Film "rgb" "integer xresolution" 8 "integer yresolution" 6
    Camera "perspective"
    Sampler "independent" "integer pixelsamples" 4
    WorldBegin
    LightSource "infinite"
    Translate 0 0 4 Shape "sphere""#;

/// A part of a picture, and a checkpoint of a render that goes on: one of fixed counts, and one that
/// takes samples where they are needed.
pub fn checkpoint(folder: &Path, bytes: &[u8]) {
    accepted(folder, bytes);
}

/// Which of these three takes it.
pub fn accepted(folder: &Path, bytes: &[u8]) -> [bool; 3] {
    static JOBS: OnceLock<[Job; 3]> = OnceLock::new();
    let [part, even, adaptive] = JOBS.get_or_init(|| {
        let scene = write(folder, "picture.pbrt", PICTURE.as_bytes());
        let job = |samples, noise| {
            let description = pbrt::read(&scene).expect("the scene of the checkpoints");
            let until = Until { noise, time: None };
            let changes = Changes { samples, until, ..Changes::default() };
            prepare(description, &changes).expect("the job of the checkpoints").0
        };
        [job(None, None), job(Some(1_000_000), None), job(None, Some(1e-5))]
    });
    let path = write(folder, "part.petzval", &sealed(bytes));
    // What is stopped at once reads only.
    let progress = Progress::default();
    progress.stop.store(true, Ordering::Relaxed);
    let goes_on = |job: &Job| {
        let saved = Saved::open(&path).ok();
        let exposed = |saved| render_kept(job, Backend::Simd, 1, &progress, None, Some(saved));
        saved.is_some_and(|saved| exposed(saved).is_ok())
    };
    [merge(part, std::slice::from_ref(&path)).is_ok(), goes_on(even), goes_on(adaptive)]
}

/// A file of this kind whose lengths and checksums say nothing against what it holds.
fn sealed(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let Some(length) = bytes.get(12..20) else { return bytes };
    let length =
        length.iter().rev().fold(0, |sum: usize, &byte| sum.wrapping_mul(256) | usize::from(byte));
    let head = length.saturating_add(20);
    let (Some(body), last) = (head.checked_add(12), bytes.len().saturating_sub(4)) else {
        return bytes;
    };
    if body > last {
        return bytes;
    }
    let checksum = crc32fast::hash(&bytes[20..head]);
    bytes[head..head + 4].copy_from_slice(&checksum.to_le_bytes());
    bytes[head + 4..body].copy_from_slice(&((last - body) as u64).to_le_bytes());
    let checksum = crc32fast::hash(&bytes[body..last]);
    bytes[last..].copy_from_slice(&checksum.to_le_bytes());
    bytes
}
