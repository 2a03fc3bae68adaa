//! Sweeps: many pictures of one scene, each as if it were taken alone.

mod support;

use std::process::Command;
use std::time::Duration;

use support::kept::{Studio, said};

/// Six pictures of 72 x 50 pixels.
const SWEEP: &str = "render scene.pbrt --spp 4 --effects none --sweep fstop=2.8,8 \
                     --sweep focus=3..5:3 -o {lens}_{fstop}_{focus}.exr";
const NAMES: [&str; 6] = [
    "lens_2.8_3.exr",
    "lens_2.8_4.exr",
    "lens_2.8_5.exr",
    "lens_8_3.exr",
    "lens_8_4.exr",
    "lens_8_5.exr",
];

/// The table beside the contact sheet, by rows.
fn table(studio: &Studio, name: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(studio.path(name)).expect("a table");
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

/// When the files of pictures were written.
fn times(studio: &Studio) -> Vec<std::time::SystemTime> {
    let time = |name: &&str| studio.path(name).metadata().expect("a picture").modified();
    NAMES.iter().map(|name| time(name).expect("a time")).collect()
}

#[test]
fn every_picture_is_that_of_a_single_run() {
    let studio = Studio::new();
    studio.done(SWEEP);
    let mut expected: Vec<&str> = NAMES.to_vec();
    expected.extend(["sweep.csv", "sweep.png"]);
    assert_eq!(studio.names(), expected);
    for (name, values) in
        NAMES.iter().zip([[2.8, 3.0], [2.8, 4.0], [2.8, 5.0], [8.0, 3.0], [8.0, 4.0], [8.0, 5.0]])
    {
        let [fstop, focus] = values;
        studio.done(&format!(
            "render scene.pbrt --spp 4 --effects none --fstop {fstop} --focus {focus} -o single.exr"
        ));
        assert_eq!(studio.contents(name), studio.contents("single.exr"), "{name}");
    }
    let table = table(&studio, "sweep.csv");
    assert_eq!(table[0][..6], ["file", "fstop", "focus", "samples", "noise", "seconds"]);
    assert_eq!(table[5][..5], ["lens_8_4.exr", "8", "4", "4", ""]);
    assert_eq!(table.len(), 7);
    // Two rows of three pictures of 360 x 250 with their edges; and it says what it is.
    let decoder = png::Decoder::new(std::io::BufReader::new(
        std::fs::File::open(studio.path("sweep.png")).expect("a sheet"),
    ));
    let reader = decoder.read_info().expect("a PNG");
    let info = reader.info();
    assert!(info.width > 3 * 360 && info.width < 3 * 360 + 250, "{}", info.width);
    assert!(info.height > 2 * 250 && info.height < 2 * 250 + 160, "{}", info.height);
    let text: Vec<String> =
        info.utf8_text.iter().filter_map(|chunk| chunk.get_text().ok()).collect();
    assert!(text.contains(&"Contact sheet: scene.pbrt by fstop and focus".to_owned()), "{text:?}");
}

#[test]
fn what_moves_is_swept_too() {
    let studio = Studio::new();
    let scene = std::fs::read_to_string(studio.path("scene.pbrt")).expect("the scene");
    let moving = r#"
        AttributeBegin
            ActiveTransform EndTime Translate 0.5 0 0 ActiveTransform All
            Translate 0.2 0.2 3.5 Shape "sphere" "float radius" 0.2
        AttributeEnd"#;
    let text =
        scene.replace("Include \"floor.pbrt\"", &format!("{moving}\nInclude \"floor.pbrt\""));
    assert_ne!(text, scene);
    std::fs::write(studio.path("scene.pbrt"), text).expect("the scene");
    let words = "render scene.pbrt --spp 4";
    let shutters = ["open=0,close=1", "open=.5,close=.75", "open=0,close=.1"];
    let effects = ["none", "+motion"];
    studio.done(&format!(
        "{words} --sweep effects={} --sweep shutter={} -o {{effects}}_{{shutter}}.exr",
        effects.join(","),
        shutters.join(";")
    ));
    let mut seen = Vec::new();
    for effects in effects {
        for shutter in shutters {
            studio.done(&format!("{words} --effects {effects} --shutter {shutter} -o single.exr"));
            let picture = studio.contents(&format!("{effects}_{shutter}.exr"));
            assert_eq!(picture, studio.contents("single.exr"), "{effects} {shutter}");
            assert!(!seen.contains(&picture.channels), "{effects} {shutter}: another one");
            seen.push(picture.channels);
        }
    }
}

#[test]
fn a_lens_is_an_input_of_its_own_pictures_only() {
    let studio = Studio::new();
    for (name, file) in [("wide.dat", "wide.22mm.dat"), ("long.dat", "telephoto.250mm.dat")] {
        let from = support::root().join("lenses").join(file);
        std::fs::copy(from, studio.path(name)).expect("a lens of the repository");
    }
    let words = "render scene.pbrt --spp 4 --effects none";
    let sweep = format!("{words} --sweep lens=wide.dat,long.dat -o {{lens}}.exr");
    studio.done(&sweep);
    let before = table(&studio, "sweep.csv");
    // Begun alone, gone on with in the sweep: what the other lens is has no part in it.
    let text = std::fs::read_to_string(studio.path("wide.dat")).expect("a lens");
    std::fs::write(studio.path("wide.dat"), format!("{text}\n# another\n")).expect("a lens");
    let said = studio.done(&format!("{sweep} --resume"));
    assert!(said.contains("wide.exr is of other inputs, and taken again"), "{said}");
    assert!(said.contains("2 pictures, 1 of them as they stood"), "{said}");
    let after = table(&studio, "sweep.csv");
    assert_ne!(before[1], after[1]);
    assert_eq!(before[2], after[2]);
}

#[test]
fn a_sweep_that_is_gone_on_with_takes_what_is_missing() {
    let studio = Studio::new();
    studio.done(SWEEP);
    let (before, sheet) =
        (times(&studio), std::fs::read(studio.path("sweep.png")).expect("a sheet"));
    let whole = studio.contents(NAMES[1]);
    // One is gone, one is of something else, one of them is not whole.
    std::fs::remove_file(studio.path(NAMES[1])).expect("a picture");
    studio.done(&format!("render scene.pbrt --spp 5 -o {}", NAMES[3]));
    std::fs::write(studio.path(NAMES[4]), "half").expect("a picture");
    let said = studio.done(&format!("{SWEEP} --resume"));
    assert!(said.contains("6 pictures, 3 of them as they stood"), "{said}");
    let after = times(&studio);
    let same: Vec<bool> = before.iter().zip(&after).map(|(one, other)| one == other).collect();
    assert_eq!(same, [true, false, true, false, false, true]);
    assert_eq!(studio.contents(NAMES[1]), whole);
    assert_eq!(table(&studio, "sweep.csv").len(), 7);
    let pixels = |file: &[u8]| image::load_from_memory(file).expect("a sheet").into_rgb8();
    let now = std::fs::read(studio.path("sweep.png")).expect("a sheet");
    assert_eq!(pixels(&sheet), pixels(&now));
    // Other inputs are never taken for these.
    let said = studio.done(&format!("{SWEEP} --seed 1 --resume"));
    assert!(said.contains("6 pictures, 0 of them as they stood"), "{said}");
    let said = studio.done(SWEEP);
    assert!(said.contains("sweep.csv knows 6 of these pictures"), "{said}");
}

#[test]
fn ctrl_c_ends_the_whole_sweep_and_says_how_to_go_on() {
    let studio = Studio::new();
    let render = "render scene.pbrt --effects none";
    let words = format!(
        "{render} --sweep spp=4,1500 --sweep fstop=2.8,8 -o {{spp}}_{{fstop}}.exr --checkpoint 20ms"
    );
    let child = studio.start(&words);
    while !studio.path("1500_2.8.exr.checkpoint").exists() {
        std::thread::sleep(Duration::from_millis(5));
    }
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("kill").success());
    let (code, said) = said(child.wait_with_output().expect("a child"));
    assert_eq!(code, 130, "{said}");
    assert!(said.contains("2 of 4 pictures are done; see sweep.png"), "{said}");
    let on = said.lines().find(|line| line.starts_with("  petzval render --resume"));
    let on = on.unwrap_or_else(|| panic!("{said}")).replace('\'', "");
    assert_eq!(table(&studio, "sweep.csv").len(), 3, "there is a table of what is done");
    assert!(studio.path("sweep.png").exists() && studio.path("1500_2.8.partial.exr").exists());
    let said = studio.done(on.trim_start().trim_start_matches("petzval "));
    assert!(said.contains("4 pictures, 2 of them as they stood"), "{said}");
    assert!(!said.contains("2 of 4: ") && said.contains("3 of 4: "), "{said}");
    studio.done(&format!("{render} --spp 1500 --fstop 2.8 -o single.exr"));
    assert_eq!(studio.contents("1500_2.8.exr"), studio.contents("single.exr"));
    assert!(!studio.path("1500_2.8.partial.exr").exists());
    // Begun again without --resume, it forgets nothing of what still stands.
    let child = studio.start(&words);
    while !studio.path("1500_2.8.exr.checkpoint").exists() {
        std::thread::sleep(Duration::from_millis(5));
    }
    let kill = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    assert!(kill.expect("kill").success());
    let (code, said) = self::said(child.wait_with_output().expect("a child"));
    assert_eq!(code, 130, "{said}");
    assert!(said.contains("sweep.csv knows 4 of these pictures"), "{said}");
    assert_eq!(table(&studio, "sweep.csv").len(), 5);
}

