//! Readers of untrusted files, one function each, for the fuzzers and for tests/mutants.rs.
//!
//! A reader may return an error. It must not panic, hang, or use memory out of proportion.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;
use std::sync::atomic::Ordering;

use petzval_base::io::ReadContext;
use petzval_image::{Picture, Raster, Transfer};
use petzval_render::job::{Job, StopCriteria};

use petzval_lens::{Paraxial, Side};
use petzval_render::checkpoint::SavedRender;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{Progress, RenderOptions, merge, render_resumable};
use petzval_scene_formats::{pbrt, ply};
use petzval_spectrum::GlassLibrary;

/// A reader, called with a folder to work in and the content of the file.
pub type Reader = fn(&Path, &[u8]);

/// All readers, by the folder of their corpus.
pub const READERS: [(&str, Reader); 6] = [
    ("scene", scene),
    ("lens", lens),
    ("glass", glass),
    ("ply", ply),
    ("image", image),
    ("checkpoint", checkpoint),
];

fn write(folder: &Path, name: &str, bytes: &[u8]) -> std::path::PathBuf {
    let path = folder.join(name);
    // Some file systems flush a replaced file, but not a new one.
    let _ = fs::remove_file(&path);
    fs::write(&path, bytes).expect("a file in the folder of a test");
    path
}

/// Reads a scene with its included files and builds its BVH.
pub fn scene(folder: &Path, bytes: &[u8]) {
    let _ = pbrt::read(&write(folder, "scene.pbrt", bytes));
}

/// Reads a lens by its content and by the extensions, to the surfaces of a trace.
pub fn lens(folder: &Path, bytes: &[u8]) {
    for name in ["lens.dat", "lens.toml", "lens.zmx", "lens.seq", "lens.len"] {
        if let Ok(lens) = petzval_lens_formats::read(&write(folder, name, bytes)) {
            let _ = Paraxial::new(&lens);
            let _ = petzval_lens::sequence::<f32>(&lens, Side::Film(30.0));
        }
    }
}

/// Reads a glass catalogue, and computes, finds and converts its glasses.
pub fn glass(folder: &Path, bytes: &[u8]) {
    let path = write(folder, "catalogue.agf", bytes);
    let library = GlassLibrary::built_in();
    let Ok(library) = library.with_catalogue(&path, &ReadContext::default()) else { return };
    for glass in library.glasses().take_while(|glass| glass.maker == "catalogue").take(100) {
        let _ = [glass.nd(), glass.vd(), glass.index(0.0), glass.index(f64::INFINITY)];
        let _ =
            library.resolve(&glass.name, &["catalogue"]).map(|found| found.glass.index(1.0, 550.0));
    }
}

/// Reads a mesh.
pub fn ply(folder: &Path, bytes: &[u8]) {
    let _ = ply::read(&write(folder, "mesh.ply", bytes), &ReadContext::default());
}

/// Reads a picture in the format of its first bytes.
pub fn image(folder: &Path, bytes: &[u8]) {
    let name = match bytes {
        [0x89, ..] => "picture.png",
        [0xff, ..] => "picture.jpg",
        [b'v', ..] => "picture.exr",
        [b'#', ..] => "picture.hdr",
        [b'P', ..] => "picture.pfm",
        [b'I', b'I', ..] | [b'M', b'M', ..] => "picture.tif",
        _ => "picture.tga",
    };
    let path = write(folder, name, bytes);
    let _ = Raster::read(&path, Transfer::Srgb, &ReadContext::default()).map(Raster::into_picture);
    let _ = Picture::read(&path);
}

/// Scene of the checkpoints in the corpus. They were written by
/// `petzval render scene.pbrt -o part.petzval --shard 1/1`, and by interrupting it with `--spp 1000000`
/// and with `--noise 1e-5`.
const PICTURE: &str = r#"
    Film "rgb" "integer xresolution" 8 "integer yresolution" 6
    Camera "perspective"
    Sampler "independent" "integer pixelsamples" 4
    WorldBegin
    LightSource "infinite"
    Translate 0 0 4 Shape "sphere""#;

/// Reads a part of a picture, a checkpoint of a uniform render and one of an adaptive render.
pub fn checkpoint(folder: &Path, bytes: &[u8]) {
    accepted(folder, bytes);
}

/// Returns whether merge, the uniform render and the adaptive render accept a file.
pub fn accepted(folder: &Path, bytes: &[u8]) -> [bool; 3] {
    static JOBS: OnceLock<[Job; 3]> = OnceLock::new();
    let [part, even, adaptive] = JOBS.get_or_init(|| {
        let scene = write(folder, "picture.pbrt", PICTURE.as_bytes());
        let job = |samples, noise| {
            let description = pbrt::read(&scene).expect("the scene of the checkpoints");
            let until = StopCriteria { noise, time: None };
            let changes = Changes { samples, stop_criteria: until, ..Changes::default() };
            prepare(description, &changes).expect("the job of the checkpoints").job
        };
        [job(None, None), job(Some(1_000_000), None), job(None, Some(1e-5))]
    });
    let path = write(folder, "part.petzval", &with_valid_checksums(bytes));
    // A render that is stopped at once only reads the checkpoint.
    let progress = Progress::default();
    progress.stop.store(true, Ordering::Relaxed);
    let resumes = |job: &Job| {
        let saved = SavedRender::open(&path).ok();
        let options =
            RenderOptions { threads: 1, progress: Some(&progress), ..RenderOptions::default() };
        let exposed = |saved| render_resumable(job, options, None, Some(saved));
        saved.is_some_and(|saved| exposed(saved).is_ok())
    };
    [merge(part, std::slice::from_ref(&path)).is_ok(), resumes(even), resumes(adaptive)]
}

/// Corrects the lengths and checksums of a checkpoint, so that its content is read.
fn with_valid_checksums(bytes: &[u8]) -> Vec<u8> {
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
