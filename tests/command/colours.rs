//! The chart of colours, rendered, developed and measured.

use std::path::Path;

use serde_json::Value;

use crate::support::{folder, petzval, root, write};

const CAMERA: [&str; 8] =
    ["--film-size", "36x24", "--resolution", "240x160", "--focus", "2m", "--fstop", "8"];

/// Draws a chart, and returns the options of the command that measures it.
fn draw(at: &Path, kind: &str) -> Vec<String> {
    let lens = root().join("lenses/dgauss.50mm.dat");
    let scene = format!("{kind}.pbrt");
    let words = ["chart", kind, lens.to_str().expect("UTF-8"), "-o", &scene];
    let (code, stdout, stderr) = petzval(at, &[&words[..], &CAMERA].concat());
    assert_eq!(code, 0, "{stderr}");
    stdout.lines().last().unwrap_or_default().split(' ').map(String::from).collect()
}

fn run(at: &Path, words: &str) -> String {
    let words: Vec<&str> = words.split(' ').collect();
    let (code, stdout, stderr) = petzval(at, &words);
    assert_eq!(code, 0, "{words:?}: {stderr}");
    stdout
}

fn number(found: &Value) -> f64 {
    found.as_f64().expect("a number")
}

#[test]
fn rendered_colours_are_those_of_the_chart() {
    let folder = folder();
    let at = folder.path();
    draw(at, "flat");
    let told = draw(at, "colours");
    assert_eq!(told[..4], ["petzval", "measure", "colours", "colours.exr"]);
    let region = &told[5];
    run(at, "render flat.pbrt -q -o flat.exr --spp 64");
    // Colours of spectra within 0.05; in RGB, cyan is outside the gamut, and no other.
    for (effects, exact, cyan) in [("+spectra", 24, 0.0), ("-spectra", 23, 2.37)] {
        run(at, &format!("render colours.pbrt -q -o colours.exr --spp 64 --effects={effects}"));
        let measure = format!(
            "measure colours colours.exr --region {region} --flat flat.exr --json --csv c.csv"
        );
        let found: Value = serde_json::from_str(&run(at, &measure)).expect("JSON");
        let differences: Vec<f64> = found["patches"]
            .as_array()
            .expect("patches")
            .iter()
            .map(|patch| number(&patch["de2000"]))
            .collect();
        let near = differences.iter().filter(|&&difference| difference < 0.05).count();
        assert_eq!(near, exact, "{effects}: {differences:.3?}");
        assert!((differences[17] - cyan).abs() < 0.05, "{effects}: {differences:.3?}");
        assert!((number(&found["brightness"]) - 1.0).abs() < 1e-3, "{found:#}");
        let table = std::fs::read_to_string(at.join("c.csv")).expect("a table");
        assert_eq!(table.lines().count(), 25);
        assert!(table.lines().nth(1).expect("a row").starts_with("dark skin,0.1"), "{table}");
    }
    // Without the white chart, the falloff of the lens remains.
    let text = run(at, &format!("measure colours colours.exr --region {region}"));
    assert!(text.starts_with("mean dE2000 0.") && text.contains("largest 2."), "{text}");
    let (code, _, stderr) =
        petzval(at, &["measure", "colours", "colours.exr", "--region", "0,0,100,66", "--json"]);
    assert!(code == 0 && stderr.contains("probably not the patches"), "{stderr}");
    for (arguments, expected) in [
        ("colours.exr --region 0,0,300,10", "240 x 160 pixels; expected X0,Y0,X1,Y1 within it"),
        ("colours.exr --region 0,0,30,20", "expected at least 6 x 6"),
        ("colours.exr --region 0,0,30", "--region"),
        ("none.exr --region 0,0,30,20", "none.exr"),
        ("colours.exr --region 0,0,100,66 --csv colours.exr", "--csv"),
    ] {
        let words: Vec<&str> =
            ["measure", "colours"].into_iter().chain(arguments.split(' ')).collect();
        let (code, _, stderr) = petzval(at, &words);
        assert_eq!(code, 2, "{arguments}: {stderr}");
        assert!(stderr.contains(expected), "{arguments}: {stderr}");
    }
}

#[test]
fn colours_of_a_developed_raw_file_are_those_of_its_camera() {
    let folder = folder();
    let at = folder.path();
    draw(at, "flat");
    let told = draw(at, "colours");
    for kind in ["flat", "colours"] {
        let scene = std::fs::read_to_string(at.join(format!("{kind}.pbrt"))).expect("a scene");
        let camera = scene.replace("Film \"rgb\"", "Film \"rgb\" \"string sensor\" \"nikon_d850\"");
        write(&folder, "camera.pbrt", camera);
        let sensor = "--bayer --sensor iso=100,bits=16,well=1e8,read=0 --spp 16 --effects +spectra";
        run(at, &format!("render camera.pbrt -q -o {kind}.dng {sensor}"));
        run(at, &format!("develop {kind}.dng -q -o {kind}.exr"));
    }
    run(at, "develop colours.dng -q -o warm.exr --white-balance A");
    let measure = |picture: &str| -> Value {
        let region = &told[5];
        let words = format!("measure colours {picture} --region {region} --flat flat.exr --json");
        serde_json::from_str(&run(at, &words)).expect("JSON")
    };
    // A matrix cannot give a camera the eye's colours: published profiles leave 1 to 2 (dE2000).
    let balanced = measure("colours.exr");
    let mean = number(&balanced["mean_de2000"]);
    assert!((0.5..2.0).contains(&mean), "{balanced:#}");
    let error = |found: &Value| [0, 1].map(|i| number(&found["white_balance_error"][i]));
    assert!(error(&balanced).iter().all(|error| error.abs() < 0.5), "{balanced:#}");
    // Daylight is blue to a camera that is balanced to tungsten.
    let warm = measure("warm.exr");
    assert!(error(&warm)[1] < -20.0, "{warm:#}");
}
