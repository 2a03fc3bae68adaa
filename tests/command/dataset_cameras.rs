//! `petzval dataset`: cameras of the manifest, rigs and trajectories.

use glam::{DMat3, DQuat, DVec3};
use petzval::Picture;
use petzval_base::io::ReadContext;
use petzval_image::PictureLayers;
use serde_json::Value;

use super::dataset::{read, rows, run, scene};
use crate::support::folder;

/// The lamp of the scene.
const LAMP: [f64; 3] = [0.35, 0.22, 2.0];

/// Returns the centre of the light above a threshold, in pixels whose centres are whole numbers.
fn lamp(picture: &Picture) -> [f64; 2] {
    let width = picture.size[0];
    let (mut sum, mut at) = (0.0, [0.0; 2]);
    for (i, pixel) in picture.pixels.iter().enumerate() {
        let light = f64::from(pixel[1]);
        let light = if light > 2.0 { light } else { 0.0 };
        sum += light;
        at[0] += light * (i % width) as f64;
        at[1] += light * (i / width) as f64;
    }
    at.map(|v| v / sum)
}

#[test]
fn the_cameras_of_the_manifest_place_a_lamp_where_the_pictures_show_it() {
    let folder = folder();
    scene(&folder, "");
    let spec = "pairs = 2\nresolution = [240, 180]\nspp = 64\nexposure = 3.0\n[draw]\n\
                scene = \"scene.pbrt\"\nfstop = 4.0\nfocus = 2.0\nmove = 0.02\nturn = 2.0\n\
                [degraded]\neffects = \"none\"\n";
    let (code, _, log) = run(folder.path(), spec, &[]);
    assert_eq!(code, 0, "{log}");
    for row in rows(folder.path()) {
        let pair = row["pair"].as_u64().expect("a number") as u32;
        for kind in ["clean", "degraded"] {
            let number = |value: &Value| value.as_f64().expect("a number");
            let camera = &row[kind]["camera"];
            let pose = |r: usize, c: usize| number(&row[kind]["world_from_camera"][r][c]);
            // The inverse of a rotation is its transpose.
            let mut at: [f64; 3] = std::array::from_fn(|c| {
                let world = LAMP;
                let length: f64 = (0..3).map(|r| pose(r, c) * pose(r, c)).sum::<f64>().sqrt();
                (0..3).map(|r| pose(r, c) * (world[r] - pose(r, 3))).sum::<f64>() / length
            });
            if kind == "degraded" {
                at[2] -= number(&camera["projection_centre_mm"][2]) / 1000.0;
            }
            let (x, y) = (at[0] / at[2], -at[1] / at[2]);
            let k = |name: &str| camera["distortion"].get(name).map_or(0.0, number);
            let r2 = x * x + y * y;
            let bent = 1.0 + r2 * (k("k1") + r2 * (k("k2") + r2 * k("k3")));
            let matrix = |r: usize, c: usize| number(&camera["matrix"][r][c]);
            let expected =
                [x * bent * matrix(0, 0) + matrix(0, 2), y * bent * matrix(1, 1) + matrix(1, 2)];
            let found = lamp(&read(folder.path(), pair, kind));
            let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
            println!("{kind} {pair}: {found:?}, expected {expected:?}");
            assert!(off < 0.05, "{kind} of {pair}: {found:?} instead of {expected:?}");
        }
    }
}

