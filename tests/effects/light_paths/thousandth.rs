//! The light of seven scenes, of camera paths, of light paths and of both, to a thousandth:
//! `cargo test --release --test effects light_paths::thousandth -- --ignored --nocapture`, almost an hour.

use std::fs;

use petzval_render::Backend;
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, FocusOn, prepare};
use petzval_scene_formats::pbrt;
use petzval_scene_formats::pbrt::Description;

use super::cases::{self, Case, Paths, light, with_paths};
use super::{media, motion};
use crate::support::{folder, mean_and_error, picture, root, write};

/// Largest standard error of the difference, relative to the light.
const ERROR: f64 = 3.5e-4;
/// Pictures of each kind, each with another seed. Their number is fixed: to stop where the error looks
/// small would favour pictures without rare bright paths.
const PICTURES: u32 = 24;

/// Samples per pixel of a picture: of camera paths alone, of both kinds together, and of light paths alone.
type Samples = [u32; 3];

/// A scene.
struct Subject {
    name: &'static str,
    samples: Samples,
    job: Box<dyn Fn(bool, u32, u32) -> Job>,
}

/// Reads a scene of the repository.
fn read(file: &str) -> Description {
    pbrt::read(&root().join("scenes").join(file)).expect("a scene")
}

/// Returns a part of a scene (left, top, right, bottom).
fn scene(
    (name, description): (&'static str, Description),
    [resolution, low, high]: [[u32; 2]; 3],
    focus: Option<FocusOn>,
    samples: Samples,
) -> Subject {
    let changes = Changes {
        effects: "-ghosts,-diffraction,-dispersion".parse().expect("effects"),
        resolution: Some(resolution),
        crop: Some([low, high]),
        focus,
        assume_vd: true,
        ..Changes::default()
    };
    let job = move |light_paths, seed, samples| {
        let changes = Changes {
            light_paths: Some(light_paths),
            seed: Some(seed),
            samples: Some(samples),
            ..changes.clone()
        };
        prepare(description.clone(), &changes).expect("a job").job
    };
    Subject { name, samples, job: Box::new(job) }
}

fn of_case(case: Case, samples: Samples) -> Subject {
    let name = case.name;
    let job = move |light_paths, seed, samples| cases::job(&case, light_paths, seed, samples);
    Subject { name, samples, job: Box::new(job) }
}

/// Returns the mean light of pictures and its standard error.
fn light_of(subject: &Subject, paths: Paths) -> [f64; 2] {
    let Subject { name, samples, job } = subject;
    let samples = samples[paths as usize];
    let of_seed = |seed| {
        let job = with_paths(paths, |light_paths| job(light_paths, seed, samples));
        light(&picture(&job, Backend::Simd, 2))
    };
    let result = mean_and_error(&(0..PICTURES).map(of_seed).collect::<Vec<f64>>());
    println!("{name}, {paths:?}: {result:?}");
    result
}

/// Checks that light paths, alone and together with camera paths, find the light of camera paths, to a
/// thousandth.
fn check(subject: &Subject) {
    let camera = light_of(subject, Paths::Camera);
    // Both kinds leave caustics to light paths, so that light paths alone differ in lamps only.
    let only_caustics = (subject.job)(true, 0, 1).lamp_images.is_none();
    let kinds = [("with light paths", Paths::Both), ("light paths alone", Paths::Light)];
    for (kind, paths) in &kinds[..if only_caustics { 1 } else { 2 }] {
        let found = light_of(subject, *paths);
        let (off, error) = (found[0] / camera[0] - 1.0, camera[1].hypot(found[1]) / camera[0]);
        println!("{}, {kind}: {:.3} +- {:.3} %", subject.name, 100.0 * off, 100.0 * error);
        assert!(error < ERROR && off.abs() < 1e-3, "{}, {kind}: {off} +- {error}", subject.name);
    }
}

/// The pixels of a street lamp at night.
const LAMP: [[u32; 2]; 3] = [[300, 200], [44, 52], [62, 70]];

fn whole(resolution: [u32; 2]) -> [[u32; 2]; 3] {
    [resolution, [0, 0], resolution]
}

#[test]
#[ignore = "takes minutes; .ci/long runs it"]
fn a_street_lamp_in_focus() {
    check(&scene(("night", read("night.pbrt")), LAMP, None, [4096, 5120, 5120]));
}

#[test]
#[ignore = "takes minutes; .ci/long runs it"]
fn a_street_lamp_out_of_focus() {
    let near = Some(FocusOn::Distance(1.0));
    check(&scene(("night, focus at 1 m", read("night.pbrt")), LAMP, near, [4096, 5120, 5120]));
}

#[test]
#[ignore = "takes minutes; .ci/long runs it"]
fn caustics() {
    // Camera paths find the caustics of a lamp that is wider than that of the scene.
    let text = fs::read_to_string(root().join("scenes/caustic.pbrt")).expect("a scene");
    let (lens, small) = ("../lenses/dgauss.50mm.dat", "\"float radius\" 0.008");
    assert!(text.contains(lens) && text.contains(small), "{text}");
    let folder = folder();
    let text = text
        .replace(lens, root().join("lenses/dgauss.50mm.dat").to_str().expect("a path"))
        .replace(small, "\"float radius\" 0.06");
    let description = pbrt::read(&write(&folder, "caustic.pbrt", text)).expect("a scene");
    check(&scene(("caustic", description), whole([90, 60]), None, [4096, 2048, 0]));
}

#[test]
#[ignore = "takes minutes; .ci/long runs it"]
fn lamps_and_caustics_of_the_atelier() {
    check(&scene(("atelier", read("atelier.pbrt")), whole([90, 60]), None, [1024, 512, 512]));
}

#[test]
#[ignore = "takes minutes; .ci/long runs it"]
fn a_rolling_shutter_in_a_moving_camera() {
    check(&of_case(motion::cases().swap_remove(2), [1024, 192, 5120]));
}

#[test]
#[ignore = "takes minutes; .ci/long runs it"]
fn a_lamp_in_fog() {
    check(&of_case(media::cases().swap_remove(0), [1024, 128, 128]));
}

#[test]
#[ignore = "takes minutes; .ci/long runs it"]
fn a_lamp_in_the_colours_of_a_flint() {
    check(&of_case(cases::cases().swap_remove(7), [768, 96, 96]));
}
