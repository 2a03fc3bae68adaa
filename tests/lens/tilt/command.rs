//! Lens files, scene files and options that tilt and shift film and elements.

use petzval_lens::{LensError, LensModel, Pose, Prescription, TiltDecenter};
use petzval_lens_formats::parse_toml;
use petzval_render::Backend;
use petzval_render::plan::{Effect, EffectSelection};
use petzval_render::prepare::{Changes, prepare};
use petzval_scene_formats::pbrt;
use serde_json::Value;
use std::fmt::Write as _;
use std::path::Path;

use crate::support::oracle::{Oracle, unit};
use crate::support::{Random, folder, lens, petzval, picture, root, write};

/// Returns the double Gauss as a lens file, with keys of its second surface and text at the end.
fn dgauss(keys: &str, end: &str) -> String {
    let mut text = String::new();
    for (i, row) in lens("dgauss.50mm").rows.iter().enumerate() {
        let keys = if i == 1 { keys } else { "" };
        let _ = write!(
            text,
            "[[surface]]\nradius = {:?}\nthickness = {:?}\nindex = {:?}\ndiameter = {:?}\n\
             stop = {}\n{keys}\n",
            row.radius, row.thickness, row.index, row.diameter, row.stop
        );
    }
    text + end
}

fn parsed(text: &str) -> Result<Prescription, LensError> {
    parse_toml(Path::new("test.toml"), text)
}

const POSED: &str = "decentre = [0.1, -0.2]\ntilt = [0.5, 0]";
const GROUPS: &str = "[[askew]]\nsurfaces = [3, 4]\ntilt = [0, 1.5]\n\
                      [[askew]]\nsurfaces = [1, 5]\ndecentre = [0.3, 0.0]\n";

#[test]
fn lens_files_give_tilts_and_decentres() {
    let lens = parsed(&dgauss(POSED, GROUPS)).expect("a lens");
    assert_eq!(lens.rows[1].pose, Pose { decentre: [0.1, -0.2], tilt: [0.5, 0.0] });
    assert_eq!(lens.rows[0].pose, Pose::ALIGNED);
    let inner = TiltDecenter { rows: [2, 3], pose: Pose { decentre: [0.0; 2], tilt: [0.0, 1.5] } };
    let outer = TiltDecenter { rows: [0, 4], pose: Pose { decentre: [0.3, 0.0], tilt: [0.0; 2] } };
    assert_eq!(lens.tilt_decenters, [inner, outer]);
    assert!(lens.is_misaligned() && !lens.is_round());
    assert!(!parsed(&dgauss("tilt = [0, 0]", "")).expect("a lens").is_misaligned());
}

#[test]
fn impossible_poses_are_refused_with_their_line() {
    let surface = |keys: &str| dgauss(keys, "");
    let body = |keys: &str| dgauss("", &format!("[[askew]]\n{keys}\n"));
    for (text, expected) in [
        (
            surface("tilt = [60, 0]"),
            "test.toml:14:8: tilt holds 60; expected [x, y], each from -45",
        ),
        (surface("tilt = 3"), "test.toml:14:8: tilt is not a pair of finite numbers"),
        (surface("decentre = [1]"), "test.toml:14:12: decentre is not a pair of finite numbers"),
        (surface("decentre = [inf, 0]"), "decentre is not a pair of finite numbers"),
        (surface("decentre = [0, 5000]"), "decentre holds 5000; expected [x, y], each from -1000"),
        (surface("decenter = [0, 1]"), "unknown key \"decenter\"; did you mean \"decentre\"?"),
        (body("tilt = [1, 0]"), "askew without surfaces; expected surfaces = [first, last]"),
        (body("surfaces = [4, 3]"), "surfaces is [4, 3]"),
        (body("surfaces = [0, 3]"), "surfaces is [0, 3]"),
        (body("surfaces = [1, 12]"), "whole numbers from 1 to 11"),
        (body("surfaces = [1.5, 3]"), "surfaces is [1.5, 3]"),
        (body("surfaces = [1, 2]\ntilted = [1, 0]"), "unknown key \"tilted\""),
        (format!("askew = 3\n{}", surface("")), "test.toml:1:9: askew is not a list"),
        (format!("askew = [3]\n{}", surface("")), "an entry of askew without keys"),
    ] {
        let error = parsed(&text).expect_err(expected).to_string();
        assert!(error.contains(expected), "{error}\ndoes not contain\n{expected}");
    }
}

