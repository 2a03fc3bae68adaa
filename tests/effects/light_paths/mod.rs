//! Light paths from lamps: the light of camera paths with less noise, and the same bits on any machine.

pub mod cases;
mod media;
mod motion;
mod thousandth;

use std::sync::atomic::Ordering;

use crate::support::reference::{by_tier, full};
use crate::support::workspace::Workspace;
use crate::support::{folder, mean_and_error, picture, root, write};
use cases::{BALL, Case, assert_same_bits, assert_same_light, cases, job, light, light_by_channel};
use petzval_image::{Picture, write_pfm};
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{Backend, Progress, RenderOptions, render_resumable};
use petzval_scene_formats::pbrt;

#[test]
fn light_paths_change_no_light() {
    assert_same_light(&cases(), [768, 96, by_tier(96, 288)], 3e-3, light_by_channel);
}

#[test]
fn light_paths_find_small_lamps_with_a_fifth_of_the_variance_or_less() {
    let noise = |case: &Case, light_paths| {
        let first = job(case, light_paths, 0, 16);
        let of_seed = |seed| {
            // As in `assert_same_light`, the fast tier surveys once.
            let job = match full() {
                true => job(case, light_paths, seed, 16),
                false => Job { seed, ..first.clone() },
            };
            picture(&job, Backend::Simd, 1)
        };
        let pictures: Vec<Picture> = (0..12).map(of_seed).collect();
        let pixels = pictures[0].pixels.len();
        (0..pixels)
            .map(|i| {
                let values: Vec<f64> = pictures.iter().map(|p| f64::from(p.pixels[i][1])).collect();
                mean_and_error(&values)[1].powi(2)
            })
            .sum::<f64>()
    };
    let all = cases();
    for case in [&all[0], &all[2], &all[3], &all[8], &all[14]] {
        let [camera, both] = [false, true].map(|light_paths| noise(case, light_paths));
        println!("{}: variance {camera:.3e} and {both:.3e}", case.name);
        assert!(both < 0.2 * camera, "{}: variance {camera} and {both}", case.name);
    }
}

#[test]
fn the_picture_is_the_same_for_all_threads_lanes_and_crops() {
    cases().iter().for_each(assert_same_bits);
}

#[test]
fn shards_and_adaptive_renders_have_the_light_of_a_whole_render() {
    let workspace = Workspace::new();
    let text = format!(
        r#"Film "rgb" "integer xresolution" 48 "integer yresolution" 32
           Camera "realistic" "string lensfile" "{}" "float focusdistance" 3
           WorldBegin {BALL}"#,
        root().join("lenses/dgauss.50mm.dat").display()
    );
    std::fs::write(workspace.path("lamp.pbrt"), text).expect("a scene");
    let render = "render lamp.pbrt --spp 90 --light-paths on --effects none";
    workspace.merges_to_the_whole(render);
    workspace.run_ok(&format!("{render} --noise 0.02 -o adaptive.exr"));
    let [whole, adaptive] = ["whole.exr", "adaptive.exr"]
        .map(|name| light(&Picture::read(&workspace.path(name)).expect("a picture")));
    assert!((adaptive / whole - 1.0).abs() < 0.02, "{adaptive} and {whole}");
    workspace.run_ok(
        "render lamp.pbrt --spp 90 --effects none -o off.petzval --shard 3/3 --light-paths off",
    );
    workspace.refuses("merge 2.petzval 1.petzval off.petzval -o x.exr", "--light-paths");
}

#[test]
fn shards_have_the_colours_of_a_whole_render() {
    let workspace = Workspace::new();
    let text = format!(
        r#"Film "rgb" "integer xresolution" 48 "integer yresolution" 32
           Camera "realistic" "string lensfile" "{}" "float focusdistance" 3
           WorldBegin {BALL}"#,
        root().join("lenses/triplet.toml").display()
    );
    std::fs::write(workspace.path("lamp.pbrt"), text).expect("a scene");
    let effects = "--effects +dispersion,-ghosts,-diffraction";
    workspace.merges_to_the_whole(&format!("render lamp.pbrt --spp 90 --light-paths on {effects}"));
}

