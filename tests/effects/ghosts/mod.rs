//! Ghosts against brute force: every path of light through a lens of two elements, by textbook formulas.

mod brute_force;
mod plan;

use crate::support::{folder, write};
use petzval_base::lanes::f32x8;
use petzval_base::stats::Stats;
use petzval_image::Picture;
use petzval_lens::LensModel;
use petzval_render::film::FilmSums;
use petzval_render::job::Job;
use petzval_render::light_tracing::ghosts::estimate;
use petzval_render::light_tracing::{SplatStage, Strategy};
use petzval_render::prepare::{Changes, prepare};
use petzval_scene_formats::pbrt;
use petzval_spectrum::{bands, lens_bands};

/// Two uncoated elements and a stop between them.
const LENS: &str = r#"
name = "two elements"
[[surface]]
radius = 40.0
thickness = 5.0
diameter = 24.0
index = 1.6
coating = "none"
[[surface]]
radius = -90.0
thickness = 4.0
diameter = 24.0
[[surface]]
stop = true
thickness = 4.0
diameter = 14.0
[[surface]]
radius = 70.0
thickness = 4.0
diameter = 22.0
index = 1.7
[[surface]]
radius = -60.0
thickness = 30.0
diameter = 22.0
"#;

const PIXELS: usize = 32;

/// Side of the film, mm.
const FILM: f64 = 30.0;

/// Distance of the film behind the rear vertex, mm, for the focus of the scene.
const FOCUS: f64 = 3.0;

fn job(lens: &str, world: &str, effects: &str, samples: u32) -> Job {
    let folder = folder();
    write(&folder, "two.toml", lens);
    let text = format!(
        r#"Film "rgb" "integer xresolution" {PIXELS} "integer yresolution" {PIXELS}
               "float diagonal" {} "float iso" 100
           PixelFilter "box" "float xradius" 0.5 "float yradius" 0.5
           Sampler "sobol" "integer pixelsamples" {samples}
           Camera "realistic" "string lensfile" "two.toml"
               "float aperturediameter" 14 "float focusdistance" {FOCUS}
           WorldBegin {world}"#,
        FILM * 2f64.sqrt()
    );
    let description = pbrt::read(&write(&folder, "two.pbrt", text)).expect("a scene");
    let changes = Changes { effects: effects.parse().expect("effects"), ..Changes::default() };
    prepare(description, &changes).expect("a job").job
}

/// Returns the lens with this coating on all faces.
fn coated(name: &str) -> String {
    let coating = format!("coating = \"{name}\"");
    let mut lens = LENS.replace("\ncoating = \"none\"", "");
    // The rear faces of the elements too.
    for key in ["index = 1.", "radius = -90.0", "radius = -60.0"] {
        lens = lens.replace(key, &format!("{coating}\n{key}"));
    }
    lens
}

fn green(picture: &Picture) -> Vec<f64> {
    picture.pixels.iter().map(|pixel| f64::from(pixel[1])).collect()
}

/// Returns means over squares of pixels.
fn blocks(pixels: &[f64], side: usize) -> Vec<f64> {
    let count = PIXELS / side;
    let mut means = vec![0.0; count * count];
    for (i, value) in pixels.iter().enumerate() {
        let (x, y) = (i % PIXELS / side, i / PIXELS / side);
        means[y * count + x] += value / (side * side) as f64;
    }
    means
}

/// Returns the green channel of the ghosts of all pairs alone.
fn ghosts(job: &Job, samples: u32) -> Vec<f64> {
    green(&picture_of_ghosts(job, samples))
}

/// Returns the ghosts of all pairs alone.
fn picture_of_ghosts(job: &Job, samples: u32) -> Picture {
    let LensModel::Real(lens) = &job.camera.model else { panic!("a real lens") };
    let bands = if job.spectral.is_some() { lens_bands() } else { bands().to_vec() };
    let ghosts =
        estimate(&job.light_path_input()).expect("ghosts").ghosts_of_all_pairs(lens, &bands);
    let job = Job { samples: 0..samples, ..job.clone() };
    let mut film = FilmSums::new(job.frame);
    SplatStage::default().run::<f32x8>(
        &job.light_path_input(),
        &[Strategy::Ghosts(&ghosts)],
        job.samples.clone(),
        &|| true,
        &mut film,
        &mut Stats::default(),
    );
    film.picture(samples)
}