#[test]
fn lens_trace_of_a_misaligned_lens_agrees_with_the_oracle() {
    let folder = folder();
    let text = dgauss(POSED, GROUPS);
    let lens = parsed(&text).expect("a lens");
    let (oracle, length) = (Oracle::new(&lens), lens.length());
    let mut random = Random::new(2);
    let (mut csv, mut rays) = (String::new(), Vec::new());
    for _ in 0..300 {
        let mut between = |half: f64| random.between(-half, half);
        let p = [between(10.0), between(10.0), length + 36.77];
        let d = unit([between(8.0) - p[0], between(8.0) - p[1], -36.77]);
        let _ = writeln!(csv, "{},{},{},{},{},{}", p[0], p[1], p[2], d[0], d[1], d[2]);
        rays.push((p, d));
    }
    let file = write(&folder, "tilted.toml", text);
    let table = write(&folder, "rays.csv", csv);
    let (file, table) = (file.display().to_string(), table.display().to_string());
    let (code, stdout, stderr) =
        petzval(root(), &["lens", "trace", &file, "--rays", &table, "--precision", "f64"]);
    assert_eq!(code, 0, "{stderr}");
    let mut out = 0;
    for (line, (p, d)) in stdout.lines().zip(rays) {
        let outcome = oracle.trace(36.77, [p[0], p[1], 0.0], [d[0], d[1], -d[2]]);
        match outcome.end {
            Ok(exit) => {
                out += 1;
                let numbers: Vec<f64> = line.split(',').map(|n| n.parse().unwrap()).collect();
                let s = -exit.p[2] / exit.d[2];
                let there = [exit.p[0] + s * exit.d[0], exit.p[1] + s * exit.d[1], 0.0];
                let towards = [exit.d[0], exit.d[1], -exit.d[2]];
                for (ours, oracle) in numbers.iter().zip([there, towards].concat()) {
                    assert!((ours - oracle).abs() < 1e-9, "{line}: {there:?} {towards:?}");
                }
            }
            Err(end) => {
                assert!(line.starts_with(&format!("blocked,{},", end.row + 1)), "{line} {end:?}");
            }
        }
    }
    assert!(out > 50, "{out}");
    let (_, stdout, _) = petzval(root(), &["lens", &file]);
    assert!(stdout.contains("surface 2: decentred by 0.1, -0.2 mm, tilted by 0.5, 0 de"));
    assert!(stdout.contains("surfaces 3 to 4: decentred by 0, 0 mm, tilted by 0, 1.5 de"));
    assert!(stdout.contains("for the lens without tilt and decentre"), "{stdout}");
}

/// Returns a scene of a checkerboard at 2 m, with these parameters of the camera.
fn wall(camera: &str) -> String {
    format!(
        r#"Film "rgb" "integer xresolution" 24 "integer yresolution" 16 "float diagonal" 43.3
           Sampler "sobol" "integer pixelsamples" 16
           Camera "realistic" "string lensfile" "{}/lenses/dgauss.50mm.dat"
               "float aperturediameter" 8 "float focusdistance" 2 {camera}
           WorldBegin LightSource "infinite" "rgb L" [1 1 1]
           Texture "checks" "spectrum" "checkerboard" "float uscale" 20 "float vscale" 20
           Material "diffuse" "texture reflectance" "checks"
           Shape "trianglemesh" "integer indices" [0 1 2 0 2 3] "point2 uv" [0 0 1 0 1 1 0 1]
               "point3 P" [-2 -2 2  2 -2 2  2 2 2  -2 2 2]"#,
        root().display()
    )
}

fn job(text: &str, changes: &Changes) -> Result<petzval_render::job::Job, String> {
    let folder = folder();
    let path = write(&folder, "wall.pbrt", text);
    let description = pbrt::read(&path).map_err(|error| error.to_string())?;
    prepare(description, changes).map(|prepared| prepared.job).map_err(|error| error.to_string())
}

