//! Charts of a star, of steps of grey and of white, rendered and measured; depth of field; corrections of lenses.

use std::path::Path;

use petzval_base::sinc::sinc;
use serde_json::Value;

use crate::support::{LANDSCAPE, folder, petzval, root};

/// Draws a chart for a double Gauss, and returns the region that it prints.
fn draw(at: &Path, kind: &str, camera: &str) -> String {
    let lens = root().join("lenses/dgauss.50mm.dat");
    let command = format!("{camera} --focus 2m -o {kind}.pbrt");
    let words = ["chart", kind, lens.to_str().expect("UTF-8")];
    let words: Vec<&str> = words.into_iter().chain(command.split(' ')).collect();
    let (code, stdout, stderr) = petzval(at, &words);
    assert_eq!(code, 0, "{stderr}");
    let line = stdout.lines().last().expect("a command");
    line.split(' ').nth(5).unwrap_or_default().to_owned()
}

fn run(at: &Path, command: &str) -> String {
    let words: Vec<&str> = command.split(' ').collect();
    let (code, stdout, stderr) = petzval(at, &words);
    assert_eq!(code, 0, "{command}: {stderr}");
    stdout
}

fn json(at: &Path, command: &str) -> Value {
    serde_json::from_str(&run(at, &format!("{command} --json"))).expect("JSON")
}

fn numbers(found: &Value) -> Vec<f64> {
    found.as_array().expect("numbers").iter().map(|n| n.as_f64().expect("a number")).collect()
}

#[test]
fn a_star_has_the_response_of_an_edge() {
    let folder = folder();
    let at = folder.path();
    // Pixels of 10 um and a lens wide open.
    let region = draw(at, "star", "--film-size 3.6x2.4 --resolution 360x240 --fstop 2");
    draw(at, "edges", "--film-size 6x4 --resolution 600x400 --fstop 2");
    run(at, "render star.pbrt -q -o star.exr --spp 1024 --effects none");
    run(at, "render edges.pbrt -q -o edges.exr --spp 4096 --effects none --crop 230,150,340,240");
    let star = json(at, &format!("measure star star.exr --region {region} --csv star.csv"));
    // The left edge of the square in the middle, whose region begins at 258,181 of the whole picture.
    let edge = json(at, "measure edges.exr --edge 28,31,56,64");
    let edge = numbers(&edge["edges"][0]["response"]);
    let frequencies = numbers(&star["cycles_per_pixel"]);
    assert_eq!(frequencies.last(), Some(&0.5));
    let mut blurred = 1.0_f64;
    for (frequency, response) in frequencies.iter().zip(numbers(&star["response"])) {
        // An edge shows the response of pixels along their rows, a star that in all directions.
        let angles = (0..90).map(|degrees| f64::from(degrees).to_radians().sin_cos());
        let pixel =
            angles.map(|(s, c)| sinc(frequency * s) * sinc(frequency * c)).sum::<f64>() / 90.0;
        let lens = edge[(100.0 * frequency).round() as usize] / sinc(*frequency);
        let off = response - lens * pixel;
        assert!(off.abs() < 0.01, "{frequency}: {response}, not {}", lens * pixel);
        blurred = blurred.min(lens);
    }
    assert!(blurred < 0.8, "the lens blurs: {blurred}");
    let table = std::fs::read_to_string(at.join("star.csv")).expect("a table");
    assert_eq!(table.lines().count(), frequencies.len() + 1);
    assert_eq!(table.lines().next().expect("names").split(',').count(), 10);
    // Half of the modulation is twice the response.
    let half = json(at, &format!("measure star star.exr --region {region} --modulation 0.3"));
    let ratio = numbers(&half["response"])[5] / numbers(&star["response"])[5];
    assert!((ratio - 2.0).abs() < 1e-6, "{ratio}");
    for (more, expected) in [
        ("--region 72,12,288,228 --cycles 144", "of a star of 144 cycles"),
        ("--region 0,0,700,400", "360 x 240 pixels; expected"),
        ("--region 0,0,40,40", "40 x 40 pixels; expected at least 64 x 64"),
        ("--region 72,12,288,228 --modulation 2", "expected a modulation from 0.01 to 1"),
        ("--region 72,12,288,228 --cycles 3", "8..=720"),
        ("--region 72,12,288,228 --svg star.exr", "--svg"),
    ] {
        let command = format!("measure star star.exr {more}");
        let (code, _, stderr) = petzval(at, &command.split(' ').collect::<Vec<_>>());
        assert!(code == 2 && stderr.contains(expected), "{command}: {stderr}");
    }
}

