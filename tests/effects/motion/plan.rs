//! Estimates of motion in the plan against pictures.

use std::process::{Command, Stdio};

use petzval_render::job::Job;
use petzval_render::plan::{Decision, Effect, EffectSelection, OmissionError};
use petzval_render::prepare::{Changes, prepare};
use petzval_scene_formats::pbrt;
use serde_json::Value;

use super::world::{curtain, edge, job, profile, row, taken, text};
use crate::support::{folder, root, write};

fn of(job: &Job, effect: Effect) -> &Decision {
    job.plan.effects.iter().find(|decision| decision.effect == effect).expect("a decision")
}

fn pixels(job: &Job, effect: Effect) -> f64 {
    match of(job, effect).error {
        Some(OmissionError::Blur { pixels, .. }) => pixels,
        other => panic!("{other:?}"),
    }
}

fn without(effect: &str) -> Changes {
    Changes { effects: effect.parse().expect("effects"), ..Changes::default() }
}

/// Returns the width of the ramp of an edge, pixels. The variance of the positions of its steps is larger
/// by w^2 / 12 than that of a sharp edge.
fn width(with: &Job, without: &Job) -> f64 {
    let [with, without] = [with, without].map(|job| {
        let bright = profile(&taken(job));
        let steps = bright.windows(2).enumerate().map(|(i, pair)| (i as f64, pair[1] - pair[0]));
        let moment = |power: i32| steps.clone().map(|(x, step)| step * x.powi(power)).sum::<f64>();
        let [all, first, second] = [0, 1, 2].map(moment);
        second / all - (first / all).powi(2)
    });
    (12.0 * (with - without)).sqrt()
}

/// Returns the width of the ramp under uneven light: the two pictures differ by w / 4 in all if the sharp
/// edge lies between two pixels.
fn width_in_uneven_light(with: &Job, without: &Job) -> f64 {
    let [with, without] = [with, without].map(|job| profile(&taken(job)));
    let bright = without.iter().fold(0.0f64, |a, &b| a.max(b));
    4.0 * with.iter().zip(&without).map(|(a, b)| (a - b).abs()).sum::<f64>() / bright
}

#[test]
fn the_estimated_blur_equals_that_in_the_picture() {
    let text = text("", "", 64, &curtain(-0.4, 0.6));
    let (with, without) = (job(&text, &Changes::default()), job(&text, &without("-motion")));
    assert!(with.plan.has(Effect::Motion) && !without.plan.has(Effect::Motion));
    assert!(without.timing.is_none() && without.scene.animated_instances().is_empty());
    let seen = width(&with, &without);
    for job in [&with, &without] {
        assert!((pixels(job, Effect::Motion) - 16.0).abs() < 1e-3, "{}", job.plan.line());
    }
    assert!((seen - 16.0).abs() < 0.2, "{seen}");
    assert!(of(&without, Effect::Motion).reason.contains("in the middle of that time"));
    // The edge is at its middle position, x = 0.1.
    assert!((edge(&row(&taken(&without), 8)) - 33.6).abs() < 0.05);
}

#[test]
fn the_estimated_blur_holds_for_a_real_lens() {
    let folder = folder();
    let lens = root().join("lenses/dgauss.50mm.dat");
    let scene = format!(
        "Film \"rgb\" \"integer xresolution\" 96 \"integer yresolution\" 16 \"float diagonal\" 36\n\
         PixelFilter \"box\" Sampler \"zsobol\" \"integer pixelsamples\" 64\n\
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float aperturediameter\" 4\n\
         \"float focusdistance\" 2\nWorldBegin LightSource \"infinite\"\n\
         AttributeBegin Scale 1 1 2 {} AttributeEnd",
        lens.display(),
        curtain(-0.1, 0.15)
    );
    let path = write(&folder, "lens.pbrt", scene);
    let of = |changes: &Changes| {
        prepare(pbrt::read(&path).expect("a scene"), changes).expect("a job").job
    };
    let (with, without) = (of(&Changes::default()), of(&without("-motion")));
    let (estimate, seen) = (pixels(&with, Effect::Motion), width_in_uneven_light(&with, &without));
    assert!((estimate / seen - 1.0).abs() < 0.1, "{estimate} estimated, {seen} found");
    let Some(OmissionError::Blur { um, .. }) = with.plan.effects[5].error else { panic!() };
    assert!((um - estimate * 1e3 * with.camera.film[0] / 96.0).abs() < 1e-6 * um);
}

