//! Pictures that are equal bit for bit for all threads, lanes, crops and sample ranges.

use std::sync::atomic::Ordering;
use std::thread;
use std::time::{Duration, Instant};

use crate::support::{picture, root};
use petzval_image::Picture;
use petzval_render::film::Frame;
use petzval_render::job::Job;
use petzval_render::prepare::{Changes, prepare};
use petzval_render::{Backend, Progress, ProgressiveRender, RenderError};
use petzval_scene_formats::pbrt;

fn job(scene: &str, changes: &Changes) -> Job {
    let description = pbrt::read(&root().join("scenes").join(scene)).expect("a scene");
    prepare(description, changes).expect("a job").job
}

fn small(scene: &str) -> Job {
    let resolution = Some([45, 37]);
    job(scene, &Changes { resolution, samples: Some(24), ..Changes::default() })
}

fn assert_same(one: &Picture, other: &Picture, what: &str) {
    assert_eq!(one.size, other.size, "{what}");
    for (i, (a, b)) in one.pixels.iter().zip(&other.pixels).enumerate() {
        let bits = |p: &[f32; 3]| p.map(f32::to_bits);
        let (x, y) = (i % one.size[0], i / one.size[0]);
        assert_eq!(bits(a), bits(b), "{what}: pixel {x}, {y}: {a:?} and {b:?}");
    }
    assert!(one.pixels.iter().any(|p| p[0] > 0.0), "{what}: the picture is black");
}

const SCENES: [&str; 6] =
    ["dgauss.pbrt", "fisheye.pbrt", "telephoto.pbrt", "wide.pbrt", "snowman.pbrt", "atelier.pbrt"];

/// Every kind of material under every kind of light, with alpha, bump maps, mixtures and instances.
const EVERYTHING: &str = r#"
    Film "rgb" "integer xresolution" 40 "integer yresolution" 40
    Integrator "path" "integer maxdepth" 8
    Camera "perspective" "float fov" 50
    WorldBegin
    LightSource "infinite" "rgb L" [0.3 0.4 0.5]
    LightSource "point" "rgb I" [8 6 4] "point3 from" [1 3 2]
    LightSource "distant" "rgb L" [1 1 1] "point3 from" [-1 2 -1]
    LightSource "spot" "rgb I" [9 9 20] "point3 from" [-2 2 1] "point3 to" [0 0 5]
    Texture "board" "spectrum" "checkerboard" "float uscale" 6 "float vscale" 6
        "rgb tex1" [0.8 0.6 0.4] "rgb tex2" [0.1 0.2 0.3]
    Texture "holes" "float" "checkerboard" "float uscale" 3 "float vscale" 3
        "float tex1" 0.4 "float tex2" 1
    Texture "bumps" "float" "bilerp" "float v00" 0 "float v10" 1 "float v01" -1 "float v11" 0.5
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [3 3 3]
        Shape "trianglemesh" "point3 P" [-2 2.5 3  2 2.5 3  2 2.5 6  -2 2.5 6]
            "integer indices" [0 1 2 0 2 3] "texture alpha" "holes"
        Translate 0 -0.5 3.5 Shape "sphere" "float radius" 0.2
    AttributeEnd
    MakeNamedMaterial "a" "string type" "diffuse" "texture reflectance" "board" "texture displacement" "bumps"
    MakeNamedMaterial "b" "string type" "conductor" "float uroughness" 0.3 "float vroughness" 0.1
    Material "mix" "string materials" ["a" "b"] "float amount" 0.4
    Shape "trianglemesh" "point3 P" [-5 -1 1  -5 -1 9  5 -1 9  5 -1 1] "integer indices" [0 1 2 0 2 3]
    Material "diffusetransmission"
    Shape "trianglemesh" "point3 P" [-3 -1 7  -3 2 7  3 2 7  3 -1 7] "integer indices" [0 1 2 0 2 3]
        "texture alpha" "holes"
    ObjectBegin "ball" Shape "sphere" "float radius" 0.5 ObjectEnd
    Material "conductor" ObjectBegin "metal" Shape "sphere" "float radius" 0.5 ObjectEnd
    Material "dielectric" "float roughness" 0.2 ObjectBegin "hazy" Shape "sphere" "float radius" 0.5 ObjectEnd
    Material "dielectric" ObjectBegin "clear" Shape "sphere" "float radius" 0.5 ObjectEnd
    Material "thindielectric" ObjectBegin "bubble" Shape "sphere" "float radius" 0.5 ObjectEnd
    Material "coateddiffuse" "float roughness" 0.3 ObjectBegin "paint" Shape "sphere" "float radius" 0.5 ObjectEnd
    Material "coatedconductor" ObjectBegin "varnish" Shape "sphere" "float radius" 0.5 ObjectEnd
    AttributeBegin Translate -1.6 -0.5 4 ObjectInstance "metal" AttributeEnd
    AttributeBegin Translate -0.5 -0.5 4 ObjectInstance "hazy" AttributeEnd
    AttributeBegin Translate 0.6 -0.5 4 ObjectInstance "clear" AttributeEnd
    AttributeBegin Translate 1.7 -0.5 4 Scale 1 -1 1 ObjectInstance "bubble" AttributeEnd
    AttributeBegin Translate -1.1 0.6 5 Scale -1 1 1 ObjectInstance "paint" AttributeEnd
    AttributeBegin Translate 0 0.6 5 ObjectInstance "varnish" AttributeEnd
    AttributeBegin Translate 1.1 0.6 5 Rotate 30 1 1 1 Scale 1 0.6 1 ObjectInstance "ball" AttributeEnd"#;

