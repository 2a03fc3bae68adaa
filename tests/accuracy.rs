//! `petzval accuracy`: the ladder, its report, and how it ends.

mod support;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use petzval::accuracy::{Budget, Climb, Ended, FILES, Ladder, Machine, Report, Watch, climb};
use petzval::job::Changes;
use petzval::scene::pbrt;
use support::{folder, petzval, root, write};

/// The double Gauss, small.
fn ladder(changes: Changes) -> Ladder {
    let description = pbrt::read(&root().join("scenes/dgauss.pbrt")).expect("a scene");
    Ladder::new(&description, &changes, &Watch::default()).expect("a ladder")
}

fn small() -> Changes {
    Changes { resolution: Some([48, 48]), ..Changes::default() }
}

/// A climb to so many samples a pixel, and nothing else to end it.
fn climbed(ladder: &mut Ladder, samples: u32) -> Climb {
    let budget = Budget { begun: Instant::now(), time: Duration::from_secs(600), samples };
    climb(ladder, &budget, &Watch::default()).expect("threads")
}

#[test]
fn every_model_is_told_from_the_richest_apart_from_noise() {
    let mut ladder = ladder(small());
    let found = climbed(&mut ladder, 64);
    let names: Vec<&str> = ladder.rungs.iter().map(|rung| rung.name.as_str()).collect();
    assert_eq!(names[..5], ["pinhole", "thin", "thick", "paraxial", "polynomial"]);
    assert!(names.contains(&"real f32") && names.last() == Some(&"real f64"), "{names:?}");
    assert_eq!(found.ended, Ended::Planned);
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
            _ => {}
        }
        // What the picture is off is the model's own, its noise, and that of the reference.
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
fn effects_of_the_plan_are_left_out_one_by_one() {
    let effects = "+fresnel,+ghosts".parse().expect("effects");
    let ladder = ladder(Changes { effects, ..small() });
    let names: Vec<&str> = ladder.rungs.iter().skip(5).map(|rung| rung.name.as_str()).collect();
    let expected =
        ["real f32 alone", "real f32 - fresnel", "real f32 - ghosts", "real f32", "real f64"];
    assert_eq!(names, expected);
}

/// The report of a small climb.
fn files() -> [Vec<u8>; 5] {
    let mut ladder = ladder(small());
    let found = climbed(&mut ladder, 8);
    let report = Report {
        scene: "a <b> & \"c\".pbrt".to_owned(),
        command: "petzval accuracy 'a <b>.pbrt' --spp 8".to_owned(),
        ladder: &ladder,
        climb: &found,
        budget: Duration::from_secs(60),
        machine: Machine::this(),
    };
    report.files().expect("a report")
}

#[test]
fn the_report_holds_what_it_promises() {
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
    let words: Vec<&str> = drawing.descendants().filter_map(|node| node.text()).collect();
    assert!(words.contains(&"time to render, s"), "{words:?}");
    assert!(words.iter().any(|word| word.starts_with("pinhole: ")), "{words:?}");
    let png = image::load_from_memory(&png).expect("a PNG");
    assert!(png.width() > 1000 && png.height() > 800);
    self_contained(&String::from_utf8(page).expect("text"));
}

/// A page is well-formed, and asks for nothing from elsewhere.
fn self_contained(page: &str) {
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
    assert!(pictures == 0 || pictures > 16, "{pictures}");
}

fn whole(at: &Path) -> bool {
    FILES.iter().all(|name| at.join(name).is_file())
}

#[test]
fn a_budget_is_kept() {
    let folder = folder();
    let scene = root().join("scenes/dgauss.pbrt");
    let arguments = ["accuracy", scene.to_str().expect("a path"), "--resolution", "64x64"];
    let begun = Instant::now();
    let (code, said, errors) =
        petzval(folder.path(), &[&arguments[..], &["--budget", "3s", "-o", "a/b"]].concat());
    let took = begun.elapsed().as_secs_f64();
    assert_eq!(code, 0, "{errors}");
    assert!(took < 3.0 + 2.0, "{took} s");
    assert!(said.lines().all(|line| !line.contains("partial")) && said.contains("real f64"));
    let table = said.split("\n\n").next().expect("a table");
    assert!(table.lines().all(|line| line.chars().count() <= 80), "{table}");
    assert!(whole(&folder.path().join("a/b")));
    let page = std::fs::read_to_string(folder.path().join("a/b/index.html")).expect("a page");
    assert!(page.contains("--resolution 64x64 --budget 3s -o a/b"), "the command");
    let left = std::fs::read_dir(folder.path().join("a/b")).expect("a folder").count();
    assert_eq!(left, FILES.len(), "no temporary files");
}

#[test]
fn too_small_a_budget_leaves_what_was_there() {
    let folder = folder();
    let scene = root().join("scenes/dgauss.pbrt");
    let scene = scene.to_str().expect("a path");
    let (code, _, errors) = petzval(folder.path(), &["accuracy", scene, "--budget", "1ms"]);
    assert_eq!(code, 2, "{errors}");
    assert!(errors.contains("the budget of 0.001 s was over before anything"), "{errors}");
    assert!(!folder.path().join("report/index.html").exists());
}

#[cfg(unix)]
#[test]
fn ctrl_c_leaves_a_report_that_says_so() {
    let folder = folder();
    let scene = root().join("scenes/dgauss.pbrt");
    let at = folder.path().join("report");
    std::fs::create_dir(&at).expect("a folder");
    let good = br#"{ "ended": "planned" }"#;
    std::fs::write(at.join("accuracy.json"), good).expect("an earlier report");
    let mut command = Command::new(env!("CARGO_BIN_EXE_petzval"));
    command.arg("accuracy").arg(scene).args(["--resolution", "80x80", "--budget", "100s"]);
    command.current_dir(folder.path()).stdout(Stdio::null()).stderr(Stdio::piped());
    let child = command.spawn().expect("the command starts");
    std::thread::sleep(Duration::from_millis(2500));
    let begun = Instant::now();
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("kill").success());
    let output = child.wait_with_output().expect("an end");
    assert!(begun.elapsed() < Duration::from_secs(5));
    assert_eq!(output.status.code(), Some(130));
    let said = String::from_utf8_lossy(&output.stderr);
    assert!(said.contains("This report is partial: it was interrupted"), "{said}");
    assert_eq!(std::fs::read(at.join("accuracy.json")).expect("JSON"), good);
    let at = at.join("report.partial");
    assert!(whole(&at));
    let page = std::fs::read_to_string(at.join("index.html")).expect("a page");
    assert!(page.contains("This report is partial: it was interrupted"));
    self_contained(&page);
    let json = std::fs::read(at.join("accuracy.json")).expect("JSON");
    let json: serde_json::Value = serde_json::from_slice(&json).expect("JSON");
    assert_eq!(json["ended"], "interrupted");
}

#[test]
fn nonsense_is_refused_before_anything_is_rendered() {
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
        let (code, said, errors) = petzval(at, &[&["accuracy"], arguments].concat());
        assert!(code == 2 && said.is_empty() && errors.contains(expected), "{expected}: {errors}");
    }
    assert!(!at.join("report/index.html").exists());
}
