//! The command `measure`.

use petzval_image::{BitDepth, EncodingOptions, Picture, PictureWindow};

use crate::support::{folder, petzval};

/// Writes an edge through the middle of a picture, sharp but for its pixels, in this slope (pixels a row).
fn write_edge(folder: &std::path::Path, name: &str, slope: f64) {
    let size = [120_usize, 90];
    let share = |x: usize, y: usize| {
        let inside = (0..256).filter(|i| {
            let at = [x as f64 + f64::from(i % 16) / 16.0, y as f64 + f64::from(i / 16) / 16.0];
            at[0] + 1.0 / 32.0 > 60.0 + slope * (at[1] + 1.0 / 32.0 - 45.0)
        });
        inside.count() as f32 / 256.0
    };
    let pixel = |i: usize| {
        let share = share(i % size[0], i / size[0]);
        // Red has no edge.
        [0.5, 0.1 + 0.7 * share, 0.1 + 0.3 * share]
    };
    let picture = Picture { size, pixels: (0..size[0] * size[1]).map(pixel).collect() };
    let window = PictureWindow { origin: [0, 0], frame: size.map(|n| n as u32) };
    let bit_depth = name.ends_with("png").then_some(BitDepth::Sixteen);
    let encoding = EncodingOptions { bit_depth, ..EncodingOptions::default() };
    let file = petzval_base::io::OutputFile::new(folder.join(name), &Default::default());
    picture.write(&file.expect("a name"), window, encoding, &Vec::new()).expect("a file");
}

#[test]
fn sharp_edges_have_the_response_of_their_pixels() {
    let folder = folder();
    let at = folder.path();
    for name in ["a.exr", "a.png", "a.tif"] {
        write_edge(at, name, 0.1);
        let region = ["--edge", "20,5,100,85", "--edge", "25,0,95,90"];
        let more = ["--json", "--channel", "green", "--csv", "sfr.csv"];
        let (code, stdout, stderr) =
            petzval(at, &[&["measure", name], &region[..], &more].concat());
        assert_eq!(code, 0, "{stderr}");
        let found: serde_json::Value = serde_json::from_str(&stdout).expect("JSON");
        for edge in found["edges"].as_array().expect("edges") {
            assert_eq!(edge["axis"], "x");
            let number = |name: &str| edge[name].as_f64().expect("a number");
            // Half of sin(pi f) / (pi f).
            assert!((number("mtf50") - 0.6034).abs() < 0.02, "{name}: {edge}");
            assert!((number("slant_degrees").abs() - 5.71).abs() < 0.05, "{name}: {edge}");
            assert!((number("contrast") - 0.7 / 0.9).abs() < 1e-3, "{name}: {edge}");
            let response = edge["response"][25].as_f64().expect("a number");
            assert!((response - 0.9003).abs() < 0.006, "{name}: {response}");
        }
        let table = std::fs::read_to_string(at.join("sfr.csv")).expect("a table");
        let lines: Vec<&str> = table.lines().collect();
        assert_eq!((lines[0], lines.len()), ("cycles/pixel,edge 1,edge 2", 102));
        assert!(lines[1].starts_with("0.00,1.0000,1.0000"), "{}", lines[1]);
    }
    let (code, stdout, _) =
        petzval(at, &["measure", "a.exr", "--edge", "20,5,100,85", "--pixel", "5um"]);
    assert_eq!(code, 0);
    assert!(
        stdout.contains("frequencies along x, slant 5.7") && stdout.contains(" cycles/mm)"),
        "{stdout}"
    );
    assert!(stdout.lines().any(|line| line.starts_with("0.50")), "{stdout}");
}

#[test]
fn what_cannot_be_measured_ends_with_exit_code_2_and_advice() {
    let folder = folder();
    let at = folder.path();
    write_edge(at, "a.exr", 0.1);
    write_edge(at, "straight.exr", 0.0);
    for (arguments, expected) in [
        ("a.exr", "--edge"),
        ("a.exr --edge 20,5,100", "four whole numbers"),
        ("a.exr --edge 20,5,121,85", "has 120 x 90 pixels; expected X0,Y0,X1,Y1 within it"),
        ("a.exr --edge 20,5,20,85", "expected X0,Y0,X1,Y1 within it"),
        ("a.exr --edge 20,5,30,85", "expected at least 20 x 20"),
        ("a.exr --edge 0,5,40,85", "has no edge"),
        ("a.exr --edge 20,5,100,85 --channel red", "has no edge"),
        ("a.exr --edge 20,5,100,85 --pixel 0", "expected a pitch"),
        ("a.exr --edge 20,5,100,85 --csv a.exr", "a.exr"),
        ("a.exr --edge 20,5,66,85", "choose a wider region"),
        ("straight.exr --edge 20,5,100,85", "slant the chart"),
        ("none.exr --edge 20,5,100,85", "none.exr"),
    ] {
        let words: Vec<&str> = ["measure"].into_iter().chain(arguments.split(' ')).collect();
        let (code, _, stderr) = petzval(at, &words);
        assert_eq!(code, 2, "{arguments}: {stderr}");
        assert!(stderr.contains(expected), "{arguments}: {stderr}");
    }
}