#[test]
fn a_table_in_another_folder_finds_its_pictures() {
    let studio = Studio::new();
    // Those of the pictures are made.
    std::fs::create_dir(studio.path("sheets")).expect("a folder");
    let sweep = "render scene.pbrt --spp 1 --effects none --sweep seed=1,2 \
                 -o deep/out/{seed}.exr --contact sheets/s.png";
    studio.done(sweep);
    assert_eq!(table(&studio, "sheets/s.csv")[1][0], "../deep/out/1.exr");
    let said = studio.done(&format!("{sweep} --resume"));
    assert!(said.contains("2 pictures, 2 of them as they stood"), "{said}");
}

#[test]
fn no_table_is_lost() {
    let studio = Studio::new();
    let words = "render scene.pbrt --spp 1 --effects none -o {seed}.exr --sweep";
    studio.done(&format!("{words} seed=1,2"));
    studio.done(&format!("{words} seed=2,3,4"));
    let names: Vec<String> =
        table(&studio, "sweep.csv").into_iter().map(|mut row| row.remove(0)).collect();
    assert_eq!(names, ["file", "2.exr", "3.exr", "4.exr", "1.exr"]);
    let said = studio.done(&format!("{words} seed=1,3 --resume"));
    assert!(said.contains("2 pictures, 2 of them as they stood"), "{said}");
    for (text, name) in [("date,marks\n1,2\n", "marks"), ("", "nothing"), ("\u{0}", "zero")] {
        std::fs::write(studio.path(&format!("{name}.csv")), text).expect("a file");
        let sweep = format!("{words} seed=7,8 --contact {name}.png");
        studio.refuses(&sweep, "name another by --contact");
        let left = std::fs::read_to_string(studio.path(&format!("{name}.csv")));
        assert_eq!(left.expect("the file"), text);
    }
    let other = "render scene.pbrt --effects none -o {spp}.exr --sweep spp=1,2";
    studio.refuses(other, "whose first line is file,spp,samples,noise,seconds,content,inputs");
    assert!(!studio.path("7.exr").exists() && table(&studio, "sweep.csv").len() == 5);
}