fn everything() -> Job {
    let folder = crate::support::folder();
    let path = crate::support::write(&folder, "everything.pbrt", EVERYTHING);
    let changes = Changes { samples: Some(24), ..Changes::default() };
    prepare(pbrt::read(&path).expect("a scene"), &changes).expect("a job").job
}

#[test]
fn all_materials_and_lights_are_equal_for_all_threads_and_lanes() {
    let job = everything();
    let one = picture(&job, Backend::Simd, 1);
    for threads in [2, 7] {
        assert_same(&one, &picture(&job, Backend::Simd, threads), &format!("{threads} threads"));
    }
    assert_same(&one, &picture(&job, Backend::Scalar, 2), "one lane");
}

#[test]
fn any_number_of_threads_gives_the_same_picture() {
    for scene in SCENES {
        let job = small(scene);
        let one = picture(&job, Backend::Simd, 1);
        for threads in [2, 7] {
            assert_same(
                &one,
                &picture(&job, Backend::Simd, threads),
                &format!("{scene}, {threads}"),
            );
        }
    }
}

#[test]
fn one_lane_gives_the_picture_of_eight() {
    for scene in SCENES {
        let job = small(scene);
        let eight = picture(&job, Backend::Simd, 2);
        assert_same(&eight, &picture(&job, Backend::Scalar, 2), scene);
    }
}

#[test]
fn a_crop_is_a_part_of_the_whole() {
    let whole = small("dgauss.pbrt");
    let part = Job { frame: Frame { low: [9, 5], high: [40, 29], ..whole.frame }, ..whole.clone() };
    let whole = picture(&whole, Backend::Simd, 2);
    let part = picture(&part, Backend::Simd, 2);
    let pixels = (5..29).flat_map(|y| whole.pixels[y * 45 + 9..y * 45 + 40].iter().copied());
    assert_same(&Picture { size: [31, 24], pixels: pixels.collect() }, &part, "crop");
}

#[test]
fn sample_ranges_add_up_to_the_whole() {
    let whole = small("wide.pbrt");
    let first = Job { samples: 0..8, ..whole.clone() };
    let rest = Job { samples: 8..24, ..whole.clone() };
    let [whole, first, rest] = [whole, first, rest].map(|job| picture(&job, Backend::Simd, 2));
    for i in 0..whole.pixels.len() {
        for c in 0..3 {
            let sum = (first.pixels[i][c] * 8.0 + rest.pixels[i][c] * 16.0) / 24.0;
            assert!((sum - whole.pixels[i][c]).abs() <= 1e-6 * whole.pixels[i][c].abs());
        }
    }
}

#[test]
fn another_seed_is_another_picture() {
    let job = small("dgauss.pbrt");
    let other = Job { seed: 1, ..job.clone() };
    let [one, other] = [job, other].map(|job| picture(&job, Backend::Simd, 2));
    assert_ne!(one, other);
    let [a, b] = [&one, &other].map(|p| crate::support::mean(p)[0]);
    assert!((a / b - 1.0).abs() < 0.02, "{a} and {b}");
}

#[test]
fn a_progressive_render_has_the_bits_of_a_render_with_its_samples() {
    // One without light paths and dispersion, and one with both.
    for (scene, effects) in
        [("dgauss.pbrt", "auto"), ("night.pbrt", "+ghosts,+dispersion,-diffraction")]
    {
        let effects = effects.parse().expect("effects");
        let changes = Changes {
            resolution: Some([41, 29]),
            samples: Some(300),
            assume_vd: true,
            effects,
            ..Changes::default()
        };
        let mut job = job(scene, &changes);
        let whole = job.clone();
        let mut progressive = ProgressiveRender::new(&whole, 2).expect("threads");
        for step in [1, 1, 3, 40, 1000, 7] {
            progressive = progressive.step(step, &Progress::default()).expect("a step");
            let samples = progressive.samples();
            if ![2, 45, 263].contains(&samples) {
                continue;
            }
            job.samples = 0..samples;
            let expected = picture(&job, Backend::Scalar, 1);
            assert_same(&progressive.picture(), &expected, &format!("{scene}, {samples}"));
        }
        assert_eq!(progressive.samples(), 263, "a step ends with its pass");
    }
}

#[test]
fn a_stopped_step_of_a_progressive_render_is_an_error() {
    let job = small("dgauss.pbrt");
    let progress = Progress::default();
    progress.stop.store(true, Ordering::Relaxed);
    let progressive = ProgressiveRender::new(&job, 1).expect("threads");
    assert!(matches!(progressive.step(1, &progress), Err(RenderError::Stopped)));
}

#[test]
fn a_stop_ends_the_light_paths_of_a_progressive_render() {
    // The light paths are those of the whole picture, which take many seconds.
    let changes = Changes {
        resolution: Some([16000, 12000]),
        crop: Some([[8000, 6000], [8016, 6016]]),
        effects: "+ghosts".parse().expect("a selection"),
        ..Changes::default()
    };
    let job = job("dgauss.pbrt", &changes);
    assert!(job.ghosts.is_some());
    let progress = Progress::default();
    let progressive = ProgressiveRender::new(&job, 1).expect("threads");
    thread::scope(|scope| {
        let step = scope.spawn(|| progressive.step(1, &progress).err());
        thread::sleep(Duration::from_millis(300));
        assert!(!step.is_finished(), "the light paths are too quick for this test");
        progress.stop.store(true, Ordering::Relaxed);
        let stopped = Instant::now();
        assert!(matches!(step.join().expect("a step"), Some(RenderError::Stopped)));
        // A wave takes a millisecond; the margin is for a busy machine.
        assert!(stopped.elapsed() < Duration::from_secs(2), "{:?}", stopped.elapsed());
    });
}