#[test]
fn a_picture_stopped_in_its_first_pass_has_the_light_of_lamps() {
    let case = &cases()[0];
    let whole = light(&picture(&job(case, true, 1, 16), Backend::Simd, 1));
    let job = job(case, true, 1, 100_000);
    let progress = Progress::default();
    let options = RenderOptions { threads: 1, progress: Some(&progress), ..Default::default() };
    let stopped = std::thread::scope(|scope| {
        scope.spawn(|| {
            // A tile of the first pass has 65,536 samples.
            while progress.samples.load(Ordering::Relaxed) < 70_000 {
                std::thread::yield_now();
            }
            progress.stop.store(true, Ordering::Relaxed);
        });
        render_resumable(&job, options, None, None).expect("a partial picture")
    });
    let spp = stopped.partial_mean_spp.expect("a partial picture");
    assert!(spp < 256.0, "{spp} samples a pixel: it was stopped too late");
    let partial = light(&stopped.picture(&job));
    assert!(partial > 0.5 * whole, "{partial} of {whole}");
}

#[test]
fn pictures_without_small_bright_lamps_take_no_light_paths() {
    let auto = |world: &str, more: &str| {
        let text = format!(
            r#"Film "rgb" "integer xresolution" 48 "integer yresolution" 32 {more}
               Camera "realistic" "string lensfile" "{}" "float focusdistance" 3
               WorldBegin {world}"#,
            root().join("lenses/dgauss.50mm.dat").display()
        );
        let folder = folder();
        write(&folder, "sky.pfm", cases::sky());
        for (name, bright) in [("dull.pfm", 0), ("window.pfm", 12)] {
            // A part of the sky, larger than a sun, is 100 times as bright as the rest.
            let pixel = |i: usize| {
                let inside = [i % 256, i / 256].iter().all(|p| (128..128 + bright).contains(p));
                [if inside { 100.0 } else { 1.0 }; 3]
            };
            let mut file = Vec::new();
            write_pfm([256; 2], pixel, &mut file).expect("a sky");
            write(&folder, name, file);
        }
        let description = pbrt::read(&write(&folder, "lamp.pbrt", text)).expect("a scene");
        prepare(description, &Changes::default()).expect("a job").job
    };
    let wall = r#"
        AreaLightSource "diffuse" "rgb L" [2 2 2]
        Shape "trianglemesh" "point3 P" [-5 -5 7  5 -5 7  5 5 7  -5 5 7]
            "integer indices" [0 2 1 0 3 2]"#;
    let behind = r#"
        LightSource "infinite" "rgb L" [0.5 0.5 0.5]
        AreaLightSource "diffuse" "rgb L" [900 900 900]
        Translate 0 0 -5 Shape "sphere" "float radius" 0.1"#;
    // Both are 20 times as bright as the sky. The variance of a camera sample is 400 times their share of
    // the picture, which is 0.05 % and 1 %: 0.2 and 4.
    let ball = |radius: f64| {
        format!(
            r#"LightSource "infinite" "rgb L" [1 1 1]
               AreaLightSource "diffuse" "rgb L" [20 20 20]
               Translate 0 0 6 Shape "sphere" "float radius" {radius}"#
        )
    };
    let [dull, window, sun] = [
        "LightSource \"infinite\" \"string filename\" \"dull.pfm\"",
        "LightSource \"infinite\" \"string filename\" \"window.pfm\"",
        "LightSource \"infinite\" \"string filename\" \"sky.pfm\"",
    ];
    let clamped = "\"float maxcomponentvalue\" 5";
    for (world, more, reason) in [
        (wall, "", "no lamp in view is small and bright enough"),
        (behind, "", "no lamp in view is small and bright enough"),
        ("LightSource \"infinite\"", "", "no surface and no image of a sky emits light"),
        (dull, "", "no lamp in view is small and bright enough"),
        (window, "", "no lamp in view is small and bright enough"),
        (BALL, clamped, "bright samples are clamped"),
        (&ball(0.036), "", "the lamps in view add little noise"),
    ] {
        let job = auto(world, more);
        assert!(job.lamp_images.is_none(), "{reason}: {}", job.plan.light_paths);
        assert!(job.plan.light_paths.reason.contains(reason), "{}", job.plan.light_paths);
    }
    for world in [BALL, &ball(0.16), sun] {
        let job = auto(world, "");
        assert!(job.lamp_images.is_some(), "{}", job.plan.light_paths);
    }
}