#[test]
fn a_rotating_camera_blurs_by_its_angle() {
    let wall = "Material \"diffuse\" \"rgb reflectance\" [0 0 0]\n\
                Shape \"trianglemesh\" \"integer indices\" [0 1 2 0 2 3]\n\
                \"point3 P\" [-99 -99 9  0 -99 9  0 99 9  -99 99 9]";
    let turn = |degrees: f64, changes: &Changes| {
        let ride = format!("ActiveTransform EndTime Rotate {degrees} 0 1 0 ActiveTransform All");
        job(&text(&ride, "", 64, wall), changes)
    };
    let (with, without) = (turn(20.0, &Changes::default()), turn(20.0, &without("-motion")));
    let (seen, expected) = (width(&with, &without), 16.0 * 20f64.to_radians().tan());
    assert!((seen / expected - 1.0).abs() < 0.05, "{seen} for {expected}");
    // At the edge of the picture, at a tangent of 2, the shift is larger by a factor of 1 + 2^2.
    let (estimate, middle) =
        (pixels(&turn(5.0, &Changes::default()), Effect::Motion), 16.0 * 5f64.to_radians());
    assert!(
        estimate > 4.0 * middle && estimate < 5.5 * middle,
        "{estimate} estimated, {middle} in the middle"
    );
}

#[test]
fn the_estimated_skew_of_rows_equals_that_in_the_picture() {
    let text =
        text("", "\"float shutterclose\" .1 \"float rollingshutter\" .5", 64, &curtain(-0.4, 0.6));
    let with = job(&text, &without("-motion"));
    assert!(with.plan.has(Effect::RollingShutter));
    let picture = taken(&with);
    let ratio = with.camera.imaging_ratio;
    let edges =
        [0, 15].map(|y| edge(&row(&picture, y).iter().map(|v| v / ratio).collect::<Vec<_>>()));
    let (estimate, seen) = (pixels(&with, Effect::RollingShutter), edges[1] - edges[0]);
    assert!(
        (estimate - 8.0).abs() < 1e-3 && (seen - 8.0).abs() < 0.1,
        "{estimate} estimated, {seen} found"
    );
    let all = job(&text, &Changes { effects: EffectSelection::None, ..Changes::default() });
    assert!(all.timing.is_none() && pixels(&all, Effect::RollingShutter) == estimate);
}

#[test]
fn invisible_motion_is_left_out() {
    let text = text("", "", 16, &curtain(0.0, 0.02));
    let job = job(&text, &Changes::default());
    assert!(!job.plan.has(Effect::Motion) && job.scene.animated_instances().is_empty());
    assert!((pixels(&job, Effect::Motion) - 0.32).abs() < 1e-3);
    assert!(of(&job, Effect::Motion).reason.contains("stays where it is in the middle"));
}

#[test]
fn the_command_plans_shutters_and_refuses_invalid_ones() {
    let folder = folder();
    let scene = write(&folder, "motion.pbrt", text("", "", 4, &curtain(-0.4, 0.6)));
    let petzval = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_petzval"));
        let command = command.arg("plan").arg(&scene).args(arguments).stdin(Stdio::null());
        let output = command.output().expect("the command starts");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
        (output.status.code(), text(output.stdout), text(output.stderr))
    };
    let (code, stdout, stderr) =
        petzval(&["--json", "--shutter", "time=1/2,ramp=10ms", "--rolling-shutter", "20ms,up"]);
    assert_eq!(code, Some(0), "{stderr}");
    let plan: Value = serde_json::from_str(&stdout).expect("JSON");
    let row = |name: &str| {
        let rows = plan["effects"].as_array().expect("a list");
        rows.iter().find(|row| row["effect"] == name).expect("a row").clone()
    };
    assert_eq!((&row("motion")["on"], &row("motion")["by"]), (&true.into(), &"scene".into()));
    assert!((row("motion")["error"]["px"].as_f64().expect("pixels") - 8.0).abs() < 1e-3);
    assert!(row("motion")["cost"]["ns_per_ray"].as_f64() > Some(1.0));
    assert_eq!(row("rolling_shutter")["by"], "flag");
    assert_eq!(row("rolling_shutter")["on"], false, "0.32 pixels");
    for (arguments, expected) in [
        (["--shutter", "close=-1"], "--shutter: the shutter opens at 0 s and closes at -1 s"),
        (["--shutter", "ramp=2"], "opens in 2 s and closes in 2 s; expected 1 s together"),
        (["--shutter", "speed=2"], "expected NAME=VALUE with open, close, time"),
        (["--rolling-shutter", "20ms,sideways"], "expected down, up, left or right"),
        (["--rolling-shutter", "-1ms"], "expected 0 s or more"),
    ] {
        let (code, _, stderr) = petzval(&arguments);
        assert!(code == Some(2) && stderr.contains(expected), "{arguments:?}: {stderr}");
    }
}