#[test]
fn steps_of_grey_show_tone_and_dynamic_range() {
    let folder = folder();
    let at = folder.path();
    let camera = "--film-size 36x24 --resolution 480x320 --fstop 8";
    let region = draw(at, "greys", camera);
    draw(at, "flat", camera);
    run(at, "render flat.pbrt -q -o flat.exr --spp 64");
    run(at, "render greys.pbrt -q -o greys.exr --spp 64");
    let measure = format!("measure greys greys.exr --region {region}");
    let found = json(at, &format!("{measure} --flat flat.exr --csv greys.csv"));
    let steps = found["steps"].as_array().expect("steps");
    assert_eq!(steps.len(), 20);
    for step in steps {
        let deviation = step["deviation_stops"].as_f64().expect("a number");
        assert!(deviation.abs() < 0.01, "{step}");
    }
    // The light of the picture, by its white of 0.9 in the middle and less around it.
    let exposure = found["exposure"].as_f64().expect("a number");
    assert!((0.8..0.9).contains(&exposure), "{exposure}");
    assert!(found["dynamic_range_stops"].is_null(), "no sensor");
    assert_eq!(std::fs::read_to_string(at.join("greys.csv")).expect("a table").lines().count(), 21);

    // White is 1,500 electrons. The luminance of three channels has 0.562 of the variance of one.
    run(at, "render greys.pbrt -q -o raw.exr --spp 256 --sensor iso=1600,pixel=4,read=2.5");
    let found = json(at, &format!("measure greys raw.exr --region {region}"));
    let electrons = (0.562 + (0.562_f64.powi(2) + 4.0 * 0.562 * 6.25).sqrt()) / 2.0;
    let range = found["dynamic_range_stops"].as_f64().expect("stops");
    let expected = (1500.0 / electrons).log2();
    assert!((range - expected).abs() < 0.2, "{range}, not {expected}");
    let found = json(at, &format!("measure greys raw.exr --region {region} --flat flat.exr"));
    let flat = found["dynamic_range_stops"].as_f64().expect("stops");
    assert!((flat - expected).abs() < 0.2, "{flat}, not {expected}");

    // A page and a plot of the same numbers.
    let text = run(at, &format!("{measure} --html greys.html --svg greys.svg"));
    assert!(text.contains("dynamic range beyond the darkest step"), "{text}");
    let page = std::fs::read_to_string(at.join("greys.html")).expect("a page");
    assert!(page.contains("Tone and noise of greys.exr") && page.matches("<svg").count() == 2);
    assert!(page.contains("0.00014") && page.contains("petzval measure greys greys.exr"), "{page}");
    let svg = std::fs::read_to_string(at.join("greys.svg")).expect("a plot");
    assert!(svg.contains("Opto-electronic conversion"), "{svg}");
    let words =
        format!("measure greys greys.exr --region {region} --flat flat.exr --html flat.exr");
    let (code, _, stderr) = petzval(at, &words.split(' ').collect::<Vec<_>>());
    assert!(code == 2 && stderr.contains("--html"), "{stderr}");
    let words = "measure greys flat.exr --region 0,0,480,320";
    let (code, _, stderr) = petzval(at, &words.split(' ').collect::<Vec<_>>());
    assert!(code == 2 && stderr.contains("do not become darker"), "{stderr}");
}

