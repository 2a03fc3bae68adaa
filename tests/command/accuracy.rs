//! `petzval accuracy`: comparison of models, its report, and its limits.

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::support::workspace::{finish, signal};
use crate::support::{folder, petzval, promptly, root, write};
use petzval_render::prepare::Changes;
use petzval_scene_formats::pbrt;
use petzval_tools::accuracy::{Budget, Ladder, LadderRun, RunEnd, RunMonitor, run_ladder};

/// Prepares a small comparison for the double Gauss.
fn ladder(changes: Changes) -> Ladder {
    let description = pbrt::read(&root().join("scenes/dgauss.pbrt")).expect("a scene");
    Ladder::new(&description, &changes, &RunMonitor::default()).expect("a ladder")
}

fn small() -> Changes {
    Changes { resolution: Some([48, 48]), ..Changes::default() }
}

/// Renders all models up to this many samples per pixel, practically without a time limit.
fn run(ladder: &mut Ladder, samples: u32) -> LadderRun {
    let budget = Budget { begun: Instant::now(), time: Duration::from_secs(600), samples };
    run_ladder(ladder, &budget, &RunMonitor::default()).expect("threads")
}

#[test]
fn the_bias_of_every_model_is_separated_from_noise() {
    let mut ladder = ladder(small());
    let found = run(&mut ladder, 64);
    let names: Vec<&str> = ladder.rungs.iter().map(|rung| rung.name.as_str()).collect();
    assert_eq!(names[..5], ["pinhole", "thin", "thick", "paraxial", "polynomial"]);
    let fresnel = ladder.rungs.iter().find(|rung| rung.name == "real f32 + fresnel");
    assert!(fresnel.is_some_and(|rung| (1.03..1.08).contains(&rung.exposure)), "{fresnel:?}");
    assert!(names.contains(&"real f32") && names.last() == Some(&"real f64"), "{names:?}");
    assert_eq!(found.end, RunEnd::Planned);
    let reference = found.reference.as_ref().expect("a reference");
    assert_eq!(reference.samples, 64);
    for (i, name) in names.iter().enumerate() {
        let own: Vec<u32> =
            found.points.iter().filter(|p| p.rung == i).map(|p| p.samples).collect();
        assert_eq!(own, [4, 8, 16, 32, 64], "{name}");
        let last = found.last(i).expect("a point");
        println!("{name}: {:.4} {:.4} {:?}", last.error, last.noise, last.bias);
        let Some(bias) = last.bias else { continue };
        match *name {
            "pinhole" | "thin" | "paraxial" => assert!(bias.size() > 0.02, "{name}: {bias:?}"),
            "real f32" => assert!(bias.at_most() < 1e-3, "{name}: {bias:?}"),
            // The plan leaves it out as an even loss is exposure, and so does the comparison.
            "real f32 + fresnel" => assert!(bias.at_most() < 0.01, "{name}: {bias:?}"),
            _ => {}
        }
        // The error is the sum of the bias, the noise and the noise of the reference.
        let parts = bias.square + last.noise + reference.noise;
        assert!((last.error / parts - 1.0).abs() < 0.25, "{name}: {} of {parts}", last.error);
    }
    let last = found.last(names.len() - 1).expect("a point of the richest");
    assert!(last.bias.is_none());
    let parts = last.noise + reference.noise;
    assert!((last.error / parts - 1.0).abs() < 0.25, "{} of {parts}", last.error);
    assert!(found.points.iter().any(|point| point.on_frontier));
}

#[test]
fn each_effect_of_the_plan_is_left_out_once() {
    let effects = "+fresnel,+ghosts".parse().expect("effects");
    let ladder = ladder(Changes { effects, ..small() });
    let names: Vec<&str> = ladder.rungs.iter().skip(5).map(|rung| rung.name.as_str()).collect();
    let expected =
        ["real f32 alone", "real f32 - fresnel", "real f32 - ghosts", "real f32"].into_iter();
    let expected: Vec<&str> =
        expected.chain(["real f32 + dispersion", "real f32 + spectra", "real f64"]).collect();
    assert_eq!(names, expected);
}

