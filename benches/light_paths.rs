//! Cost of noise with light paths and without: variance times CPU time, for scenes with lamps in view.
//! A render that halves the variance in the same time halves the product.
//!
//! The variance is measured between pictures of different seeds, because light paths belong to no
//! pixel: once for the light itself, over the square of the picture's mean, and once relative to each
//! pixel (squared, plus 0.01 of the mean squared), which counts dark pixels as much as lamps.
//!
//!     cargo bench --bench light_paths

use std::path::Path;

use nix::time::ClockId;
use petzval_image::Picture;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{RenderOptions, render};
use petzval_scene::luminance;
use petzval_scene_formats::pbrt;

/// Scenes, with the focus distance (m) of each; none for the scene's own.
const SCENES: [(&str, Option<f64>); 5] = [
    ("night", None),
    ("night", Some(1.0)),
    ("snowman", None),
    ("caustic", None),
    ("atelier", None),
];
const RESOLUTION: [u32; 2] = [300, 200];
const SAMPLES: u32 = 32;
/// Pictures of each kind.
const SEEDS: u32 = 12;

/// Returns the CPU time of this process (s).
fn cpu_seconds() -> f64 {
    let now = ClockId::CLOCK_PROCESS_CPUTIME_ID.now().expect("a clock of CPU time");
    now.tv_sec() as f64 + 1e-9 * now.tv_nsec() as f64
}

/// Noise and time of a kind of picture.
struct Noise {
    /// Variance over the square of the mean.
    whole: f64,
    /// Mean over the pixels of the variance relative to each.
    relative: f64,
    /// CPU time of a picture (s), the median.
    seconds: f64,
}

fn measure(scene: &str, focus: Option<f64>, light_paths: Option<bool>) -> Noise {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("scenes/{scene}.pbrt"));
    let (mut pictures, mut seconds) = (Vec::new(), Vec::new());
    for seed in 0..SEEDS {
        let changes = Changes {
            resolution: Some(RESOLUTION),
            samples: Some(SAMPLES),
            seed: Some(seed),
            focus: focus.map(petzval_render::prepare::FocusOn::Distance),
            effects: "none".parse().expect("effects"),
            light_paths,
            ..Changes::default()
        };
        let job = prepare(pbrt::read(&file).expect("a scene"), &changes).expect("a job").job;
        let start = cpu_seconds();
        let options = RenderOptions { threads: 1, ..RenderOptions::default() };
        let picture: Picture = render(&job, options).expect("a picture").into_picture(&job);
        seconds.push(cpu_seconds() - start);
        pictures.push(picture);
    }
    seconds.sort_by(f64::total_cmp);
    let count = f64::from(SEEDS);
    let pixels = pictures[0].pixels.len();
    let (mut light, mut variance, mut relative) = (0.0, 0.0, 0.0);
    let moments: Vec<[f64; 2]> = (0..pixels)
        .map(|i| {
            let values: Vec<f64> =
                pictures.iter().map(|p| f64::from(luminance(p.pixels[i]))).collect();
            let mean = values.iter().sum::<f64>() / count;
            let sum: f64 = values.iter().map(|v| (v - mean).powi(2)).sum();
            [mean, sum / (count - 1.0)]
        })
        .collect();
    let mean = moments.iter().map(|moment| moment[0]).sum::<f64>() / pixels as f64;
    for [value, of_pixel] in moments {
        light += value;
        variance += of_pixel;
        relative += of_pixel / (value * value + 0.01 * mean * mean);
    }
    let per_pixel = light / pixels as f64;
    Noise {
        whole: variance / pixels as f64 / (per_pixel * per_pixel),
        relative: relative / pixels as f64,
        seconds: seconds[seconds.len() / 2],
    }
}

fn main() {
    println!("scene      focus  light paths    CPU s   variance  x time   relative  x time");
    for (scene, focus) in SCENES {
        for (name, light_paths) in [("off", Some(false)), ("auto", None)] {
            let Noise { whole, relative, seconds } = measure(scene, focus, light_paths);
            println!(
                "{scene:<10} {:>5}  {name:<11} {seconds:>8.2} {whole:>10.4} {:>7.4} {relative:>10.4} \
                 {:>7.4}",
                focus.map_or("-".to_owned(), |focus| format!("{focus} m")),
                whole * seconds,
                relative * seconds
            );
        }
    }
}
