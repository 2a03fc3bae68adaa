//! Sweeps: many pictures of one scene, each equal to a single render.

use std::process::Command;

use crate::support::workspace::{Workspace, finish, signal};

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

/// Reads the rows of the table beside the contact sheet.
fn table(workspace: &Workspace, name: &str) -> Vec<Vec<String>> {
    let text = std::fs::read_to_string(workspace.path(name)).expect("a table");
    text.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect()
}

/// Returns the modification times of the pictures.
fn times(workspace: &Workspace) -> Vec<std::time::SystemTime> {
    let time = |name: &&str| workspace.path(name).metadata().expect("a picture").modified();
    NAMES.iter().map(|name| time(name).expect("a time")).collect()
}

#[test]
fn every_picture_equals_that_of_a_single_run() {
    let workspace = Workspace::new();
    workspace.run_ok(SWEEP);
    let mut expected: Vec<&str> = NAMES.to_vec();
    expected.extend(["sweep.csv", "sweep.png"]);
    assert_eq!(workspace.file_names(), expected);
    for (name, values) in
        NAMES.iter().zip([[2.8, 3.0], [2.8, 4.0], [2.8, 5.0], [8.0, 3.0], [8.0, 4.0], [8.0, 5.0]])
    {
        let [fstop, focus] = values;
        workspace.run_ok(&format!(
            "render scene.pbrt --spp 4 --effects none --fstop {fstop} --focus {focus} -o single.exr"
        ));
        assert_eq!(workspace.contents(name), workspace.contents("single.exr"), "{name}");
    }
    let table = table(&workspace, "sweep.csv");
    assert_eq!(table[0][..6], ["file", "fstop", "focus", "samples", "noise", "seconds"]);
    assert_eq!(table[5][..5], ["lens_8_4.exr", "8", "4", "4", ""]);
    assert_eq!(table.len(), 7);
    // Two rows of three pictures of 360 x 250 pixels with margins, and a title in the metadata.
    let decoder = png::Decoder::new(std::io::BufReader::new(
        std::fs::File::open(workspace.path("sweep.png")).expect("a sheet"),
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
fn shutters_and_effects_can_be_swept() {
    let workspace = Workspace::new();
    let scene = std::fs::read_to_string(workspace.path("scene.pbrt")).expect("the scene");
    let moving = r#"
        AttributeBegin
            ActiveTransform EndTime Translate 0.5 0 0 ActiveTransform All
            Translate 0.2 0.2 3.5 Shape "sphere" "float radius" 0.2
        AttributeEnd"#;
    let text =
        scene.replace("Include \"floor.pbrt\"", &format!("{moving}\nInclude \"floor.pbrt\""));
    assert_ne!(text, scene);
    std::fs::write(workspace.path("scene.pbrt"), text).expect("the scene");
    let arguments = "render scene.pbrt --spp 4";
    let shutters = ["open=0,close=1", "open=.5,close=.75", "open=0,close=.1"];
    let effects = ["none", "+motion"];
    workspace.run_ok(&format!(
        "{arguments} --sweep effects={} --sweep shutter={} -o {{effects}}_{{shutter}}.exr",
        effects.join(","),
        shutters.join(";")
    ));
    let mut seen = Vec::new();
    for effects in effects {
        for shutter in shutters {
            workspace.run_ok(&format!(
                "{arguments} --effects {effects} --shutter {shutter} -o single.exr"
            ));
            let picture = workspace.contents(&format!("{effects}_{shutter}.exr"));
            assert_eq!(picture, workspace.contents("single.exr"), "{effects} {shutter}");
            assert!(
                !seen.contains(&picture.channels),
                "{effects} {shutter} equals another picture"
            );
            seen.push(picture.channels);
        }
    }
}

#[test]
fn a_lens_is_an_input_of_its_own_pictures_only() {
    let workspace = Workspace::new();
    for (name, file) in [("wide.dat", "wide.22mm.dat"), ("long.dat", "telephoto.250mm.dat")] {
        let from = crate::support::root().join("lenses").join(file);
        std::fs::copy(from, workspace.path(name)).expect("a lens of the repository");
    }
    let arguments = "render scene.pbrt --spp 4 --effects none";
    let sweep = format!("{arguments} --sweep lens=wide.dat,long.dat -o {{lens}}.exr");
    workspace.run_ok(&sweep);
    let before = table(&workspace, "sweep.csv");
    // A changed lens makes only its own pictures outdated.
    let text = std::fs::read_to_string(workspace.path("wide.dat")).expect("a lens");
    std::fs::write(workspace.path("wide.dat"), format!("{text}\n# another\n")).expect("a lens");
    let stderr = workspace.run_ok(&format!("{sweep} --resume"));
    assert!(stderr.contains("the inputs of wide.exr have changed; rendering it again"), "{stderr}");
    assert!(stderr.contains("2 pictures, 1 of them unchanged"), "{stderr}");
    let after = table(&workspace, "sweep.csv");
    assert_ne!(before[1], after[1]);
    assert_eq!(before[2], after[2]);
}

#[test]
fn a_resumed_sweep_renders_the_missing_pictures() {
    let workspace = Workspace::new();
    workspace.run_ok(SWEEP);
    let (before, sheet) =
        (times(&workspace), std::fs::read(workspace.path("sweep.png")).expect("a sheet"));
    let whole = workspace.contents(NAMES[1]);
    // One picture is missing, one is of other options, one is damaged.
    std::fs::remove_file(workspace.path(NAMES[1])).expect("a picture");
    workspace.run_ok(&format!("render scene.pbrt --spp 5 -o {}", NAMES[3]));
    std::fs::write(workspace.path(NAMES[4]), "half").expect("a picture");
    let stderr = workspace.run_ok(&format!("{SWEEP} --resume"));
    assert!(stderr.contains("6 pictures, 3 of them unchanged"), "{stderr}");
    let after = times(&workspace);
    let same: Vec<bool> = before.iter().zip(&after).map(|(one, other)| one == other).collect();
    assert_eq!(same, [true, false, true, false, false, true]);
    assert_eq!(workspace.contents(NAMES[1]), whole);
    assert_eq!(table(&workspace, "sweep.csv").len(), 7);
    let pixels = |file: &[u8]| image::load_from_memory(file).expect("a sheet").into_rgb8();
    let now = std::fs::read(workspace.path("sweep.png")).expect("a sheet");
    assert_eq!(pixels(&sheet), pixels(&now));
    // Pictures of other options are not reused.
    let stderr = workspace.run_ok(&format!("{SWEEP} --seed 1 --resume"));
    assert!(stderr.contains("6 pictures, 0 of them unchanged"), "{stderr}");
    let stderr = workspace.run_ok(SWEEP);
    assert!(stderr.contains("sweep.csv lists 6 of these pictures"), "{stderr}");
}

#[test]
fn ctrl_c_ends_the_whole_sweep_and_prints_how_to_resume() {
    let workspace = Workspace::new();
    let render = "render scene.pbrt --effects none";
    let arguments = format!(
        "{render} --sweep spp=4,1500 --sweep fstop=2.8,8 -o {{spp}}_{{fstop}}.exr --checkpoint 20ms"
    );
    let mut child = workspace.start(&arguments);
    workspace.wait_for_file(&mut child, "1500_2.8.exr.checkpoint", 0);
    signal(&child, "INT");
    let (code, stderr) = finish(child);
    assert_eq!(code, 130, "{stderr}");
    assert!(stderr.contains("2 of 4 pictures are done; see sweep.png"), "{stderr}");
    let on = stderr.lines().find(|line| line.starts_with("  petzval render --resume"));
    let on = on.unwrap_or_else(|| panic!("{stderr}")).replace('\'', "");
    assert_eq!(table(&workspace, "sweep.csv").len(), 3, "the table lists the finished pictures");
    assert!(
        workspace.path("sweep.png").exists() && workspace.path("1500_2.8.partial.exr").exists()
    );
    let stderr = workspace.run_ok(on.trim_start().trim_start_matches("petzval "));
    assert!(stderr.contains("4 pictures, 2 of them unchanged"), "{stderr}");
    assert!(!stderr.contains("2 of 4: ") && stderr.contains("3 of 4: "), "{stderr}");
    workspace.run_ok(&format!("{render} --spp 1500 --fstop 2.8 -o single.exr"));
    assert_eq!(workspace.contents("1500_2.8.exr"), workspace.contents("single.exr"));
    assert!(!workspace.path("1500_2.8.partial.exr").exists());
    // Without --resume the table keeps the pictures that still exist.
    let mut child = workspace.start(&arguments);
    workspace.wait_for_file(&mut child, "1500_2.8.exr.checkpoint", 0);
    signal(&child, "INT");
    let (code, stderr) = finish(child);
    assert_eq!(code, 130, "{stderr}");
    assert!(stderr.contains("sweep.csv lists 4 of these pictures"), "{stderr}");
    assert_eq!(table(&workspace, "sweep.csv").len(), 5);
}

#[test]
fn a_table_in_another_folder_finds_its_pictures() {
    let workspace = Workspace::new();
    // The command creates the folders of pictures, but not that of the sheet.
    std::fs::create_dir(workspace.path("sheets")).expect("a folder");
    let sweep = "render scene.pbrt --spp 1 --effects none --sweep seed=1,2 \
                 -o deep/out/{seed}.exr --contact sheets/s.png";
    workspace.run_ok(sweep);
    assert_eq!(table(&workspace, "sheets/s.csv")[1][0], "../deep/out/1.exr");
    let stderr = workspace.run_ok(&format!("{sweep} --resume"));
    assert!(stderr.contains("2 pictures, 2 of them unchanged"), "{stderr}");
}

#[test]
fn no_table_of_an_earlier_sweep_is_lost() {
    let workspace = Workspace::new();
    let arguments = "render scene.pbrt --spp 1 --effects none -o {seed}.exr --sweep";
    workspace.run_ok(&format!("{arguments} seed=1,2"));
    workspace.run_ok(&format!("{arguments} seed=2,3,4"));
    let names: Vec<String> =
        table(&workspace, "sweep.csv").into_iter().map(|mut row| row.remove(0)).collect();
    assert_eq!(names, ["file", "2.exr", "3.exr", "4.exr", "1.exr"]);
    let stderr = workspace.run_ok(&format!("{arguments} seed=1,3 --resume"));
    assert!(stderr.contains("2 pictures, 2 of them unchanged"), "{stderr}");
    for (text, name) in [("date,marks\n1,2\n", "marks"), ("", "nothing"), ("\u{0}", "zero")] {
        std::fs::write(workspace.path(&format!("{name}.csv")), text).expect("a file");
        let sweep = format!("{arguments} seed=7,8 --contact {name}.png");
        workspace.refuses(&sweep, "name another with --contact");
        let left = std::fs::read_to_string(workspace.path(&format!("{name}.csv")));
        assert_eq!(left.expect("the file"), text);
    }
    let other = "render scene.pbrt --effects none -o {spp}.exr --sweep spp=1,2";
    workspace.refuses(other, "whose first line is file,spp,samples,noise,seconds,content,inputs");
    assert!(!workspace.path("7.exr").exists() && table(&workspace, "sweep.csv").len() == 5);
}

#[test]
fn impossible_sweeps_are_refused_before_anything_is_rendered() {
    let workspace = Workspace::new();
    let render = "render scene.pbrt --spp 4 --effects none";
    for (arguments, expected) in [
        ("--sweep fstop=8,0.5 -o {fstop}.exr", "fstop 0.5: --fstop 0.5: "),
        (
            "--sweep focus=auto@0,0;auto@99,0 -o {focus}.exr",
            "--focus on the pixel 99,0: the picture has 72 x 50",
        ),
        ("--sweep lens=lens.dat,none.dat", "none.dat"),
        ("--sweep fstop=8,4 -o lens.dat/{fstop}.exr", "cannot write lens.dat/8.exr"),
        ("--sweep fstop=8,0.5 -o a/b/{fstop}.exr", "fstop 0.5: --fstop 0.5: "),
        ("--sweep fstop=8,4 -o {fstop}.exr --contact no/a.png", "cannot write no/a.png"),
        (
            "--sweep fstop=8,4 -o {fstop}.exr --contact a.exr",
            "--contact a.exr: expected .png, .jpg or .tif",
        ),
        (
            "--sweep fstop=8,4 -o {fstop}.png --contact 8.png",
            "8.png: it is the same file as 8.png, another output",
        ),
        ("--sweep fstop=8,4 -o {fstop}.exr --samples 0..2", "--samples with --sweep"),
        ("--sweep fstop=8,4 -o {fstop}.png --aov depth", "only EXR holds layers"),
        ("--sweep fstop", "expected NAME=VALUES"),
        ("--contact a.png -o a.exr", "--sweep"),
    ] {
        workspace.refuses(&format!("{render} {arguments}"), expected);
        assert_eq!(workspace.file_names(), [""; 0], "{arguments}");
    }
}

#[cfg(unix)]
#[test]
fn a_scene_is_read_once() {
    let workspace = Workspace::new();
    let floor = std::fs::read_to_string(workspace.path("floor.pbrt")).expect("the floor");
    std::fs::remove_file(workspace.path("floor.pbrt")).expect("the floor");
    // A pipe can be read once: a second read would wait forever.
    let made = Command::new("mkfifo").arg(workspace.path("floor.pbrt")).status();
    assert!(made.expect("mkfifo").success());
    let child = workspace.start(SWEEP);
    std::fs::write(workspace.path("floor.pbrt"), floor).expect("a reader");
    let (code, stderr) = finish(child);
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("6 pictures, 0 of them unchanged"), "{stderr}");
}
