//! `petzval lens tolerance` and `petzval lens optimize`: output, files and errors.

use serde_json::Value;

use crate::support::{folder, petzval, root};

fn lens(name: &str) -> String {
    root().join("lenses").join(name).display().to_string()
}

fn json(folder: &std::path::Path, arguments: &[&str]) -> Value {
    let (code, out, err) = petzval(folder, arguments);
    assert_eq!(code, 0, "{err}");
    serde_json::from_str(&out).expect("JSON")
}

/// Spot and MTF of all fields of a worst lens differ by this share when its file is read back: its
/// rays are aimed anew.
const READ_BACK: f64 = 5e-3;

#[test]
fn the_worst_lens_as_a_file_has_the_figures_of_its_trial() {
    let folder = folder();
    for file in ["triplet.toml", "dgauss.50mm.dat"] {
        let lens = lens(file);
        let mut arguments = vec!["lens", "tolerance", lens.as_str(), "--json", "--trials", "30"];
        arguments.extend(["--grade", "commercial", "--image-height", "15"]);
        arguments.extend(["-o", "worst.toml", "--worst", "2"]);
        let found = json(folder.path(), &arguments);
        let trial = &found["worst"][1];
        let again =
            json(folder.path(), &["lens", "tolerance", "worst.toml", "--json", "--trials", "0"]);
        let arguments = ["lens", "tolerance", lens.as_str(), "--json", "--trials", "0"];
        let own = json(folder.path(), &[&arguments[..], &["--image-height", "15"]].concat());
        let spot = |value: &Value| value["spot"]["nominal"].as_f64().expect("a spot");
        let expected = trial["spot"].as_f64().expect("a spot");
        assert!(
            (spot(&again) / expected - 1.0).abs() < READ_BACK,
            "{file}: {} {expected}",
            spot(&again)
        );
        let (mtf, trial_mtf) = (&again["mtf"]["nominal"], &trial["mtf"]);
        let off = mtf.as_f64().expect("MTF") - trial_mtf.as_f64().expect("MTF");
        assert!(off.abs() < READ_BACK, "{file}: {mtf} {trial_mtf}");
        assert!(spot(&again) > 1.1 * spot(&own), "{file}: a bad lens");
    }
}

#[test]
fn a_worst_lens_takes_a_photograph() {
    let folder = folder();
    let lens = lens("triplet.toml");
    let arguments =
        ["lens", "tolerance", &lens, "--trials", "5", "--rings", "4", "-o", "worst.toml"];
    let (code, out, err) = petzval(folder.path(), &arguments);
    assert_eq!(code, 0, "{err}");
    assert!(out.contains("worst tolerances") && err.contains("film "), "{out}{err}");
    let scene = root().join("scenes/dgauss.pbrt").display().to_string();
    let arguments =
        ["render", &scene, "--lens", "worst.toml", "--spp", "1", "--resolution", "24x16"];
    let (code, _, err) = petzval(folder.path(), &[&arguments[..], &["-o", "a.exr"]].concat());
    assert_eq!(code, 0, "{err}");
}

#[test]
fn the_table_of_trials_has_the_variance_of_the_tolerances() {
    let folder = folder();
    let lens = lens("triplet.toml");
    let arguments = ["lens", "tolerance", &lens, "--trials", "600", "--rings", "2"];
    let rest = ["--grade", "none", "--thickness", "0.05", "--distribution", "uniform"];
    let (code, _, err) =
        petzval(folder.path(), &[&arguments[..], &rest, &["--csv", "trials.csv"]].concat());
    assert_eq!(code, 0, "{err}");
    let text = std::fs::read_to_string(folder.path().join("trials.csv")).expect("a table");
    let head: Vec<&str> = text.lines().next().expect("a head").split(',').collect();
    let column = head.iter().position(|name| *name == "thickness 1 (mm)").expect("a column");
    let of =
        |line: &str| line.split(',').nth(column).and_then(|v| v.parse().ok()).expect("a number");
    let all: Vec<f64> = text.lines().skip(1).map(of).collect();
    assert_eq!(all.len(), 600);
    let mean = all.iter().sum::<f64>() / 600.0_f64;
    let variance = all.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / 600.0;
    let expected: f64 = 0.05 * 0.05 / 3.0;
    assert!(mean.abs() < 4.0 * (expected / 600.0_f64).sqrt(), "mean {mean}");
    assert!((variance / expected - 1.0).abs() < 0.12, "variance {variance}, expected {expected}");
    assert!(all.iter().all(|x| x.abs() <= 0.05));
}

