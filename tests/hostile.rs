//! Absurd input: what is said about it is short, names its place, and ends with the exit code for it.

mod support;

use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;

use petzval::image::{Encoding, Picture, Window};
use support::kept::{Studio, said};
use support::{folder, petzval, write};

/// The most characters of input that an error shows in one piece.
const MOST: usize = 80;

/// The longest run of this letter, with blanks between or not.
fn longest_run(text: &str, letter: char) -> usize {
    let others = |c: char| c != letter && c != ' ';
    text.split(others).map(|run| run.trim().chars().count()).max().unwrap_or(0)
}

/// Fails with exit code 2, and shows little of the input, but some.
fn quotes_little(at: &Path, words: &[&str]) {
    let (code, answer, said) = petzval(at, words);
    let start: String = said.chars().take(400).collect();
    assert_eq!(code, 2, "{start}");
    assert!(answer.is_empty() && !said.contains("panicked"), "{start}");
    let longest = longest_run(&said, 'q');
    assert!((10..=MOST).contains(&longest), "{longest} characters of input: {start}");
    assert!(said.contains('…'), "{start}");
}

/// A scene with a camera and this in its world.
fn scene(world: &str) -> String {
    format!("Camera \"perspective\"\nWorldBegin\n{world}\n")
}

#[test]
fn an_error_shows_at_most_80_characters_of_a_scene() {
    let folder = folder();
    let long = "q".repeat(400_000);
    let spaced = "q ".repeat(200_000);
    let path = "q".repeat(6_000);
    for (number, world) in [
        long.clone(),
        format!("\"{long}\""),
        format!("1{long}"),
        format!("Shape \"{long}\""),
        format!("Shape \"{spaced}\""),
        format!("Shape \"sphere\" \"float {long}\" 1"),
        format!("Shape \"sphere\" \"{long} radius\" 1"),
        format!("Shape \"sphere\" \"{spaced}\" 1"),
        format!("Texture \"a\" \"{long}\" \"constant\""),
        format!("Texture \"a\" \"{spaced}\" \"constant\""),
        format!("NamedMaterial \"{spaced}\""),
        format!("Material \"diffuse\" \"texture reflectance\" \"{spaced}\""),
        format!("CoordSysTransform \"{spaced}\""),
        format!("ObjectInstance \"{spaced}\""),
        format!("LightSource \"infinite\" \"spectrum L\" \"{spaced}\""),
        format!("Include \"{path}\""),
        format!("Include \"{}\"", &spaced[..6_000]),
        format!("Shape \"plymesh\" \"string filename\" \"{}\"", &spaced[..6_000]),
        format!("Texture \"a\" \"spectrum\" \"imagemap\" \"string filename\" \"{spaced}.png\""),
        format!("LightSource \"infinite\" \"string filename\" \"{path}.png\""),
        format!("LightSource \"infinite\" \"string filename\" \"{spaced}.{spaced}\""),
    ]
    .into_iter()
    .enumerate()
    {
        let name = format!("{number}.pbrt");
        write(&folder, &name, scene(&world));
        quotes_little(folder.path(), &["render", &name]);
    }
    let lens = format!("Camera \"realistic\" \"string lensfile\" \"{spaced}\"\nWorldBegin\n");
    write(&folder, "lens.pbrt", lens);
    quotes_little(folder.path(), &["render", "lens.pbrt"]);
    let digits = "Shape \"sphere\" \"float radius\" 1".to_owned() + &"0".repeat(400_000);
    write(&folder, "digits.pbrt", scene(&digits));
    let (code, _, said) = petzval(folder.path(), &["render", "digits.pbrt"]);
    assert_eq!(code, 2);
    assert!(longest_run(&said, '0') < MOST, "a number of many digits");
    assert!(said.contains("digits.pbrt:3:31"), "{said}");
}

#[test]
fn an_error_shows_at_most_80_characters_of_other_files_and_of_the_command_line() {
    let folder = folder();
    let long = "q".repeat(100_000);
    let spaced = "q ".repeat(50_000);
    write(&folder, "a.dat", format!("{long} 1 1 1\n"));
    write(&folder, "key.toml", format!("{long} = 1\n"));
    write(&folder, "spaced.toml", format!("\"{spaced}\" = 1\n"));
    write(
        &folder,
        "glass.toml",
        format!("[[surface]]\nradius = 9\ndiameter = 1\nglass = \"{spaced}\"\n"),
    );
    write(&folder, "a.csv", format!("1,2,3,4,5,{spaced}\n1,2,3,4,5,{spaced}\n"));
    write(&folder, "good.dat", "10 1 1.5 1\n-10 1 1 1\n0 0 0 1\n");
    for words in [
        &["lens", "a.dat"][..],
        &["lens", "key.toml"],
        &["lens", "spaced.toml"],
        &["lens", "glass.toml"],
        &["lens", "trace", "good.dat", "--rays", "a.csv"],
    ] {
        quotes_little(folder.path(), words);
    }
    let path = "q".repeat(6_000);
    let spaced = "q ".repeat(3_000);
    for word in [path.as_str(), spaced.trim()] {
        for words in [
            &["render", word][..],
            &[word],
            &["lens", word],
            &["lens", "good.dat", "--draw", word],
            &["lens", "good.dat", "--stop", word],
            &["compare", word, word],
            &["merge", word, "-o", "a.exr"],
            &["render", "a.pbrt", "--fstop", word],
            &["render", "a.pbrt", "--sweep", word],
            &["render", "a.pbrt", "--sensor", word],
        ] {
            quotes_little(folder.path(), words);
        }
    }
}