#[test]
fn cameras_of_a_rig_stand_where_the_specification_says() {
    let folder = folder();
    scene(&folder, "");
    let spec = |pairs: u32, rig: &str| {
        format!(
            "pairs = {pairs}\nresolution = [24, 16]\nspp = 1\n[draw]\nscene = \"scene.pbrt\"\n\
             fstop = {{ from = 2.8, to = 8.0 }}\nmove = 0.5\nturn = 20.0\nrig = {rig}\n\
             [degraded]\neffects = \"none\"\n"
        )
    };
    let rig = "[[0.0, 0.0, 0.0], [0.12, 0.01, 0.02], [0.0, 0.0, 0.0, 30.0, 0.0, 0.0]]";
    let (code, _, log) = run(folder.path(), &spec(6, rig), &[]);
    assert_eq!(code, 0, "{log}");
    let rows = rows(folder.path());
    let axes = |row: &Value| {
        let number = |r: usize, c: usize| {
            row["degraded"]["world_from_camera"][r][c].as_f64().expect("a number")
        };
        [0, 1, 2, 3].map(|c| DVec3::from_array([0, 1, 2].map(|r| number(r, c))))
    };
    for (view, cameras) in (0..).zip(rows.chunks(3)) {
        let [[right, up, forward, eye], [_, _, parallel, second], [.., turned, third]] =
            [0, 1, 2].map(|i| axes(&cameras[i]));
        let expected = eye + 0.12 * right + 0.01 * up + 0.02 * forward;
        assert!(second.distance(expected) < 1e-9, "{second} instead of {expected}");
        assert!(parallel.distance(forward) < 1e-9 && third.distance(eye) < 1e-9);
        let [sine, cosine] = [30.0_f64.to_radians().sin(), 30.0_f64.to_radians().cos()];
        assert!(turned.distance(cosine * forward + sine * right) < 1e-9, "{turned}");
        for (camera, row) in (0..).zip(cameras) {
            assert_eq!([&row["view"], &row["rig_camera"]], [view, camera]);
            assert_eq!(row["f_number"], cameras[0]["f_number"]);
        }
        assert_ne!(cameras[0]["seed"], cameras[1]["seed"]);
    }
    assert_ne!(rows[0]["f_number"], rows[3]["f_number"]);
    for (pairs, rig, expected) in [
        (7, rig, "expected a multiple of the 3 cameras of draw.rig"),
        (2, "[[0.0, 1.0]]", "expected [right, up, forward] in m"),
        (2, "[[0.0, 0.0, inf]]", "rig = inf: expected"),
    ] {
        let (code, _, log) = run(folder.path(), &spec(pairs, rig), &[]);
        assert!(code == 2 && log.contains(expected), "{log}");
    }
}

#[test]
fn a_camera_follows_a_trajectory_of_poses() {
    let folder = folder();
    scene(&folder, "");
    // TUM's format: a camera with y down in a right-handed world, the scene's with y negated.
    let poses = [
        ([0.0, 0.0, 0.0], DQuat::IDENTITY),
        ([0.1, 0.05, -0.2], DQuat::from_rotation_y(0.05) * DQuat::from_rotation_z(0.3)),
        ([-0.1, -0.1, 0.1], DQuat::from_rotation_x(0.08)),
    ];
    let line = |(i, ([x, y, z], turn)): (usize, &([f64; 3], DQuat))| {
        let [a, b, c, d] = turn.to_array();
        format!("{i}.5 {x} {y} {z} {a} {b} {c} {d}\n")
    };
    let text: String = poses.iter().enumerate().map(line).collect();
    let write = |text: &str| {
        std::fs::write(folder.path().join("poses.txt"), text).expect("a file");
    };
    write(&format!("# time tx ty tz qx qy qz qw\n\n{text}"));
    let spec = |pairs: u32| {
        format!(
            "pairs = {pairs}\nresolution = [240, 180]\nspp = 32\nexposure = 3.0\n[draw]\n\
             scene = \"scene.pbrt\"\ntrajectory = \"poses.txt\"\n[degraded]\neffects = \"none\"\n"
        )
    };
    let (code, _, log) = run(folder.path(), &spec(3), &[]);
    assert_eq!(code, 0, "{log}");
    for (pair, (row, (position, turn))) in (0..).zip(rows(folder.path()).iter().zip(&poses)) {
        assert_eq!(row["trajectory_s"], f64::from(pair) + 0.5);
        let lamp_there = DVec3::new(LAMP[0], -LAMP[1], LAMP[2]);
        let mut seen =
            DMat3::from_quat(*turn).transpose() * (lamp_there - DVec3::from_array(*position));
        let number = |value: &Value| value.as_f64().expect("a number");
        // The pose is that of the camera's origin, on the film; the pinhole is in the entrance pupil.
        let eye = |kind: &str| {
            let row = |r: usize| number(&row[kind]["world_from_camera"][r][3]);
            DVec3::new(row(0), -row(1), row(2))
        };
        assert!(eye("degraded").distance(DVec3::from_array(*position)) < 1e-9);
        seen.z -= eye("clean").distance(eye("degraded"));
        let matrix = |r: usize, c: usize| number(&row["clean"]["camera"]["matrix"][r][c]);
        let expected = [0, 1].map(|i| seen[i] / seen.z * matrix(i, i) + matrix(i, 2));
        let found = lamp(&read(folder.path(), pair, "clean"));
        let off = (found[0] - expected[0]).hypot(found[1] - expected[1]);
        assert!(off < 0.1, "{pair}: {found:?} instead of {expected:?}");
    }
    std::fs::remove_dir_all(folder.path().join("out")).expect("a folder");
    let refuses = |spec: &str, expected: &str| {
        let (code, _, log) = run(folder.path(), spec, &[]);
        assert!(code == 2 && log.contains(expected), "{log}");
    };
    refuses(&spec(4), "poses.txt has 3 poses for 4 views");
    write("1 0 0 0 0 0 0 1\n2 0 0 0 0 0 1\n");
    refuses(&spec(1), "poses.txt:2: found 7 numbers; expected time x y z");
    write("# nothing\n");
    refuses(&spec(1), "poses.txt has no poses");
}

