//! The light of seven scenes, of camera paths alone and together with light paths, to a thousandth:
//! `cargo test --release --test light_paths -- --ignored --nocapture thousandth`, half an hour.

use petzval::io::image::Picture;
use petzval::job::Job;
use petzval::prepare::{Changes, FocusOn, prepare};
use petzval::render::Backend;
use petzval::scene::pbrt;

use crate::cases::{self, Case, light};
use crate::support::{mean_and_error, picture, root};
use crate::{media, motion};

/// Largest standard error of the difference, relative to the light.
const ERROR: f64 = 3.5e-4;
/// Fewest pictures of each kind, each with another seed.
const FEWEST: u32 = 24;

/// A scene, and samples per pixel of a picture of camera paths alone, and with light paths.
struct Subject {
    name: &'static str,
    samples: [u32; 2],
    job: Box<dyn Fn(bool, u32, u32) -> Job>,
}

/// Returns a part of a scene of the repository (left, top, right, bottom).
fn scene(
    (name, file): (&'static str, &'static str),
    [resolution, low, high]: [[u32; 2]; 3],
    focus: Option<FocusOn>,
    samples: [u32; 2],
) -> Subject {
    let description = pbrt::read(&root().join("scenes").join(file)).expect("a scene");
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
        prepare(description.clone(), &changes).expect("a job").0
    };
    Subject { name, samples, job: Box::new(job) }
}

fn of_case(case: Case, samples: [u32; 2]) -> Subject {
    let name = case.name;
    let job = move |light_paths, seed, samples| cases::job(&case, light_paths, seed, samples);
    Subject { name, samples, job: Box::new(job) }
}

/// Returns the mean light of pictures and its standard error, of as many seeds as it takes.
fn light_of(subject: &Subject, light_paths: bool, error: f64) -> [f64; 2] {
    let mut found = Vec::new();
    for seed in 0.. {
        let job = (subject.job)(light_paths, seed, subject.samples[usize::from(light_paths)]);
        let has = job.direct_light.is_some() || job.caustics.is_some();
        assert_eq!(has, light_paths, "{}: {}", subject.name, job.plan.light_paths);
        let picture: Picture = picture(&job, Backend::Simd, 2);
        found.push(light(&picture));
        let result = mean_and_error(&found);
        if seed + 1 >= FEWEST && result[1] < error * result[0] {
            let kind = if light_paths { "with light paths" } else { "camera paths" };
            println!("{}, {kind}: {result:?}, {} pictures", subject.name, found.len());
            return result;
        }
    }
    unreachable!("seeds do not end")
}

/// Checks that camera paths alone have the light of camera paths and light paths, to a thousandth.
fn check(subject: &Subject) {
    let [[camera, camera_error], [both, both_error]] =
        [false, true].map(|light_paths| light_of(subject, light_paths, ERROR / 2f64.sqrt()));
    let (off, error) = (both / camera - 1.0, camera_error.hypot(both_error) / camera);
    println!("{}: {:.3} +- {:.3} %", subject.name, 100.0 * off, 100.0 * error);
    assert!(error < 1.1 * ERROR && off.abs() < 1e-3, "{}: {off} +- {error}", subject.name);
}

/// The pixels of a street lamp at night.
const LAMP: [[u32; 2]; 3] = [[300, 200], [44, 52], [62, 70]];

fn whole(resolution: [u32; 2]) -> [[u32; 2]; 3] {
    [resolution, [0, 0], resolution]
}

#[test]
#[ignore = "takes minutes"]
fn a_street_lamp_in_focus() {
    check(&scene(("night", "night.pbrt"), LAMP, None, [4096, 2048]));
}

#[test]
#[ignore = "takes minutes"]
fn a_street_lamp_out_of_focus() {
    let near = Some(FocusOn::Distance(1.0));
    check(&scene(("night, focus at 1 m", "night.pbrt"), LAMP, near, [16384, 2048]));
}

#[test]
#[ignore = "takes minutes"]
fn caustics() {
    check(&scene(("caustic", "caustic.pbrt"), whole([150, 100]), None, [512, 256]));
}

#[test]
#[ignore = "takes minutes"]
fn lamps_and_caustics_of_the_atelier() {
    check(&scene(("atelier", "atelier.pbrt"), whole([90, 60]), None, [256, 256]));
}

#[test]
#[ignore = "takes minutes"]
fn a_rolling_shutter_in_a_moving_camera() {
    check(&of_case(motion::cases().swap_remove(2), [1024, 192]));
}

#[test]
#[ignore = "takes minutes"]
fn a_lamp_in_fog() {
    check(&of_case(media::cases().swap_remove(0), [1024, 128]));
}

#[test]
#[ignore = "takes minutes"]
fn a_lamp_in_the_colours_of_a_flint() {
    check(&of_case(cases::cases().swap_remove(7), [768, 96]));
}
