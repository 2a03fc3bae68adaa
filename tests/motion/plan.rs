//! What the plan says of things that move, against what is seen of them.

use std::process::{Command, Stdio};

use petzval::job::{Changes, prepare};
use petzval::plan::{Decision, Effect, Harm, Wanted};
use petzval::render::Job;
use petzval::scene::pbrt;
use serde_json::Value;

use super::support::{folder, root, write};
use super::world::{curtain, edge, job, profile, row, taken, text};

fn of(job: &Job, effect: Effect) -> &Decision {
    job.plan.effects.iter().find(|decision| decision.effect == effect).expect("a decision")
}

fn pixels(job: &Job, effect: Effect) -> f64 {
    match of(job, effect).error {
        Some(Harm::Blur { pixels, .. }) => pixels,
        other => panic!("{other:?}"),
    }
}

fn without(effect: &str) -> Changes {
    Changes { effects: effect.parse().expect("effects"), ..Changes::default() }
}

/// How wide the ramp of an edge is, pixels: where an edge is spread evenly over a width w, the
/// places of its steps have w^2 / 12 more of variance than those of a sharp one.
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

/// The same where the light is not even: the two pictures differ by w / 4 in all, if the sharp
/// edge is between two pixels.
fn uneven_width(with: &Job, without: &Job) -> f64 {
    let [with, without] = [with, without].map(|job| profile(&taken(job)));
    let bright = without.iter().fold(0.0f64, |a, &b| a.max(b));
    4.0 * with.iter().zip(&without).map(|(a, b)| (a - b).abs()).sum::<f64>() / bright
}

#[test]
fn the_blur_that_is_said_is_the_blur_that_is_seen() {
    let text = text("", "", 64, &curtain(-0.4, 0.6));
    let (with, without) = (job(&text, &Changes::default()), job(&text, &without("-motion")));
    assert!(with.plan.has(Effect::Motion) && !without.plan.has(Effect::Motion));
    assert!(without.timing.is_none() && without.scene.movers().is_empty());
    let seen = width(&with, &without);
    for job in [&with, &without] {
        assert!((pixels(job, Effect::Motion) - 16.0).abs() < 1e-3, "{}", job.plan.line());
    }
    assert!((seen - 16.0).abs() < 0.2, "{seen}");
    assert!(of(&without, Effect::Motion).reason.contains("in the middle of that time"));
    // The edge stands where it is in the middle, x = 0.1.
    assert!((edge(&row(&taken(&without), 8)) - 33.6).abs() < 0.05);
}

#[test]
fn a_real_lens_spreads_an_edge_as_far_as_is_said() {
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
    let of =
        |changes: &Changes| prepare(pbrt::read(&path).expect("a scene"), changes).expect("a job").0;
    let (with, without) = (of(&Changes::default()), of(&without("-motion")));
    let (said, seen) = (pixels(&with, Effect::Motion), uneven_width(&with, &without));
    assert!((said / seen - 1.0).abs() < 0.1, "{said} said, {seen} seen");
    let Some(Harm::Blur { um, .. }) = with.plan.effects[5].error else { panic!() };
    assert!((um - said * 1e3 * with.camera.film[0] / 96.0).abs() < 1e-6 * um);
}

#[test]
fn a_camera_that_turns_moves_everything_by_its_angle() {
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
    // At the edge of the picture, 2 from its middle, by a factor of 1 + 2^2 more.
    let (said, middle) =
        (pixels(&turn(5.0, &Changes::default()), Effect::Motion), 16.0 * 5f64.to_radians());
    assert!(said > 4.0 * middle && said < 5.5 * middle, "{said} said, {middle} in the middle");
}

#[test]
fn rows_lean_as_far_as_is_said() {
    let text =
        text("", "\"float shutterclose\" .1 \"float rollingshutter\" .5", 64, &curtain(-0.4, 0.6));
    let with = job(&text, &without("-motion"));
    assert!(with.plan.has(Effect::RollingShutter));
    let picture = taken(&with);
    let ratio = with.camera.imaging_ratio;
    let edges =
        [0, 15].map(|y| edge(&row(&picture, y).iter().map(|v| v / ratio).collect::<Vec<_>>()));
    let (said, seen) = (pixels(&with, Effect::RollingShutter), edges[1] - edges[0]);
    assert!((said - 8.0).abs() < 1e-3 && (seen - 8.0).abs() < 0.1, "{said} said, {seen} seen");
    let all = job(&text, &Changes { effects: Wanted::None, ..Changes::default() });
    assert!(all.timing.is_none() && pixels(&all, Effect::RollingShutter) == said);
}

#[test]
fn what_cannot_be_seen_to_move_is_left_out() {
    let text = text("", "", 16, &curtain(0.0, 0.02));
    let job = job(&text, &Changes::default());
    assert!(!job.plan.has(Effect::Motion) && job.scene.movers().is_empty());
    assert!((pixels(&job, Effect::Motion) - 0.32).abs() < 1e-3);
    assert!(of(&job, Effect::Motion).reason.contains("stands where it is in the middle"));
}

#[test]
fn the_command_knows_shutters() {
    let folder = folder();
    let scene = write(&folder, "motion.pbrt", text("", "", 4, &curtain(-0.4, 0.6)));
    let petzval = |arguments: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_petzval"));
        let command = command.arg("plan").arg(&scene).args(arguments).stdin(Stdio::null());
        let output = command.output().expect("the command starts");
        let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("text");
        (output.status.code(), text(output.stdout), text(output.stderr))
    };
    let (code, said, errors) =
        petzval(&["--json", "--shutter", "time=1/2,ramp=10ms", "--rolling-shutter", "20ms,up"]);
    assert_eq!(code, Some(0), "{errors}");
    let plan: Value = serde_json::from_str(&said).expect("JSON");
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
        (["--shutter", "close=-1"], "--shutter: a shutter that opens at 0 s and closes at -1 s"),
        (["--shutter", "ramp=2"], "opens in 2 s and closes in 2 s; expected 1 s together"),
        (["--shutter", "speed=2"], "expected NAME=VALUE with open, close, time"),
        (["--rolling-shutter", "20ms,sideways"], "expected down, up, left or right"),
        (["--rolling-shutter", "-1ms"], "expected 0 s or more"),
    ] {
        let (code, _, errors) = petzval(&arguments);
        assert!(code == Some(2) && errors.contains(expected), "{arguments:?}: {errors}");
    }
}
