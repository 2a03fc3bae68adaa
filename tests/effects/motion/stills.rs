//! Pictures with motion against the mean of still pictures.

use petzval_image::Picture;
use petzval_render::aov::Aov;
use petzval_render::job::Job;
use petzval_render::plan::Effect;
use petzval_render::prepare::Changes;
use petzval_render::{Backend, RenderOptions, render};
use petzval_scene::shutter::ShutterSettings;

use super::world::{SIZE, job, moving, taken, text};
use crate::support::{mean, picture};

/// Returns a flying ball and a rolling wheel with a shiny spoke over a floor, under a light with shadows.
fn yard() -> String {
    let ball = moving(
        [-1.2, 0.6],
        "Material \"diffuse\" \"rgb reflectance\" [.8 .4 .2] Translate 0 .1 2 \
         Shape \"sphere\" \"float radius\" .25",
    );
    format!(
        "LightSource \"point\" \"rgb I\" [9 9 9] \"point3 from\" [0 3 1]\n\
         Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n\
         \"point3 P\" [-9 -.5 -9  9 -.5 -9  9 -.5 9  -9 -.5 9]\n{ball}\
         ObjectBegin \"wheel\" Material \"conductor\" \"float roughness\" .3\n\
         Shape \"cylinder\" \"float radius\" .05 \"float zmin\" -.6 \"float zmax\" .6\n\
         Material \"diffuse\" \"rgb reflectance\" [.1 .2 .7]\n\
         AttributeBegin Translate 0 0 .5 ActiveTransform EndTime Scale 2 1 1 ActiveTransform All\n\
         Shape \"sphere\" \"float radius\" .15 AttributeEnd ObjectEnd\n\
         AttributeBegin Translate .8 0 2.2 ActiveTransform EndTime Translate .3 0 0 \
         Rotate 140 1 .3 0 ActiveTransform All ObjectInstance \"wheel\" AttributeEnd"
    )
}

/// Returns means of blocks of 8 x 8 pixels.
fn blocks(picture: &Picture) -> Vec<f64> {
    let mut blocks = vec![0.0; SIZE[0] / 8 * (SIZE[1] / 8)];
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let [x, y] = [i % SIZE[0], i / SIZE[0]];
        blocks[y / 8 * (SIZE[0] / 8) + x / 8] += pixel.iter().map(|&v| f64::from(v)).sum::<f64>();
    }
    blocks.iter().map(|sum| sum / 192.0).collect()
}

/// Prepares the scene at one time, without motion.
fn still(text: &str, when: f64, seed: u32) -> Job {
    let settings =
        ShutterSettings { open: Some(when - 1e-6), time: Some(2e-6), ..ShutterSettings::default() };
    let changes = Changes { shutter: Some(settings), seed: Some(seed), ..Changes::default() };
    let mut job = job(text, &changes);
    assert!(
        job.timing.is_none() && job.scene.animated_instances().is_empty(),
        "{}",
        job.plan.line()
    );
    job.camera.imaging_ratio = 1.0;
    job
}

#[test]
fn motion_blur_equals_the_mean_of_stills() {
    const STILLS: u32 = 96;
    let rides =
        ["", "ActiveTransform EndTime Rotate 6 0 1 0 Translate -.3 0 .1 ActiveTransform All"];
    for ride in rides {
        let blurred = job(&text(ride, "", 1024, &yard()), &Changes::default());
        assert!(blurred.plan.has(Effect::Motion) && blurred.scene.animated_instances().len() == 3);
        assert_eq!(
            blurred.timing.as_ref().is_some_and(|timing| timing.camera_motion.is_some()),
            !ride.is_empty()
        );
        let blurred = blocks(&taken(&blurred));
        let mut expected = vec![0.0; blurred.len()];
        for i in 0..STILLS {
            let when = (f64::from(i) + 0.5) / f64::from(STILLS);
            let one = blocks(&taken(&still(&text(ride, "", 16, &yard()), when, i)));
            for (sum, one) in expected.iter_mut().zip(one) {
                *sum += one / f64::from(STILLS);
            }
        }
        for (i, (found, expected)) in blurred.iter().zip(&expected).enumerate() {
            assert!((found / expected - 1.0).abs() < 0.01, "{i}: {found} for {expected}");
        }
        // The mean differs from the picture at the middle of the exposure.
        let middle = blocks(&taken(&still(&text(ride, "", 64, &yard()), 0.5, 1)));
        let off = middle.iter().zip(&expected).map(|(m, e)| (m / e - 1.0).abs());
        let off = off.fold(0.0, f64::max);
        assert!(off > 0.03, "the motion is invisible: {off}");
    }
}

/// Returns the largest difference of pixels, relative to the mean.
fn largest_difference(a: &Picture, b: &Picture) -> f64 {
    let off = a.pixels.iter().zip(&b.pixels).map(|(a, b)| f64::from((a[1] - b[1]).abs()));
    off.fold(0.0, f64::max) / mean(b)[1]
}