#[test]
fn rgb_is_wrong_under_a_fluorescent_lamp_and_one_wavelength_is_noisy() {
    let folder = folder();
    let lens = root().join("lenses/dgauss.50mm.dat");
    let scene = format!(
        "Film \"rgb\" \"float diagonal\" 20 Integrator \"path\" \"integer maxdepth\" 3
         Camera \"realistic\" \"string lensfile\" \"{}\" \"float focusdistance\" 3 WorldBegin
         LightSource \"infinite\" \"spectrum L\" \"stdillum-F11\" Material \"diffuse\"
         \"spectrum reflectance\" [400 0.04 580 0.05 600 0.3 620 0.7 700 0.8]
         Shape \"bilinearmesh\" \"point3 P\" [-4 -4 3  4 -4 3  -4 4 3  4 4 3]",
        lens.display()
    );
    let description = pbrt::read(&write(&folder, "scene.pbrt", &scene)).expect("a scene");
    let effects = "+spectra,-fresnel,-ghosts,-dispersion".parse().expect("effects");
    let changes = Changes { effects, ..small() };
    let mut ladder = Ladder::new(&description, &changes, &RunMonitor::default()).expect("a ladder");
    let found = run(&mut ladder, 256);
    let last = |name: &str| {
        let rung = ladder.rungs.iter().position(|rung| rung.name == name).expect("a rung");
        found.last(rung).expect("a point").clone()
    };
    let [rgb, one, three] =
        ["real f32 - spectra", "real f32, one wavelength", "real f32"].map(last);
    println!("{:?} {:?} {:?}", rgb.bias, one.bias, three.bias);
    println!("{:e} {:e} {:e}", rgb.noise, one.noise, three.noise);
    assert!(rgb.bias.expect("a bias").size() > 0.01, "{:?}", rgb.bias);
    assert!(!one.bias.expect("a bias").certain(), "{:?}", one.bias);
    assert!(three.bias.expect("a bias").at_most() < 1e-3, "{:?}", three.bias);
    assert!(one.noise > 1.5 * three.noise, "{} {}", one.noise, three.noise);
    let film = &ladder.rungs.iter().find(|rung| rung.name == "real f32 - spectra");
    println!("{film:?}");
}

/// File names of a report.
const FILES: [&str; 5] = ["accuracy.csv", "accuracy.json", "plot.svg", "plot.png", "index.html"];

/// Runs the command on a scene whose name HTML must escape, and returns the files of the report.
fn files() -> [Vec<u8>; 5] {
    let folder = folder();
    for (from, to) in [
        ("scenes/dgauss.pbrt", "scenes/a <b> & 'c'.pbrt"),
        ("scenes/cones.pbrt", "scenes/cones.pbrt"),
        ("scenes/grid.png", "scenes/grid.png"),
        ("lenses/double-gauss.50mm.toml", "lenses/double-gauss.50mm.toml"),
    ] {
        let to = folder.path().join(to);
        std::fs::create_dir_all(to.parent().expect("a folder")).expect("a folder");
        std::fs::copy(root().join(from), to).expect("a copy");
    }
    let arguments = ["accuracy", "scenes/a <b> & 'c'.pbrt", "--resolution", "48x48"];
    let limits = ["--spp", "8", "--budget", "600s", "-o", "report"];
    let (code, _, stderr) = petzval(folder.path(), &[&arguments[..], &limits].concat());
    assert_eq!(code, 0, "{stderr}");
    FILES.map(|name| std::fs::read(folder.path().join("report").join(name)).expect("a file"))
}

