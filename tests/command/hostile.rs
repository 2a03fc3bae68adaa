//! Absurd input: errors are short, name their position, and end with exit code 2.

use std::path::Path;
use std::process::{Command, Stdio};

use crate::support::workspace::{Workspace, exit_and_stderr, finish, signal};
use crate::support::{folder, petzval, write, write_picture};
use petzval_image::Picture;

/// Maximum number of characters of input that an error shows in one piece.
const MAX_QUOTED: usize = 80;

/// Returns the length of the longest run of this letter; blanks do not end it.
fn longest_run(text: &str, letter: char) -> usize {
    let others = |c: char| c != letter && c != ' ';
    text.split(others).map(|run| run.trim().chars().count()).max().unwrap_or(0)
}

/// Asserts that the command fails with exit code 2 and shows a little of the input.
fn assert_short_error(at: &Path, arguments: &[&str]) {
    let (code, stdout, stderr) = petzval(at, arguments);
    let start: String = stderr.chars().take(400).collect();
    assert_eq!(code, 2, "{start}");
    assert!(stdout.is_empty() && !stderr.contains("panicked"), "{start}");
    let longest = longest_run(&stderr, 'q');
    assert!((10..=MAX_QUOTED).contains(&longest), "{longest} characters of input: {start}");
    assert!(stderr.contains('…'), "{start}");
}

/// Returns a scene with a camera and this world.
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
        assert_short_error(folder.path(), &["render", &name]);
    }
    let lens = format!("Camera \"realistic\" \"string lensfile\" \"{spaced}\"\nWorldBegin\n");
    write(&folder, "lens.pbrt", lens);
    assert_short_error(folder.path(), &["render", "lens.pbrt"]);
    let digits = "Shape \"sphere\" \"float radius\" 1".to_owned() + &"0".repeat(400_000);
    write(&folder, "digits.pbrt", scene(&digits));
    let (code, _, stderr) = petzval(folder.path(), &["render", "digits.pbrt"]);
    assert_eq!(code, 2);
    assert!(longest_run(&stderr, '0') < MAX_QUOTED, "a number of many digits");
    assert!(stderr.contains("digits.pbrt:3:31"), "{stderr}");
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
    for arguments in [
        &["lens", "a.dat"][..],
        &["lens", "key.toml"],
        &["lens", "spaced.toml"],
        &["lens", "glass.toml"],
        &["lens", "trace", "good.dat", "--rays", "a.csv"],
    ] {
        assert_short_error(folder.path(), arguments);
    }
    let path = "q".repeat(6_000);
    let spaced = "q ".repeat(3_000);
    for word in [path.as_str(), spaced.trim()] {
        for arguments in [
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
            assert_short_error(folder.path(), arguments);
        }
    }
}

#[test]
fn a_missing_lens_is_named_with_its_position_in_the_scene() {
    let workspace = Workspace::new();
    std::fs::remove_file(workspace.path("lens.dat")).expect("the lens");
    let expected = "scene.pbrt:3:24: cannot read the lens lens.dat: No such file";
    for command in ["render", "plan", "accuracy"] {
        workspace.refuses(&format!("{command} scene.pbrt"), expected);
    }
    // A lens of the command line has no position in a file.
    let expected = "error: cannot read the lens other.dat: No such file";
    workspace.refuses("render scene.pbrt --lens other.dat", expected);
}

#[test]
fn focal_lengths_are_finite_or_reported_as_afocal() {
    let folder = folder();
    let lens = |radius: &str, diameter: &str| {
        format!("{radius} 1 1.5 {diameter}\n-{radius} 1 1 {diameter}\n0 0 0 {diameter}\n")
    };
    for (radius, diameter) in [("1e-310", "1e-311"), ("5e-324", "5e-324"), ("1e-200", "1e-201")] {
        write(&folder, "a.dat", lens(radius, diameter));
        let (code, _, stderr) = petzval(folder.path(), &["lens", "a.dat"]);
        assert_eq!(code, 2, "{radius}: {stderr}");
        assert!(stderr.contains("a.dat:1: ") && stderr.contains("expected"), "{stderr}");
        let text = format!(
            "[[surface]]\nradius = {radius}\ndiameter = {diameter}\nthickness = 1\nindex = 1.5\n\
             [[surface]]\nstop = true\ndiameter = {diameter}\nthickness = 1\n"
        );
        write(&folder, "a.toml", text);
        let (code, _, stderr) = petzval(folder.path(), &["lens", "a.toml"]);
        assert_eq!(code, 2, "{radius}: {stderr}");
        assert!(stderr.contains("a.toml:2:") && stderr.contains("expected"), "{stderr}");
    }
    // Planes, and surfaces that are so flat that their power is 0.
    let afocal = "0 1 0 5\n1e300 1 1.5 5\n1e300 0 1 5\n";
    write(&folder, "plane.dat", afocal);
    let (code, stdout, stderr) = petzval(folder.path(), &["lens", "plane.dat"]);
    assert_eq!(code, 0, "{stderr}");
    let line = stdout.lines().find(|line| line.starts_with("focal length")).expect("the line");
    assert!(line.contains("afocal"), "{line}");
    assert!(!stdout.contains("NaN") && !stdout.contains("inf "), "{stdout}");
    assert!(stdout.contains("  1.0000e300  "), "{stdout}");
    assert_no_film_distance(folder.path());
}