#[test]
fn what_cannot_be_done_is_refused_before_anything_is_rendered() {
    let studio = Studio::new();
    let render = "render scene.pbrt --spp 4 --effects none";
    for (words, expected) in [
        ("--sweep fstop=8,0.5 -o {fstop}.exr", "fstop 0.5: --fstop 0.5: "),
        ("--sweep focus=auto@0,0;auto@99,0 -o {focus}.exr", "auto@99,0: the picture has 72 x 50"),
        ("--sweep lens=lens.dat,none.dat", "none.dat"),
        ("--sweep fstop=8,4 -o lens.dat/{fstop}.exr", "cannot write lens.dat/8.exr"),
        ("--sweep fstop=8,0.5 -o a/b/{fstop}.exr", "fstop 0.5: --fstop 0.5: "),
        ("--sweep fstop=8,4 -o {fstop}.exr --contact no/a.png", "cannot write no/a.png"),
        (
            "--sweep fstop=8,4 -o {fstop}.exr --contact a.exr",
            "--contact a.exr: expected .png or .jpg",
        ),
        ("--sweep fstop=8,4 -o {fstop}.png --contact 8.png", "8.png is both a picture"),
        ("--sweep fstop=8,4 -o {fstop}.exr --samples 0..2", "--samples with --sweep"),
        ("--sweep fstop=8,4 -o {fstop}.png --aov depth", "only EXR holds layers"),
        ("--sweep fstop", "expected NAME=VALUES"),
        ("--contact a.png -o a.exr", "--sweep"),
    ] {
        studio.refuses(&format!("{render} {words}"), expected);
        assert_eq!(studio.names(), [""; 0], "{words}");
    }
}

#[cfg(unix)]
#[test]
fn a_scene_is_read_once() {
    let studio = Studio::new();
    let floor = std::fs::read_to_string(studio.path("floor.pbrt")).expect("the floor");
    std::fs::remove_file(studio.path("floor.pbrt")).expect("the floor");
    // What comes through a pipe can be read once: a second reader would wait forever.
    let made = Command::new("mkfifo").arg(studio.path("floor.pbrt")).status();
    assert!(made.expect("mkfifo").success());
    let child = studio.start(SWEEP);
    std::fs::write(studio.path("floor.pbrt"), floor).expect("somebody who reads");
    let (code, said) = said(child.wait_with_output().expect("a child"));
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("6 pictures, 0 of them as they stood"), "{said}");
}