#[test]
fn an_optimized_lens_is_written_and_reads_back_as_good() {
    let folder = folder();
    let lens = lens("triplet.toml");
    let arguments = ["lens", "optimize", &lens, "-o", "better.toml", "--vary", "r1,r3,r6,t2"];
    let rest = ["--target", "efl=50:10", "--target", "spot", "--bound", "t2=5..7"];
    let (code, out, err) = petzval(folder.path(), &[&arguments[..], &rest].concat());
    assert_eq!(code, 0, "{err}");
    for part in ["r1 ", "t2 ", "efl ", "merit ", "stopped after"] {
        assert!(out.contains(part), "{part}: {out}");
    }
    let spot = |file: &str| {
        let arguments = ["lens", "tolerance", file, "--json", "--trials", "0"];
        let value = json(folder.path(), &arguments);
        value["spot"]["nominal"].as_f64().expect("a spot")
    };
    assert!(spot("better.toml") < spot(&lens));
}

#[test]
fn wrong_arguments_name_the_remedy() {
    let folder = folder();
    let (triplet, dgauss) = (lens("triplet.toml"), lens("dgauss.50mm.dat"));
    let optimize = |rest: &[&str]| {
        let head = ["lens", "optimize", triplet.as_str(), "-o", "a.toml", "--target", "spot"];
        [&head[..], rest].concat().iter().map(|word| (*word).to_owned()).collect::<Vec<_>>()
    };
    let tolerance = |rest: &[&str]| {
        let head = ["lens", "tolerance", dgauss.as_str()];
        [&head[..], rest].concat().iter().map(|word| (*word).to_owned()).collect::<Vec<_>>()
    };
    for (arguments, remedy) in [
        (tolerance(&["--tilt", "1"]), "with its unit"),
        (tolerance(&["--radius", "1"]), "fringes"),
        (tolerance(&["--grade", "best"]), "commercial"),
        (tolerance(&["--trials", "3", "-o", "a.toml", "--worst", "4"]), "at most --trials"),
        (tolerance(&["-o", "a.dat"]), "name the file a.toml"),
        (tolerance(&["--image-height", "500"]), "--image-height"),
        (tolerance(&["--fields", "0,2"]), "from 0 to 1"),
        (optimize(&["--vary", "q3"]), "expected r3"),
        (optimize(&["--vary", "r9"]), "from 1 to 6"),
        (optimize(&["--vary", "n1"]), "index and abbe instead of glass"),
        (optimize(&["--vary", "t6"]), "vary film"),
        (optimize(&["--vary", "r1,c1"]), "name it once"),
        (optimize(&["--vary", "r1", "--bound", "r1=1..2"]), "vary c1"),
        (optimize(&["--vary", "t1", "--bound", "t1=8..9"]), "bounds around it"),
        (optimize(&["--vary", "r1", "--target", "efl"]), "needs a value"),
        (optimize(&["--vary", "film", "--refocus", "axis"]), "leave one of them out"),
    ] {
        let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let (code, _, err) = petzval(folder.path(), &words);
        assert_eq!(code, 2, "{words:?}: {err}");
        let joined = err.split_whitespace().collect::<Vec<_>>().join(" ");
        assert!(joined.contains(remedy), "{words:?}: {err}");
    }
    assert_eq!(std::fs::read_dir(folder.path()).expect("a folder").count(), 0);
}