#[test]
fn shading_is_the_relative_illumination_of_the_lens() {
    let folder = folder();
    let at = folder.path();
    draw(at, "flat", "--film-size 36x24 --resolution 240x160 --fstop 8");
    run(at, "render flat.pbrt -q -o flat.exr --spp 256 --effects none");
    let shading = json(at, "measure shading flat.exr --csv zones.csv");
    let corners = numbers(&shading["corners"]);
    let zones = shading["zones"].as_array().expect("zones");
    let field = zones[0]["field"].as_f64().expect("a field");
    let lens = root().join("lenses/dgauss.50mm.dat");
    // Half of the diagonal of the film, by the field of the corner zones.
    let height = field * 36.0_f64.hypot(24.0) / 2.0;
    let report = run(
        at,
        &format!(
            "lens report {} --json=relative-illumination --fstop 8 --focus 2m --image-height {height}",
            lens.display()
        ),
    );
    let report: Value = serde_json::from_str(&report).expect("JSON");
    let rows = report["tables"][0]["rows"].as_array().expect("rows");
    let last = numbers(rows.last().expect("a row"));
    for corner in &corners {
        assert!((corner / last[2] - 1.0).abs() < 0.01, "{corner}, not {last:?}");
    }
    assert!((shading["uniformity"].as_f64().expect("a number") - last[2]).abs() < 0.01);
    assert!(shading["colour_shading"].as_f64().expect("a number") < 1e-3);
    let table = std::fs::read_to_string(at.join("zones.csv")).expect("a table");
    assert_eq!(table.lines().count(), 15 * 11 + 1);
}

#[test]
fn the_depth_of_field_is_that_of_the_first_order_lens() {
    let folder = folder();
    let at = folder.path();
    let lens = root().join("lenses/dgauss.50mm.dat");
    let lens = lens.display();
    let found = json(
        at,
        &format!(
            "lens depth-of-field {lens} --film-size 35mm --fstop 4,8 --focus 0.01,2m,10m,inf --blur 30um --csv d.csv"
        ),
    );
    let rows = found["rows"].as_array().expect("rows");
    for (row, f_number) in rows.iter().zip([4.0, 8.0]) {
        // f^2 / (N c) from the lens, whose principal points are within some cm of the film.
        let expected = 0.05 * 0.05 / (f_number * 30e-6);
        let hyperfocal = row["hyperfocal_m"].as_f64().expect("a distance");
        assert!((hyperfocal / expected - 1.0).abs() < 0.03, "{hyperfocal}, not {expected}");
        let limits = row["limits"].as_array().expect("limits");
        assert_eq!(limits[0]["focuses"], false);
        let ends = ["near_m", "far_m"].map(|end| limits[1][end].as_f64().expect("a distance"));
        // A thin lens 0.05 m before the film: u h / (h + u - f) with its own f^2 / (N c) = h.
        let thin = [1.0, -1.0].map(|sign| 1.95 * expected / (expected + sign * 1.9) + 0.05);
        for (end, expected) in ends.into_iter().zip(thin) {
            assert!((end / expected - 1.0).abs() < 0.01, "{ends:?}, not {thin:?}");
        }
        assert!(limits[3]["far_m"].is_null() && limits[3]["focuses"] == true);
        // Beyond the hyperfocal distance, infinity is sharp.
        assert_eq!(limits[2]["far_m"].is_null(), hyperfocal < 10.0, "{row}");
    }
    assert_eq!(std::fs::read_to_string(at.join("d.csv")).expect("a table").lines().count(), 9);
    let text = run(at, &format!("lens depth-of-field {lens}"));
    assert!(text.contains("36 x 24 mm") && text.contains("28.8 um"), "{text}");
    // Every lens has stops of its own.
    for file in std::fs::read_dir(root().join("lenses")).expect("lenses") {
        let path = file.expect("a file").path();
        let path = path.to_str().expect("UTF-8");
        let (code, stdout, stderr) = petzval(at, &["lens", "depth-of-field", path]);
        assert!(code == 0 && stdout.lines().count() > 3, "{path}: {stdout} {stderr}");
        assert_eq!(stderr.contains("along x"), path.ends_with("anamorphic.toml"), "{stderr}");
    }
    for (more, expected) in [
        ("--film-size 36", "or one of 35mm, half-frame"),
        ("--blur 0", "expected a diameter"),
        ("--fstop 1", "--fstop 1"),
        ("--focus 2000", "2000mm"),
    ] {
        let command = format!("lens depth-of-field {lens} {more}");
        let (code, _, stderr) = petzval(at, &command.split(' ').collect::<Vec<_>>());
        assert!(code == 2 && stderr.contains(expected), "{command}: {stderr}");
    }
}