/// Asserts that the report of an afocal lens has no film distance, not even an infinite one.
fn assert_no_film_distance(at: &Path) {
    let (code, stdout, stderr) = petzval(at, &["lens", "plane.dat", "--focus", "1m"]);
    assert_eq!(code, 0, "{stderr}");
    assert!(stdout.contains("it is afocal") && !stdout.contains("inf mm"), "{stdout}");
    assert!(stdout.contains("not known: ") && stdout.contains("film distance"), "{stdout}");
}

#[test]
fn a_metric_of_nan_fails_the_comparison() {
    let folder = folder();
    let picture = |name: &str, value: f32| {
        let picture = Picture { size: [16, 16], pixels: vec![[value; 3]; 256] };
        write_picture(&picture, folder.path().join(name));
    };
    picture("a.exr", 0.5);
    picture("nan.exr", f32::NAN);
    for (arguments, expected) in [
        ("compare nan.exr a.exr --fail-above 0.1", "nan.exr"),
        ("compare a.exr nan.exr --fail-above 0.1", "nan.exr"),
        ("compare a.exr a.exr --fail-above nan", "expected a number"),
        ("compare a.exr a.exr --fail-above NaN", "expected a number"),
    ] {
        let arguments: Vec<&str> = arguments.split(' ').collect();
        let (code, stdout, stderr) = petzval(folder.path(), &arguments);
        assert_eq!(code, 2, "{arguments:?}: {stdout}{stderr}");
        assert!(stderr.contains(expected), "{arguments:?}: {stderr}");
    }
    let arguments = ["compare", "a.exr", "a.exr", "--metric", "psnr", "--fail-above", "30"];
    let (code, stdout, stderr) = petzval(folder.path(), &arguments);
    assert_eq!((code, stdout.trim_end()), (0, "psnr    inf"), "{stderr}");
}

#[test]
fn an_empty_shutter_is_refused() {
    let folder = folder();
    write(&folder, "a.pbrt", scene(""));
    for shutter in ["", " ", ","] {
        let (code, _, stderr) = petzval(folder.path(), &["plan", "a.pbrt", "--shutter", shutter]);
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.contains("expected NAME=VALUE with open, close, time"), "{stderr}");
    }
}

#[test]
fn a_light_that_overflows_is_refused_with_its_position() {
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
        let (code, _, stderr) = petzval(folder.path(), &["plan", "a.pbrt"]);
        assert_eq!(code, 2, "{light}: {stderr}");
        assert!(stderr.contains("a.pbrt:3:"), "{light}: {stderr}");
        assert!(
            stderr.contains("too strong") && stderr.contains(&format!("\"{name}\"")),
            "{stderr}"
        );
    }
}

#[test]
fn a_refused_report_leaves_no_folder() {
    let workspace = Workspace::new();
    workspace.refuses("accuracy scene.pbrt --resolution 4000x3000 -o a/b", "4000 x 3000 pixels");
    assert!(workspace.file_names().is_empty(), "{:?}", workspace.file_names());
}

#[cfg(target_os = "linux")]
#[test]
fn a_limit_of_file_sizes_is_reported_like_a_full_disk() {
    let workspace = Workspace::new();
    std::fs::write(workspace.path("a.exr"), "precious").expect("a file");
    let program = env!("CARGO_BIN_EXE_petzval");
    let arguments = "render scene.pbrt -o a.exr --spp 1 --effects none";
    let mut command = Command::new("bash");
    command.args(["-c", &format!("ulimit -f 8; exec '{program}' {arguments}")]);
    command.current_dir(workspace.path("")).stdin(Stdio::null());
    let (code, stderr) = exit_and_stderr(command.output().expect("bash starts"));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("cannot write the picture a.exr: File too large"), "{stderr}");
    assert_eq!(std::fs::read(workspace.path("a.exr")).expect("a file"), b"precious");
    assert_eq!(workspace.file_names(), ["a.exr"], "nothing is left over");
}

#[cfg(target_os = "linux")]
#[test]
fn a_signal_while_the_command_reads_ends_it_with_exit_code_130() {
    let workspace = Workspace::new();
    assert!(Command::new("mkfifo").arg(workspace.path("pipe")).status().expect("mkfifo").success());
    for command in ["render pipe", "plan pipe", "accuracy pipe", "lens pipe"] {
        for name in ["INT", "TERM"] {
            let child = workspace.start(command);
            // The pipe opens for writing when the command reads it; it never gives the command an end.
            let writer = std::fs::File::options().write(true).open(workspace.path("pipe"));
            signal(&child, name);
            let (code, stderr) = finish(child);
            drop(writer);
            assert_eq!(code, 130, "{command}, {name}: {stderr}");
        }
    }
}