#[test]
fn the_files_of_the_report_are_complete() {
    let [csv, json, svg, png, page] = files();
    let mut csv = csv::Reader::from_reader(&csv[..]);
    let header = csv.headers().expect("a header").clone();
    for name in [
        "model",
        "spp",
        "seconds",
        "lens_seconds",
        "film_error_um",
        "mse",
        "relmse",
        "flip",
        "noise",
        "bias",
        "bias_error",
        "on_frontier",
    ] {
        assert!(header.iter().any(|column| column == name), "{name} in {header:?}");
    }
    let rows: Vec<csv::StringRecord> = csv.records().map(|row| row.expect("a row")).collect();
    let at = |name: &str| header.iter().position(|column| column == name).expect("a column");
    for row in &rows {
        for name in ["seconds", "mse", "relmse", "flip", "noise", "film_error_um"] {
            let value: f64 = row[at(name)].parse().expect("a number");
            assert!(value.is_finite() && value >= 0.0, "{name}: {value}");
        }
    }
    assert_eq!(&rows[0][at("spp")], "4");

    let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
    let models = json["models"].as_array().expect("models");
    let points: usize = models.iter().map(|m| m["points"].as_array().expect("points").len()).sum();
    assert_eq!(points, rows.len());
    assert_eq!(json["ended"], "planned");
    for (of, names) in [
        (&json, &["scene", "lens", "resolution", "machine", "version", "reference", "advice"][..]),
        (&models[0], &["model", "film", "times", "visible", "verdict"]),
        (&models[0]["points"][0], &["spp", "seconds", "cpu_seconds", "rays_per_second", "bias"]),
    ] {
        assert!(names.iter().all(|name| !of[*name].is_null()), "{names:?} in {of}");
    }

    let svg = String::from_utf8(svg).expect("text");
    let drawing = roxmltree::Document::parse(&svg).expect("XML");
    let labels: Vec<&str> = drawing.descendants().filter_map(|node| node.text()).collect();
    assert!(labels.contains(&"time to render, s"), "{labels:?}");
    assert!(labels.iter().any(|word| word.starts_with("pinhole: ")), "{labels:?}");
    let png = image::load_from_memory(&png).expect("a PNG");
    assert!(png.width() > 1000 && png.height() > 800);
    let page = String::from_utf8(page).expect("text");
    // The answer, then the plot, then all else.
    let body = page.split_once("</h1>\n").expect("a title").1;
    assert!(body.starts_with("<p class=\"answer\">"), "{}", &body[..200]);
    let before = body.split_once("<svg").expect("a plot").0;
    assert!(!before.contains("<h2") && !before.contains("<table"), "{before}");
    let pictures = assert_self_contained(&page);
    assert!(pictures > 16, "{pictures}");
}

/// Asserts that a page is well-formed and loads nothing from elsewhere. Returns its number of pictures.
fn assert_self_contained(page: &str) -> usize {
    let options = roxmltree::ParsingOptions { allow_dtd: true, ..Default::default() };
    let tree = roxmltree::Document::parse_with_options(page, options).expect("XML");
    assert!(!page.contains("http") && !page.contains("url(") && !page.contains("<script"));
    let mut pictures = 0;
    for node in tree.descendants() {
        assert!(!["script", "link", "iframe", "object"].contains(&node.tag_name().name()));
        for attribute in node.attributes() {
            let name = attribute.name();
            assert!(!["href", "srcset"].contains(&name), "{name}");
            if name == "src" {
                assert!(attribute.value().starts_with("data:image/"), "{}", attribute.value());
                pictures += 1;
            }
        }
    }
    pictures
}

fn is_complete(at: &Path) -> bool {
    FILES.iter().all(|name| at.join(name).is_file())
}

#[test]
fn the_report_is_finished_within_its_budget() {
    let folder = folder();
    let scene = root().join("scenes/dgauss.pbrt");
    let scene = scene.to_str().expect("a path");
    // On a busy machine the shortest budgets may be over before every model has a picture.
    let report = ["3s", "9s", "27s", "81s"].into_iter().find_map(|budget| {
        let options = ["--resolution", "64x64", "--budget", budget, "-o", "a/b"];
        let arguments = [&["accuracy", scene], &options[..]].concat();
        let (code, stdout, stderr) = promptly("a report", || petzval(folder.path(), &arguments));
        assert!(code == 0 || stderr.contains("the budget of"), "{stderr}");
        let whole = code == 0 && !stderr.contains("partial") && !stdout.starts_with("model");
        whole.then_some((options.join(" "), stdout))
    });
    let (options, stdout) = report.expect("a report within its budget");
    assert!(stdout.lines().all(|line| !line.contains("partial")) && stdout.contains("real f64"));
    let (answer, rest) = stdout.split_once("\n\n").expect("an answer before the table");
    // Which model is the fastest depends on what else the machine does.
    let names_one = ["real f32", "real f64", "polynomial"].iter().any(|name| answer.contains(name));
    assert!(!answer.contains('\n') && names_one, "{answer}");
    let table = rest.split("\n\n").next().expect("a table");
    assert!(table.lines().all(|line| line.chars().count() <= 80), "{table}");
    assert!(is_complete(&folder.path().join("a/b")));
    let page = std::fs::read_to_string(folder.path().join("a/b/index.html")).expect("a page");
    assert!(page.contains(&options), "the command");
    let left = std::fs::read_dir(folder.path().join("a/b")).expect("a folder").count();
    assert_eq!(left, FILES.len(), "no temporary files");
}