#[test]
fn a_missing_lens_is_named_with_the_place_where_the_scene_asks_for_it() {
    let studio = Studio::new();
    std::fs::remove_file(studio.path("lens.dat")).expect("the lens");
    let expected = "scene.pbrt:4:24: cannot read the lens lens.dat: No such file";
    for command in ["render", "plan", "accuracy"] {
        studio.refuses(&format!("{command} scene.pbrt"), expected);
    }
    // The command line is no place in a file.
    let expected = "error: cannot read the lens other.dat: No such file";
    studio.refuses("render scene.pbrt --lens other.dat", expected);
}

#[test]
fn no_focal_length_is_infinite_or_no_number() {
    let folder = folder();
    let lens = |radius: &str, diameter: &str| {
        format!("{radius} 1 1.5 {diameter}\n-{radius} 1 1 {diameter}\n0 0 0 {diameter}\n")
    };
    for (radius, diameter) in [("1e-310", "1e-311"), ("5e-324", "5e-324"), ("1e-200", "1e-201")] {
        write(&folder, "a.dat", lens(radius, diameter));
        let (code, _, said) = petzval(folder.path(), &["lens", "a.dat"]);
        assert_eq!(code, 2, "{radius}: {said}");
        assert!(said.contains("a.dat:1: ") && said.contains("expected"), "{said}");
        let text = format!(
            "[[surface]]\nradius = {radius}\ndiameter = {diameter}\nthickness = 1\nindex = 1.5\n\
             [[surface]]\nstop = true\ndiameter = {diameter}\nthickness = 1\n"
        );
        write(&folder, "a.toml", text);
        let (code, _, said) = petzval(folder.path(), &["lens", "a.toml"]);
        assert_eq!(code, 2, "{radius}: {said}");
        assert!(said.contains("a.toml:2:") && said.contains("expected"), "{said}");
    }
    // Two planes, and a lens whose second surface undoes what the first does.
    let afocal = "0 1 0 5\n1e300 1 1.5 5\n1e300 0 1 5\n";
    write(&folder, "plane.dat", afocal);
    let (code, answer, said) = petzval(folder.path(), &["lens", "plane.dat"]);
    assert_eq!(code, 0, "{said}");
    let line = answer.lines().find(|line| line.starts_with("focal length")).expect("the line");
    assert!(line.contains("afocal"), "{line}");
    assert!(!answer.contains("NaN") && !answer.contains("inf "), "{answer}");
    assert!(answer.contains("  1.0000e300  "), "{answer}");
    focuses_nothing(folder.path());
}

/// An afocal lens has no place for a film, and the error does not print how far away it would be.
fn focuses_nothing(at: &Path) {
    let (code, answer, said) = petzval(at, &["lens", "plane.dat", "--focus", "1000"]);
    assert_eq!(code, 0, "{said}");
    assert!(answer.contains("it is afocal") && !answer.contains("inf mm"), "{answer}");
    assert!(answer.contains("not known: ") && answer.contains("film distance"), "{answer}");
}

#[test]
fn a_measure_that_is_no_number_does_not_pass() {
    let folder = folder();
    let picture = |name: &str, value: f32| {
        let picture = Picture { size: [16, 16], pixels: vec![[value; 3]; 256] };
        let window = Window { origin: [0; 2], frame: [16; 2] };
        let path = folder.path().join(name);
        picture.write(&path, window, Encoding::default(), &Vec::new()).expect("a picture");
    };
    picture("a.exr", 0.5);
    picture("nan.exr", f32::NAN);
    for (words, expected) in [
        ("compare nan.exr a.exr --fail-above 0.1", "nan.exr"),
        ("compare a.exr nan.exr --fail-above 0.1", "nan.exr"),
        ("compare a.exr a.exr --fail-above nan", "expected a number"),
        ("compare a.exr a.exr --fail-above NaN", "expected a number"),
    ] {
        let words: Vec<&str> = words.split(' ').collect();
        let (code, answer, said) = petzval(folder.path(), &words);
        assert_eq!(code, 2, "{words:?}: {answer}{said}");
        assert!(said.contains(expected), "{words:?}: {said}");
    }
    let words = ["compare", "a.exr", "a.exr", "--metric", "psnr", "--fail-above", "30"];
    let (code, answer, said) = petzval(folder.path(), &words);
    assert_eq!((code, answer.trim_end()), (0, "psnr    inf"), "{said}");
}

