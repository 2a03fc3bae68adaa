//! Russian roulette: it, and with it the noise of a picture, depends on the scene and not on the camera.

use crate::support::{LENSES, folder, mean, root, write};
use petzval_render::aov::Aov;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{RenderOptions, render};
use petzval_scene_formats::pbrt;

/// Maximum number of bounces of a path.
const DEPTH: usize = 6;

/// Settings of a camera in the middle of a grey ball with a small light near its top.
#[derive(Clone, Copy)]
struct View {
    lens: &'static str,
    f_number: f64,
    iso: f64,
    seconds: f64,
    radiance: f64,
}

const USUAL: View =
    View { lens: "dgauss.50mm", f_number: 5.6, iso: 100.0, seconds: 1.0, radiance: 300.0 };

/// Noise of a picture, and the rays that it costs.
#[derive(Debug)]
struct Noise {
    /// Variance of a pixel divided by the square of its mean.
    relative: f64,
    /// Scattered rays after each bounce, per camera ray. The last bounce has shadow rays only.
    rays: [f64; DEPTH - 1],
}

fn noise(view: View) -> Noise {
    let View { lens, f_number, iso, seconds, radiance } = view;
    let folder = folder();
    let text = format!(
        r#"Film "rgb" "integer xresolution" 64 "integer yresolution" 64 "float diagonal" 8
               "float iso" {iso:?}
           Sampler "independent" "integer pixelsamples" 32
           Integrator "path" "integer maxdepth" {DEPTH}
           Camera "realistic" "string lensfile" "{}/lenses/{lens}.dat"
               "float aperturediameter" 100 "float focusdistance" 20
               "float shutteropen" 0 "float shutterclose" {seconds:?}
           WorldBegin
           Material "diffuse" "rgb reflectance" [ 0.6 0.5 0.4 ]
           Shape "sphere" "float radius" 20
           AttributeBegin
               AreaLightSource "diffuse" "rgb L" [ {radiance:e} {radiance:e} {radiance:e} ]
               Translate 0 18 0   Rotate 90 1 0 0
               Shape "disk" "float radius" 3
           AttributeEnd"#,
        root().display()
    );
    let description = pbrt::read(&write(&folder, "ball.pbrt", text)).expect("a scene");
    let layers = vec![Aov::Variance];
    let changes = Changes { f_number: Some(f_number), layers, ..Changes::default() };
    let job = prepare(description, &changes).expect("a job").job;
    let exposed =
        render(&job, RenderOptions { threads: 1, ..RenderOptions::default() }).expect("a picture");
    let samples = job.samples.end;
    let variance = exposed.film.variance(samples).expect("the squares were added up");
    let picture = exposed.film.picture(samples);
    let [_, mean, _] = mean(&picture);
    let sum: f64 = variance.iter().map(|pixel| f64::from(pixel[1])).sum();
    let live = |depth: usize| {
        exposed.stats.bounces.get(depth).map_or(0.0, |bounce| bounce.intersect.live as f64)
    };
    Noise {
        relative: sum / (variance.len() as f64 * mean * mean) * f64::from(samples),
        rays: std::array::from_fn(|i| live(i + 1) / live(0)),
    }
}

/// Asserts that noise and rays are equal within a relative tolerance.
fn assert_same(name: &str, noise: &Noise, usual: &Noise, within: f64) {
    println!("{name}: relative variance {:.4}, rays {:.4?}", noise.relative, noise.rays);
    let same = |a: f64, b: f64| assert!((a / b - 1.0).abs() < within, "{name}: {a}, not {b}");
    same(noise.relative, usual.relative);
    for (a, b) in noise.rays.iter().zip(usual.rays) {
        same(*a, b);
    }
}

#[test]
fn noise_does_not_depend_on_exposure_or_units() {
    let usual = noise(USUAL);
    // The test needs paths that reach the last bounce.
    assert!((0.05..0.5).contains(&usual.rays[DEPTH - 2]), "{usual:?}");
    // The samples are the same except for rounding.
    let rounding = 0.001;
    for iso in [1.0, 10_000.0] {
        assert_same(&format!("ISO {iso}"), &noise(View { iso, ..USUAL }), &usual, rounding);
    }
    for seconds in [0.001, 50.0] {
        let view = View { seconds, ..USUAL };
        assert_same(&format!("{seconds} s"), &noise(view), &usual, rounding);
    }
    for by in [1e-6, 1e6] {
        let view = View { radiance: by * USUAL.radiance, ..USUAL };
        assert_same(&format!("light x {by:e}"), &noise(view), &usual, rounding);
    }
}

#[test]
fn noise_does_not_depend_on_the_lens_or_its_stop() {
    let usual = noise(USUAL);
    // Other samples: 4096 pixels of 32 samples estimate the variance to about 0.7 %, and the pictures
    // differ slightly.
    for (lens, _) in LENSES {
        for f_number in [5.6, 16.0] {
            let view = View { lens, f_number, ..USUAL };
            assert_same(&format!("{lens} f/{f_number}"), &noise(view), &usual, 0.05);
        }
    }
}