#[test]
fn moving_the_camera_equals_moving_the_world_backwards() {
    let things = "Material \"diffuse\" \"rgb reflectance\" [.2 .5 .1]\n\
                  Translate .2 0 2 Shape \"sphere\" \"float radius\" .3\n\
                  Rotate 30 1 1 1 Shape \"cylinder\" \"float radius\" .1";
    let end = |what: &str| format!("ActiveTransform EndTime {what} ActiveTransform All\n");
    for (camera, world) in [
        // Transforms of a camera map the world to the camera.
        ("Translate -.5 0 .25", "Translate -.5 0 .25"),
        ("Rotate 20 .1 .2 1", "Rotate 20 .1 .2 1"),
    ] {
        let riding = job(&text(&end(camera), "", 64, things), &Changes::default());
        let staying =
            job(&text("", "", 64, &format!("{}{things}", end(world))), &Changes::default());
        assert!(
            riding.scene.animated_instances().is_empty()
                && !staying.scene.animated_instances().is_empty()
        );
        let (riding, staying) = (taken(&riding), taken(&staying));
        // The random numbers are the same, so pixels differ only by rounding in paths.
        assert!(
            largest_difference(&riding, &staying) < 0.05,
            "{}",
            largest_difference(&riding, &staying)
        );
        assert!((mean(&riding)[1] / mean(&staying)[1] - 1.0).abs() < 1e-3);
    }
}

#[test]
fn without_motion_the_picture_is_unchanged_bit_for_bit() {
    let things = "LightSource \"point\" \"point3 from\" [0 3 1] Translate .2 0 2\n\
                  Shape \"sphere\" \"float radius\" .3";
    let plain = taken(&job(&text("", "", 16, things), &Changes::default()));
    let back = "ActiveTransform EndTime Translate 1 0 0 Translate -1 0 0 ActiveTransform All";
    let changes = Changes {
        rolling: Some("20ms".parse().expect("a time")),
        effects: "+motion,+rolling_shutter".parse().expect("effects"),
        ..Changes::default()
    };
    let all = job(&text("TransformTimes 0 2", "", 16, &format!("{back} {things}")), &changes);
    assert!(!all.plan.has(Effect::Motion) && !all.plan.has(Effect::RollingShutter));
    assert_eq!(taken(&all).pixels, plain.pixels);
    // A shutter without ramps that is open for a second passes all light.
    let changes = Changes { shutter: Some("ramp=0".parse().expect("ramps")), ..changes };
    assert_eq!(taken(&job(&text("", "", 16, things), &changes)).pixels, plain.pixels);
    let slow = Changes { shutter: Some("ramp=.25".parse().expect("ramps")), ..Changes::default() };
    let dim = taken(&job(&text("", "", 16, things), &slow));
    for (dim, bright) in dim.pixels.iter().zip(&plain.pixels) {
        assert!((dim[1] - 0.75 * bright[1]).abs() <= 1e-6 * bright[1]);
    }
}

#[test]
fn motion_blur_does_not_depend_on_threads_lanes_or_crops() {
    let ride = "ActiveTransform EndTime Rotate 6 0 1 0 ActiveTransform All";
    let changes = Changes {
        rolling: Some("100ms,left".parse().expect("a time")),
        shutter: Some("ramp=.1".parse().expect("ramps")),
        ..Changes::default()
    };
    let job = job(&text(ride, "", 16, &yard()), &changes);
    let one = picture(&job, Backend::Simd, 1);
    assert_eq!(picture(&job, Backend::Simd, 2).pixels, one.pixels);
    assert_eq!(picture(&job, Backend::Scalar, 2).pixels, one.pixels);
    let mut part = job.clone();
    (part.frame.low, part.frame.high) = ([5, 3], [40, 11]);
    let part = picture(&part, Backend::Simd, 2);
    for y in 0..8 {
        let whole = &one.pixels[(y + 3) * SIZE[0] + 5..][..35];
        assert_eq!(&part.pixels[y * 35..][..35], whole, "row {y} of a crop");
    }
}

#[test]
fn layers_are_means_over_the_exposure() {
    let wall = "Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n\
                \"point3 P\" [-99 -99 3  99 -99 3  99 99 3  -99 99 3]";
    let end = |z: f64| format!("ActiveTransform EndTime Translate 0 0 {z} ActiveTransform All\n");
    // The camera or the wall approaches by 1: the mean distance is 2.5.
    for (camera, world, height) in
        [(end(-1.0), String::new(), 3.0), (String::new(), end(-1.0), 2.5)]
    {
        let changes = Changes { layers: vec![Aov::Depth, Aov::Position], ..Changes::default() };
        let job = job(&text(&camera, "", 64, &format!("{world}{wall}")), &changes);
        let exposed = render(&job, RenderOptions { threads: 1, ..RenderOptions::default() })
            .expect("a picture");
        let layers = exposed.layers(&job);
        let mean = |layer: usize, name: &str| {
            let channel = layers[layer].channels.iter().find(|(other, _)| other == name);
            let values = &channel.expect(name).1;
            values.iter().map(|&v| f64::from(v)).sum::<f64>() / values.len() as f64
        };
        assert!((mean(0, "Z") - 2.5).abs() < 0.005, "{}", mean(0, "Z"));
        assert!((mean(1, "Z") - height).abs() < 0.005, "{}", mean(1, "Z"));
    }
}