#[test]
fn too_small_a_budget_is_an_error_without_a_report() {
    let folder = folder();
    let scene = root().join("scenes/dgauss.pbrt");
    let scene = scene.to_str().expect("a path");
    let (code, _, stderr) = petzval(folder.path(), &["accuracy", scene, "--budget", "1ms"]);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("the budget of 0.001 s was over before the first"), "{stderr}");
    assert!(!folder.path().join("report/index.html").exists());
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_a_partial_report() {
    let folder = folder();
    let scene = root().join("scenes/dgauss.pbrt");
    let at = folder.path().join("report");
    std::fs::create_dir(&at).expect("a folder");
    let good = br#"{ "ended": "planned" }"#;
    std::fs::write(at.join("accuracy.json"), good).expect("an earlier report");
    let mut command = Command::new(env!("CARGO_BIN_EXE_petzval"));
    command.arg("accuracy").arg(scene).args(["--resolution", "80x80", "--budget", "100s"]);
    command.current_dir(folder.path()).stdout(Stdio::null()).stderr(Stdio::piped());
    // Interrupted later and later, until there is something to report.
    let stderr = (1..60).find_map(|wait| {
        let child = command.spawn().expect("the command starts");
        std::thread::sleep(Duration::from_millis(500 * wait));
        signal(&child, "INT");
        let (code, stderr) = promptly("the end after Ctrl-C", || finish(child));
        assert_eq!(code, 130, "{stderr}");
        at.join("report.partial").exists().then_some(stderr)
    });
    let stderr = stderr.expect("a partial report");
    assert!(stderr.contains("This report is partial: it was interrupted"), "{stderr}");
    assert_eq!(std::fs::read(at.join("accuracy.json")).expect("JSON"), good);
    let at = at.join("report.partial");
    assert!(is_complete(&at));
    let page = std::fs::read_to_string(at.join("index.html")).expect("a page");
    assert!(page.contains("This report is partial: it was interrupted"));
    assert_self_contained(&page);
    let json = std::fs::read(at.join("accuracy.json")).expect("JSON");
    let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
    assert_eq!(json["ended"], "interrupted");
}

#[test]
fn invalid_arguments_are_refused_before_anything_is_rendered() {
    let folder = folder();
    let at = folder.path();
    let lens = root().join("scenes/dgauss.pbrt");
    let lens = lens.to_str().expect("a path");
    write(&folder, "file", "in the way");
    write(&folder, "pinhole.pbrt", "Camera \"perspective\"\nWorldBegin\nShape \"sphere\"");
    for (arguments, expected) in [
        (&["pinhole.pbrt"][..], "pinhole.pbrt:1:1: this camera has no lens file"),
        (&[lens, "-o", "file"], "cannot write to the folder file"),
        (&[lens, "--budget", "0"], "expected a time above 0"),
        (&[lens, "--budget", "1e9s"], "expected a time of a week at most"),
        (&[lens, "--spp", "3"], "--spp 3: every model takes four quarters"),
        (&[lens, "--bugdet", "1s"], "unexpected argument '--bugdet'"),
        (&[lens, "--crop", "9,9,9,9"], "leaves nothing of a picture"),
        (&[lens, "--resolution", "2000x2000"], "--resolution or --crop"),
        (&["none.pbrt"], "none.pbrt"),
    ] {
        let (code, stdout, stderr) = petzval(at, &[&["accuracy"], arguments].concat());
        assert!(
            code == 2 && stdout.is_empty() && stderr.contains(expected),
            "{expected}: {stderr}"
        );
    }
    assert!(!at.join("report/index.html").exists());
}