/// Runs the command with so much address space at most (kB), beyond which allocations fail.
#[cfg(target_os = "linux")]
fn confined(folder: &Path, kilobytes: u64, arguments: &str) -> (i32, String) {
    let mut command = Command::new("sh");
    let program = env!("CARGO_BIN_EXE_petzval");
    let script = format!("ulimit -v {kilobytes} && exec '{program}' {arguments}");
    command.args(["-c", &script]).current_dir(folder).stdin(Stdio::null());
    // Arenas of threads take address space, not memory.
    command.env("MALLOC_ARENA_MAX", "1").env("RAYON_NUM_THREADS", "2");
    let output =
        crate::support::promptly(arguments, || command.output().expect("the command starts"));
    exit_and_stderr(output)
}

/// Returns a glTF document of one triangle mesh whose accessors have no data, with instances.
#[cfg(target_os = "linux")]
fn without_data(count: u64, instances: u64) -> String {
    let accessor = |kind: &str, count: u64| {
        format!("{{\"componentType\":5126,\"count\":{count},\"type\":\"{kind}\"}}")
    };
    let accessors = [
        accessor("VEC3", count),
        accessor("VEC2", count),
        accessor("VEC4", count),
        accessor("VEC3", instances),
    ]
    .join(",");
    format!(
        "{{\"asset\":{{\"version\":\"2.0\"}},\"scene\":0,\"scenes\":[{{\"nodes\":[0,1]}}],\
         \"cameras\":[{{\"type\":\"perspective\",\"perspective\":{{\"yfov\":1,\"znear\":0.1}}}}],\
         \"nodes\":[{{\"camera\":0}},{{\"mesh\":0,\"extensions\":{{\"EXT_mesh_gpu_instancing\":\
         {{\"attributes\":{{\"TRANSLATION\":3}}}}}}}}],\"accessors\":[{accessors}],\
         \"meshes\":[{{\"primitives\":[{{\"attributes\":\
         {{\"POSITION\":0,\"NORMAL\":0,\"TEXCOORD_0\":1,\"TANGENT\":2}}}}]}}]}}"
    )
}

#[cfg(target_os = "linux")]
#[test]
fn small_files_that_declare_much_are_refused_before_it_is_allocated() {
    let folder = folder();
    for (count, instances, place) in [
        (3, 5_000_000, "nodes[1]"),
        (3, 30_000_000, "nodes[1]"),
        (3, 1 << 62, "accessors[3]"),
        (12_000_000, 1, "accessors[2]"),
        (1 << 60, 1, "accessors[0]"),
    ] {
        write(&folder, "a.gltf", without_data(count, instances));
        let arguments = "render a.gltf -o a.exr --spp 1 --memory 400MB --resolution 16x16";
        let (code, stderr) = confined(folder.path(), 1_500_000, arguments);
        assert_eq!(code, 2, "{count}, {instances}: {stderr}");
        assert!(stderr.contains("of memory") && stderr.contains(place), "{place}: {stderr}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_texture_of_floats_claims_all_that_it_takes() {
    let folder = folder();
    let size = [2500, 2500];
    let picture = Picture { size, pixels: vec![[0.5; 3]; size[0] * size[1]] };
    write_picture(&picture, folder.path().join("a.exr"));
    drop(picture);
    let world = "Texture \"a\" \"spectrum\" \"imagemap\" \"string filename\" \"a.exr\"\n\
                 Material \"diffuse\" \"texture reflectance\" \"a\"\nShape \"sphere\"";
    write(&folder, "a.pbrt", scene(world));
    // 28 bytes a pixel for a time, and 16 in the end.
    for (memory, code) in [(150, 2), (400, 0)] {
        let arguments =
            format!("render a.pbrt -o b.exr --spp 1 --resolution 16x16 --memory {memory}MB");
        let (found, stderr) = confined(folder.path(), 1_200_000, &arguments);
        assert_eq!(found, code, "{memory} MB: {stderr}");
        assert!(code == 0 || stderr.contains("a.exr") && stderr.contains("of memory"), "{stderr}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn rays_without_an_end_are_refused() {
    let folder = folder();
    write(&folder, "a.dat", "10 1 1.5 1\n-10 1 1 1\n0 0 0 1\n");
    let (code, stderr) = confined(folder.path(), 1_000_000, "lens trace a.dat --rays /dev/zero");
    assert!(code == 2 && stderr.contains("it is a device"), "{code}: {stderr}");
    let program = env!("CARGO_BIN_EXE_petzval");
    let script = format!("yes 0,0,9,0,0,-1 | '{program}' lens trace a.dat --rays /dev/stdin");
    let mut command = Command::new("sh");
    command.args(["-c", &script]).current_dir(folder.path());
    let output = crate::support::promptly("endless rays", || command.output().expect("a shell"));
    let (code, stderr) = exit_and_stderr(output);
    assert!(code == 2 && stderr.contains("it does not end"), "{code}: {stderr}");
}