#[test]
fn an_empty_shutter_is_refused() {
    let folder = folder();
    write(&folder, "a.pbrt", scene(""));
    for shutter in ["", " ", ","] {
        let (code, _, said) = petzval(folder.path(), &["plan", "a.pbrt", "--shutter", shutter]);
        assert_eq!(code, 2, "{said}");
        assert!(said.contains("expected NAME=VALUE with open, close, time"), "{said}");
    }
}

#[test]
fn a_light_that_overflows_is_refused_where_it_stands() {
    let folder = folder();
    let sphere = "Shape \"sphere\"";
    for (light, shape, name) in [
        ("LightSource \"point\" \"float power\" 1e300", "", "power"),
        ("LightSource \"point\" \"float power\" 3e38 \"rgb scale\" [1e30 1 1]", "", "power"),
        ("LightSource \"spot\" \"float power\" 1e39", "", "power"),
        ("LightSource \"distant\" \"float illuminance\" 1e300", "", "illuminance"),
        ("LightSource \"infinite\" \"float illuminance\" 1e300", "", "illuminance"),
        ("LightSource \"infinite\" \"rgb L\" [1e30 1 1] \"rgb scale\" [1e30 1 1]", "", "scale"),
        ("LightSource \"distant\" \"rgb L\" [1e30 1 1] \"rgb scale\" [1e30 1 1]", "", "scale"),
        ("LightSource \"point\" \"rgb I\" [1e30 1 1] \"rgb scale\" [1e30 1 1]", "", "scale"),
        ("AreaLightSource \"diffuse\" \"float power\" 1e300", sphere, "power"),
        (
            "AreaLightSource \"diffuse\" \"rgb L\" [1e30 1 1] \"rgb scale\" [1e30 1 1]",
            sphere,
            "scale",
        ),
    ] {
        write(&folder, "a.pbrt", scene(&format!("{light}\n{shape}")));
        let (code, _, said) = petzval(folder.path(), &["plan", "a.pbrt"]);
        assert_eq!(code, 2, "{light}: {said}");
        assert!(said.contains("a.pbrt:3:"), "{light}: {said}");
        assert!(said.contains("too large") && said.contains(&format!("\"{name}\"")), "{said}");
    }
}

#[test]
fn a_report_that_is_refused_leaves_no_folder() {
    let studio = Studio::new();
    studio.refuses("accuracy scene.pbrt --resolution 4000x3000 -o a/b", "4000 x 3000 pixels");
    assert!(studio.names().is_empty(), "{:?}", studio.names());
}

#[cfg(target_os = "linux")]
#[test]
fn a_limit_of_file_sizes_ends_as_a_full_disk_does() {
    let studio = Studio::new();
    std::fs::write(studio.path("a.exr"), "precious").expect("a file");
    let program = env!("CARGO_BIN_EXE_petzval");
    let words = "render scene.pbrt -o a.exr --spp 1 --effects none";
    let mut command = Command::new("bash");
    command.args(["-c", &format!("ulimit -f 8; exec '{program}' {words}")]);
    command.current_dir(studio.path("")).stdin(Stdio::null());
    let (code, said) = said(command.output().expect("bash starts"));
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("cannot write the picture a.exr: File too large"), "{said}");
    assert_eq!(std::fs::read(studio.path("a.exr")).expect("a file"), b"precious");
    assert_eq!(studio.names(), ["a.exr"], "nothing is left over");
}

#[cfg(target_os = "linux")]
#[test]
fn what_stops_the_command_while_it_reads_ends_it_with_exit_code_130() {
    let studio = Studio::new();
    assert!(Command::new("mkfifo").arg(studio.path("pipe")).status().expect("mkfifo").success());
    for command in ["render pipe", "plan pipe", "accuracy pipe", "lens pipe"] {
        for signal in ["INT", "TERM"] {
            let child = studio.start(command);
            // Somebody who writes and never ends.
            let writer = std::fs::File::options().write(true).open(studio.path("pipe"));
            std::thread::sleep(Duration::from_millis(50));
            let number = child.id().to_string();
            let sent = Command::new("kill").args(["-s", signal, &number]).status();
            assert!(sent.expect("kill").success());
            let (code, said) = said(child.wait_with_output().expect("a child"));
            drop(writer);
            assert_eq!(code, 130, "{command}, {signal}: {said}");
        }
    }
}