#[test]
fn cameras_of_a_rig_rest_and_pinholes_have_motion_of_their_own() {
    let folder = folder();
    // The camera moves by 0.2 m to the right.
    scene(&folder, "ActiveTransform EndTime Translate -0.2 0 0 ActiveTransform All");
    let spec = |pairs: u32, rig: &str| {
        format!(
            "pairs = {pairs}\nresolution = [60, 40]\nspp = 4\nlayers = [\"motion\"]\n[draw]\n\
             scene = \"scene.pbrt\"\n{rig}\n"
        )
    };
    let number = |value: &Value| value.as_f64().expect("a number");
    let (code, _, log) = run(folder.path(), &spec(1, ""), &[]);
    assert_eq!(code, 0, "{log}");
    let row = rows(folder.path()).remove(0);
    let path = folder.path().join("out/000000.clean.exr");
    let layers = PictureLayers::read(&path, &ReadContext::default()).expect("layers");
    let motion = layers.layers.iter().find(|layer| layer.name == "motion").expect("a layer");
    // The wall, 4 m away, as the pinhole in the entrance pupil sees it.
    let depth = 4.0 - number(&row["clean"]["world_from_camera"][2][3]);
    let expected = -0.2 * number(&row["clean"]["camera"]["matrix"][0][0]) / depth;
    let found = f64::from(motion.channels[0].1[20 * 60 + 30]);
    assert!((found / expected - 1.0).abs() < 1e-3, "{found}, not {expected}");

    std::fs::remove_dir_all(folder.path().join("out")).expect("a folder");
    let rig =
        "rig = [[0.0, 0.0, 0.0], [0.06, 0.0, 0.0]]\n[degraded]\nsensor = \"hot=0.05/1e9,time=1\"";
    let (code, _, log) = run(folder.path(), &spec(2, rig), &[]);
    assert_eq!(code, 0, "{log}");
    let rows = rows(folder.path());
    let eyes = [0, 1].map(|i| number(&rows[i]["degraded"]["world_from_camera"][0][3]));
    assert!((eyes[1] - eyes[0] - 0.06).abs() < 1e-9, "{eyes:?}");
    // Hot pixels saturate. Those of the cameras are of two sensors.
    let hot = [0, 1].map(|pair| {
        let raw = read(folder.path(), pair, "raw");
        let hot = raw.pixels.iter().map(|pixel| pixel[1] > 0.99);
        hot.collect::<Vec<bool>>()
    });
    let [one, both] = [hot[0].iter().zip(&hot[0]), hot[0].iter().zip(&hot[1])]
        .map(|pairs| pairs.filter(|(a, b)| **a && **b).count());
    assert!(one > 60 && both < one / 3, "{both} of {one} hot pixels are the same");
    for row in &rows {
        let effects = row["degraded"]["effects"].as_array().expect("effects");
        assert!(!effects.iter().any(|effect| effect == "motion"), "{effects:?}");
    }
}