#[test]
fn parameters_of_the_scene_equal_the_options() {
    let text = wall(r#""point2 filmshift" [4 -2] "point2 filmtilt" [3 1]"#);
    let asked = Changes {
        film_shift: Some([4.0, -2.0]),
        film_tilt: Some([3.0, 1.0]),
        ..Changes::default()
    };
    let by_scene = job(&text, &Changes::default()).expect("a job");
    let by_flag = job(&wall(""), &asked).expect("a job");
    let LensModel::Real(lens) = &by_scene.camera.model else { panic!("a real lens") };
    assert_eq!(lens.film_pose, Pose { decentre: [-4.0, 2.0], tilt: [3.0, 1.0] });
    let pixels = |job: &petzval_render::job::Job| picture(job, Backend::Simd, 2).pixels;
    let posed = pixels(&by_scene);
    assert_eq!(posed, pixels(&by_flag));
    assert_eq!(posed, picture(&by_scene, Backend::Scalar, 1).pixels);
    let square = pixels(&job(&wall(""), &Changes::default()).expect("a job"));
    assert_ne!(posed, square);
    // Without the effect film and elements are aligned.
    let effects: EffectSelection = "-tilt_shift".parse().expect("a list");
    let off = job(&text, &Changes { effects, ..Changes::default() }).expect("a job");
    assert_eq!(pixels(&off), square);
    for (job, on) in [(&by_scene, true), (&off, false)] {
        assert_eq!(job.plan.has(Effect::TiltShift), on);
    }
}

#[test]
fn the_plan_names_the_source_of_a_tilt_and_its_error() {
    let row = |arguments: &[&str]| {
        let (code, stdout, stderr) = petzval(root(), &[&["plan"], arguments, &["--json"]].concat());
        assert_eq!(code, 0, "{stderr}");
        let plan: Value = serde_json::from_str(&stdout).expect("JSON");
        let effects = plan["effects"].as_array().expect("a list").clone();
        effects.into_iter().find(|row| row["effect"] == "tilt_shift").expect("the row")
    };
    let scene = ["scenes/dgauss.pbrt"];
    assert_eq!(row(&scene)["on"], false);
    let shifted = row(&[scene[0], "--film-shift", "3,-4"]);
    assert_eq!((&shifted["on"], &shifted["by"]), (&Value::from(true), &Value::from("flag")));
    let um = shifted["error"]["um"].as_f64().expect("a number");
    assert!((um - 5000.0).abs() < 1.0, "{shifted}");
    let folder = folder();
    let file = write(&folder, "tilted.toml", dgauss(POSED, GROUPS));
    let file = file.display().to_string();
    let tilted = row(&[scene[0], "--lens", &file]);
    assert_eq!((&tilted["on"], &tilted["by"]), (&Value::from(true), &Value::from("lens")));
    let off = row(&[scene[0], "--lens", &file, "--effects", "-tilt_shift"]);
    assert_eq!((&off["on"], &off["by"]), (&Value::from(false), &Value::from("flag")));
    // The estimated error is the same with the effect on and off, but for other random rays.
    let um = |row: &Value| row["error"]["um"].as_f64().expect("a number");
    assert!((um(&off) / um(&tilted) - 1.0).abs() < 0.1, "{off} {tilted}");
}

#[test]
fn impossible_film_poses_are_refused() {
    for (camera, expected) in [
        (
            r#""point2 filmtilt" [60 0]"#,
            "\"filmtilt\" is [60 0]; expected two numbers, each from -45",
        ),
        (r#""point2 filmshift" [1 0 2]"#, "3 numbers for \"point2 filmshift\""),
        (r#""string filmshift" "far""#, "\"filmshift\" of type point2"),
    ] {
        let error = job(&wall(camera), &Changes::default()).expect_err(expected);
        assert!(error.contains(expected) && error.contains("wall.pbrt:4:"), "{error}: {expected}");
    }
    // The corner of the film would lie in the rear element.
    let close = Changes { film_tilt: Some([45.0, 45.0]), ..Changes::default() };
    let wide = wall("").replace("43.3", "150");
    let error = job(&wide, &close).expect_err("no room");
    assert!(error.contains("where it is nearest, would stand inside the lens"), "{error}");
    let thin = r#"Camera "perspective" WorldBegin LightSource "infinite""#;
    let error = job(thin, &close).expect_err("no lens");
    assert!(error.contains("'film_tilt' is given, but this camera has no lens file"), "{error}");
    for value in ["1", "1,2,3", "a,b", "nan,0", "46,0", "inf,0"] {
        let (code, _, stderr) =
            petzval(root(), &["plan", "scenes/dgauss.pbrt", "--film-tilt", value]);
        assert_eq!(code, 2, "{value}");
        assert!(stderr.contains("each from -45 to 45 degrees"), "{stderr}");
    }
}
