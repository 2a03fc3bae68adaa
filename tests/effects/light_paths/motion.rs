//! Light paths while something moves: objects before lamps, the camera, and rows that are read in turn.

use petzval_image::Picture;
use petzval_render::Backend;
use petzval_render::job::Job;
use petzval_render::plan::Effect;
use petzval_render::prepare::Changes;

use super::cases::{Case, assert_same_bits, assert_same_light, case, job, light, light_by_channel};
use crate::support::picture;
use crate::support::workspace::Workspace;

/// A lamp, and a post that moves before it, out of the way of a part of its light.
const POST: &str = r#"
    LightSource "infinite" "rgb L" [0.05 0.05 0.1]
    AttributeBegin
        AreaLightSource "diffuse" "rgb L" [5 4 2]
        Translate 0.1 0.1 6 Shape "sphere" "float radius" 0.5
    AttributeEnd
    AttributeBegin
        Material "diffuse" "rgb reflectance" [0 0 0]
        Translate 0 -2 3 ActiveTransform EndTime Translate 0.2 0 0 ActiveTransform All
        Shape "trianglemesh" "point3 P" [-0.6 0 0  -0.1 0 0  -0.1 4 0  -0.6 4 0] "integer indices" [0 1 2 0 2 3]
    AttributeEnd"#;

/// Lamps in three rows.
const ROWS: &str = r#"
    LightSource "infinite" "rgb L" [0.05 0.05 0.1]
    AreaLightSource "diffuse" "rgb L" [7 6 3] "bool twosided" true
    Translate 0 0.6 6 Shape "sphere" "float radius" 0.35
    Translate 0.2 -0.6 0 Shape "sphere" "float radius" 0.35
    Translate -0.4 -0.6 0 Shape "disk" "float radius" 0.35"#;

/// A camera that moves by and turns.
const RIDE: &str = r#"
    ActiveTransform EndTime Rotate 2 0.3 1 1 Translate 0.2 0.1 -0.3 ActiveTransform All"#;

/// A camera that falls, so that lamps cross rows.
const FALL: &str = "ActiveTransform EndTime Translate 0 0.5 0 ActiveTransform All";

pub fn cases() -> Vec<Case> {
    let focus = "\"float focusdistance\" 3 \"float aperturediameter\" 8";
    let with = |shutter: &str, rolling: Option<&str>| Changes {
        effects: "-ghosts,-diffraction".parse().expect("effects"),
        shutter: Some(shutter.parse().expect(shutter)),
        rolling: rolling.map(|text| text.parse().expect(text)),
        ..Changes::default()
    };
    vec![
        Case {
            changes: with("open=0,close=1", None),
            ..case("moving post", "dgauss.50mm.dat", focus, POST)
        },
        Case {
            before: RIDE,
            changes: with("open=0,close=0.8,opening=0.5,closing=0.1", None),
            ..case("moving camera and post", "dgauss.50mm.dat", focus, POST)
        },
        Case {
            before: RIDE,
            changes: with("open=0,close=0.25", Some("0.6,up")),
            ..case("rolling shutter", "dgauss.50mm.dat", focus, ROWS)
        },
        Case {
            before: FALL,
            filter: "\"gaussian\" \"float xradius\" 2 \"float yradius\" 2",
            changes: with("open=0,close=0.4,opening=0.2,closing=0.2", Some("0.5,down")),
            ..case("rolling shutter with ramps", "wide.22mm.dat", focus, ROWS)
        },
        Case {
            before: RIDE,
            changes: Changes {
                effects: "+dispersion,-ghosts,-diffraction".parse().expect("effects"),
                ..with("open=0,close=0.25", Some("0.6,right"))
            },
            ..case("all at once", "triplet.toml", focus, POST)
        },
    ]
}

/// Returns the light of a picture, by channel, and by thirds of its rows and of its columns.
fn parts(picture: &Picture) -> Vec<f64> {
    let mut parts = light_by_channel(picture);
    let first = parts.len();
    parts.resize(first + 6, 0.0);
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let value: f64 = pixel.iter().map(|&c| f64::from(c)).sum();
        parts[first + i / 48 / 11] += value;
        parts[first + 3 + i % 48 / 16] += value;
    }
    parts
}

#[test]
fn light_paths_change_no_light_of_a_moving_world() {
    assert_same_light(&cases(), [1024, 192, 576], 1.3e-3, parts);
}

#[test]
fn motion_and_rolling_shutter_are_simulated_and_move_light() {
    for case in &cases() {
        let moving = job(case, true, 1, 64);
        let rolls = case.changes.rolling.is_some();
        assert!(moving.plan.has(Effect::Motion), "{}: {}", case.name, moving.plan.line());
        assert_eq!(moving.plan.has(Effect::RollingShutter), rolls, "{}", moving.plan.line());
        let mut still = moving.clone();
        still.timing = still.timing.map(|mut timing| {
            timing.camera_motion = None;
            timing
        });
        let mut others = vec![("objects", Job { timing: None, ..moving.clone() })];
        if !case.before.is_empty() {
            others.push(("camera", still));
        }
        if rolls {
            let changes = Changes { rolling: None, ..case.changes.clone() };
            others.push(("rows", job(&Case { changes, ..case.clone() }, true, 1, 64)));
        }
        let moving = picture(&moving, Backend::Simd, 1);
        for (what, other) in others {
            let other = picture(&other, Backend::Simd, 1);
            let off: f64 = (moving.pixels.iter().zip(&other.pixels))
                .map(|(a, b)| f64::from((a[1] - b[1]).abs()))
                .sum();
            println!("{}, {what}: {:.3}", case.name, off / light(&moving));
            assert!(off > 0.05 * light(&moving), "{}, {what}: {off}", case.name);
        }
    }
}

#[test]
fn the_moving_picture_is_the_same_for_all_threads_lanes_and_crops() {
    cases().iter().for_each(assert_same_bits);
}

#[test]
fn rows_without_motion_blur_take_no_light_paths() {
    let mut case = cases().swap_remove(2);
    case.changes.effects = "-motion,-ghosts,-diffraction".parse().expect("effects");
    let job = job(&case, true, 0, 4);
    assert!(job.plan.has(Effect::RollingShutter) && job.lamp_images.is_none());
    let reason = "a rolling shutter reads rows without motion blur";
    assert!(job.plan.light_paths.reason.contains(reason), "{}", job.plan.light_paths);
}

#[test]
fn shards_have_the_light_of_a_whole_moving_picture() {
    let workspace = Workspace::new();
    let lens = crate::support::root().join("lenses/dgauss.50mm.dat");
    let text = format!(
        r#"Film "rgb" "integer xresolution" 48 "integer yresolution" 32 {RIDE}
           Camera "realistic" "string lensfile" "{}" "float focusdistance" 3
           WorldBegin {POST}"#,
        lens.display()
    );
    std::fs::write(workspace.path("post.pbrt"), text).expect("a scene");
    workspace.merges_to_the_whole(
        "render post.pbrt --spp 90 --light-paths on --effects -ghosts,-diffraction \
         --shutter open=0,close=0.25 --rolling-shutter 0.6,up",
    );
}
