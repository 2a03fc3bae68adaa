//! Cost of noise: relative variance times CPU time, for a knot in a room through the four course
//! lenses. A render that halves the variance in the same time halves the product.
//!
//!     cargo bench --bench variance

use std::f32::consts::TAU;
use std::path::Path;

use glam::Vec3;
use nix::time::ClockId;
use petzval_render::aov::Aov;
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{RenderOptions, render};
use petzval_scene_formats::pbrt;

/// Steps along and around the knot, which give 400,000 triangles.
const STEPS: [u32; 2] = [4000, 50];
const SIDE: u32 = 256;
const SAMPLES: u32 = 8;
const RUNS: usize = 5;

/// Lens, and distance from the film to the knot (m), which then fills about half of the picture.
const LENSES: [(&str, f64); 4] =
    [("dgauss.50mm", 7.0), ("wide.22mm", 3.2), ("fisheye.10mm", 1.8), ("telephoto.250mm", 34.0)];

/// Returns the text of a mesh: a trefoil knot at the origin, 2.4 m wide, of a rope 0.5 m thick.
fn knot() -> String {
    let [along, around] = STEPS;
    let spine = |i: u32| {
        let t = TAU * i as f32 / along as f32;
        let r = 0.3 * (2.0 + (1.5 * 2.0 * t).cos());
        Vec3::new(r * (2.0 * t).cos(), r * (2.0 * t).sin(), 0.35 * (3.0 * t).sin())
    };
    let (mut points, mut normals, mut indices) = (String::new(), String::new(), String::new());
    for i in 0..along {
        let ahead = (spine(i + 1) - spine(i)).normalize();
        let (u, v) = (ahead.cross(Vec3::Z).normalize(), ahead.cross(Vec3::Z).cross(ahead));
        for j in 0..around {
            let (sin, cos) = (TAU * j as f32 / around as f32).sin_cos();
            let normal = (u * cos + v.normalize() * sin).normalize();
            let point = spine(i) + normal * 0.2;
            points += &format!("{} {} {} ", point.x, point.y, point.z);
            normals += &format!("{} {} {} ", normal.x, normal.y, normal.z);
            let at = |i: u32, j: u32| (i % along) * around + j % around;
            let [a, b, c, d] = [at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)];
            indices += &format!("{a} {b} {c} {a} {c} {d} ");
        }
    }
    format!(
        "Shape \"trianglemesh\" \"point3 P\" [{points}] \"normal N\" [{normals}] \
         \"integer indices\" [{indices}]"
    )
}

fn job(lens: &str, distance: f64, knot: &str) -> Job {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let path = folder.path().join("knot.pbrt");
    // The walls, 40 m away, are behind the cameras of all lenses.
    let text = format!(
        r#"Film "rgb" "integer xresolution" {SIDE} "integer yresolution" {SIDE} "float diagonal" 20
           Sampler "sobol" "integer pixelsamples" {SAMPLES}
           Integrator "path" "integer maxdepth" 5
           LookAt 0 0 -{distance} 0 0 0 0 1 0
           Camera "realistic" "string lensfile" "{}/lenses/{lens}.dat"
               "float aperturediameter" 100 "float focusdistance" {distance}
           WorldBegin
           Material "diffuse" "rgb reflectance" [ 0.7 0.7 0.7 ]
           Shape "sphere" "float radius" 40
           AttributeBegin
               AreaLightSource "diffuse" "rgb L" [ 40 36 30 ]
               Translate 3 9 -6   Rotate 60 1 0 0
               Shape "disk" "float radius" 4
           AttributeEnd
           Material "coateddiffuse" "rgb reflectance" [ 0.6 0.2 0.1 ] "float roughness" 0.05
           {knot}"#,
        Path::new(env!("CARGO_MANIFEST_DIR")).display()
    );
    std::fs::write(&path, text).expect("a scene in the temporary folder");
    let layers = vec![Aov::Variance];
    prepare(pbrt::read(&path).expect("a scene"), &Changes { layers, ..Changes::default() })
        .expect("a job")
        .job
}

/// Returns the CPU time of this process (s).
fn cpu_seconds() -> f64 {
    let now = ClockId::CLOCK_PROCESS_CPUTIME_ID.now().expect("a clock of CPU time");
    now.tv_sec() as f64 + 1e-9 * now.tv_nsec() as f64
}

/// Returns the relative variance, the mean over lit pixels of variance divided by the square of the mean,
/// and the CPU time (s).
fn measure(job: &Job) -> (f64, f64) {
    let start = cpu_seconds();
    let exposed =
        render(job, RenderOptions { threads: 1, ..RenderOptions::default() }).expect("a picture");
    let seconds = cpu_seconds() - start;
    let variance = exposed.film.variance(SAMPLES).expect("the squares were added up");
    let picture = exposed.film.picture(SAMPLES);
    let sum: f64 = variance.iter().map(|pixel| f64::from(pixel[1])).sum();
    let squares: f64 = picture.pixels.iter().map(|pixel| f64::from(pixel[1]).powi(2)).sum();
    (sum / squares, seconds)
}

fn main() {
    let knot = knot();
    println!("lens               relative variance    CPU s    product");
    for (lens, distance) in LENSES {
        let job = job(lens, distance, &knot);
        let runs: Vec<_> = (0..RUNS).map(|_| measure(&job)).collect();
        let mut seconds: Vec<f64> = runs.iter().map(|run| run.1).collect();
        seconds.sort_by(f64::total_cmp);
        let (variance, seconds) = (runs[0].0, seconds[RUNS / 2]);
        println!("{lens:<18} {variance:>17.4} {seconds:>8.2} {:>10.4}", variance * seconds);
    }
}