#[test]
fn opcodes_of_raw_files_correct_the_lens() {
    let folder = folder();
    let at = folder.path();
    let lens = root().join("lenses/wide.22mm.dat");
    let lens = lens.display();
    for kind in ["grid", "flat"] {
        run(
            at,
            &format!(
                "chart {kind} {lens} --film-size 30x20 --resolution 480x320 --focus 2m --fstop 8 -o {kind}.pbrt"
            ),
        );
        for (name, more) in [("as-it-is", ""), ("corrected", " --lens-correction")] {
            let render = format!(
                "render {kind}.pbrt -q -o {kind}.dng --bayer --sensor read=0 --spp 32{more}"
            );
            run(at, &render);
            run(at, &format!("develop {kind}.dng -o {kind}-{name}.exr"));
        }
    }
    let distortion = |name: &str| {
        let found = json(at, &format!("measure grid grid-{name}.exr"));
        found["distortion_percent"].as_f64().expect("a number")
    };
    let [before, after] = ["as-it-is", "corrected"].map(distortion);
    assert!(before < -1.0 && after.abs() < 0.03, "{before} %, then {after} %");
    let uniformity = |name: &str| {
        let found = json(at, &format!("measure shading flat-{name}.exr"));
        found["uniformity"].as_f64().expect("a number")
    };
    let [before, after] = ["as-it-is", "corrected"].map(uniformity);
    assert!(before < 0.6 && after > 0.99, "{before}, then {after}");
    // Each channel has a warp of its own: blue of a landscape lens lies 0.6 pixels inwards.
    std::fs::write(at.join("landscape.toml"), LANDSCAPE).expect("a lens");
    run(
        at,
        "chart grid landscape.toml --film-size 24x16 --resolution 480x320 --focus 2m --fstop 8 -o colour.pbrt",
    );
    let blue = ["", " --lens-correction"].map(|more| {
        let render = "render colour.pbrt -q -o colour.dng --bayer --sensor read=0 --spp 128 --effects +dispersion";
        run(at, &format!("{render}{more}"));
        run(at, "develop colour.dng -o colour.exr");
        let found = json(at, "measure grid colour.exr");
        let dots = found["dots"].as_array().expect("dots");
        let outer: Vec<f64> = dots
            .iter()
            .filter(|dot| dot["radius"].as_f64().expect("a number") > 180.0)
            .map(|dot| numbers(&dot["lateral_colour"])[1])
            .collect();
        outer.iter().sum::<f64>() / outer.len() as f64
    });
    assert!(blue[0] < -0.45 && blue[1].abs() < 0.15, "{blue:?}");
    // Opcodes cannot describe these pictures.
    let fisheye = root().join("scenes/fisheye.pbrt").display().to_string();
    for (command, expected) in [
        ("render flat.pbrt -o a.exr --lens-correction".to_owned(), "a.exr: only DNG holds opcodes"),
        (
            format!("render {fisheye} -o a.dng --bayer --lens-correction"),
            "the field is too wide for a rectilinear picture",
        ),
        (
            "render flat.pbrt -o a.dng --bayer --lens-correction --crop 0,0,60,40".to_owned(),
            "the crop does not hold the middle",
        ),
    ] {
        let (code, _, stderr) = petzval(at, &command.split(' ').collect::<Vec<_>>());
        assert!(code == 2 && stderr.contains(expected), "{command}: {stderr}");
    }
}

#[test]
fn development_undoes_crosstalk_of_even_surfaces() {
    let folder = folder();
    let at = folder.path();
    let region = draw(at, "colours", "--film-size 36x24 --resolution 240x160 --fstop 8");
    let measured = [0, 20].map(|percent| {
        let sensor = format!("read=0,crosstalk={percent}/{}/{}", percent / 2, percent / 4);
        run(at, &format!("render colours.pbrt -q -o a.dng --bayer --sensor {sensor} --spp 64"));
        run(at, "develop a.dng -o a.exr");
        json(at, &format!("measure colours a.exr --region {region}"))
    });
    let number = |found: &Value, name: &str| found[name].as_f64().expect("a number");
    let [plain, leaky] = measured.each_ref().map(|found| number(found, "brightness"));
    assert!((leaky / plain - 1.0).abs() < 0.005, "{leaky}, not {plain}");
    let [plain, leaky] = measured.each_ref().map(|found| number(found, "mean_de2000"));
    assert!((leaky - plain).abs() < 0.2, "dE2000 {leaky}, not {plain}");
}
