//! Denoising by a program: the command with programs that copy, fail, hang or write nonsense.
#![cfg(unix)]

use std::fs;
use std::os::unix::fs::PermissionsExt;
use std::process::Command;

use crate::support::workspace::{Workspace, exit_and_stderr, finish, signal};
use petzval_image::Picture;

const RENDER: &str = "render scene.pbrt --spp 4 --seed 5 -o a.exr";

/// Start of all programs: their arguments as variables. `big` is empty for the small picture that tries
/// a program.
const START: &str = r#"#!/bin/sh
echo "$@" >> calls.txt
while [ $# -gt 0 ]; do
    case "$1" in
        --hdr) hdr=$2; shift;;
        --alb) alb=$2; shift;;
        --nrm) nrm=$2; shift;;
        -o) out=$2; shift;;
        --clean_aux) ;;
        *) echo "unknown argument $1"; exit 1;;
    esac
    shift
done
in=${hdr:-${alb:-$nrm}}
big=$([ "$(wc -c < "$in")" -gt 4000 ] && echo yes)
"#;
const COPY: &str = "cp \"$in\" \"$out\"\n";

/// A folder in which commands find programs of a test.
struct Studio(Workspace);

impl Studio {
    /// Makes a program of this name, whose last lines are `body`.
    fn new(name: &str, body: &str) -> Self {
        let studio = Self(Workspace::new());
        fs::create_dir_all(studio.0.path("bin")).expect("a folder");
        fs::create_dir_all(studio.0.path("tmp")).expect("a folder");
        studio.program(name, body);
        studio
    }

    fn program(&self, name: &str, body: &str) {
        let path = self.0.path("bin").join(name);
        fs::write(&path, format!("{START}{body}")).expect("a program");
        fs::set_permissions(&path, fs::Permissions::from_mode(0o755)).expect("a program");
    }

    fn command(&self, arguments: &str) -> Command {
        let mut command = self.0.command(arguments);
        let bin = self.0.path("bin").display().to_string();
        command.env("PATH", format!("{bin}:/usr/bin:/bin")).env("TMPDIR", self.0.path("tmp"));
        command.env_remove("PETZVAL_DENOISER");
        command
    }

    fn run(&self, arguments: &str) -> (i32, String) {
        exit_and_stderr(self.command(arguments).output().expect("the command starts"))
    }

    fn run_ok(&self, arguments: &str) -> String {
        let (code, stderr) = self.run(arguments);
        assert_eq!(code, 0, "{arguments}: {stderr}");
        stderr
    }

    fn files(&self) -> Vec<String> {
        let own = ["bin", "tmp", "calls.txt"];
        self.0.file_names().into_iter().filter(|name| !own.contains(&name.as_str())).collect()
    }

    /// Returns the channels of a picture whose names begin like this, without that beginning.
    fn channels(&self, name: &str, start: &str) -> Vec<(String, Vec<u32>)> {
        let all = self.0.contents(name).channels.into_iter();
        all.filter_map(|(name, values)| Some((name.strip_prefix(start)?.to_owned(), values)))
            .filter(|(name, _)| !name.contains('.'))
            .collect()
    }

    fn assert_no_temporary_files(&self) {
        let left = fs::read_dir(self.0.path("tmp")).expect("the folder").count();
        assert_eq!(left, 0, "temporary files are left");
    }
}

#[test]
fn without_a_program_the_error_comes_before_the_scene_is_read() {
    let studio = Studio::new("other", COPY);
    for (arguments, expected) in [
        ("--denoise", "neither oidnDenoise nor petzval-denoise is on PATH; install Open Image"),
        ("--denoise=nothing", "--denoise: there is no program nothing; install"),
        ("--denoise=./scene.pbrt", "--denoise: ./scene.pbrt is not executable; try chmod +x"),
        ("--denoise=scene.pbrt", "for the file in this folder write ./scene.pbrt"),
        ("--denoise --sweep fstop=4,8", "neither oidnDenoise nor"),
    ] {
        let (code, stderr) = studio.run(&format!("render missing.pbrt -o a.exr {arguments}"));
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.contains(expected) && !stderr.contains("missing"), "{stderr}");
    }
    let named = studio.command(RENDER).arg("--denoise").env("PETZVAL_DENOISER", "gone").output();
    let (code, stderr) = exit_and_stderr(named.expect("the command starts"));
    assert_eq!(code, 2);
    assert!(stderr.contains("PETZVAL_DENOISER: there is no program gone"), "{stderr}");
    assert!(studio.files().is_empty());
}

#[test]
fn a_program_that_fails_on_a_small_picture_is_refused_before_the_render() {
    for (body, expected) in [
        ("echo Error: no device; exit 3", "failed: exit status: 3: Error: no device"),
        ("true", "wrote no picture: cannot read the picture"),
        ("echo rubbish > \"$out\"", "wrote no picture"),
        ("kill -9 $$", "failed: signal: 9"),
    ] {
        let studio = Studio::new("petzval-denoise", body);
        let (code, stderr) = studio.run("render missing.pbrt -o a.exr --denoise");
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.contains(expected) && stderr.contains("install Open Image"), "{stderr}");
        assert!(stderr.contains("petzval-denoise does not denoise"), "{stderr}");
        studio.assert_no_temporary_files();
    }
}

#[test]
fn the_denoised_picture_is_that_of_the_program_and_the_noisy_one_a_layer() {
    // The program's picture is the albedo, of which every pixel has its place.
    let studio = Studio::new("oidnDenoise", "cp \"${alb:-$in}\" \"$out\"\n");
    studio.program("petzval-denoise", "exit 1");
    studio.run_ok(&RENDER.replace("a.exr", "plain.exr --aov albedo,depth"));
    let stderr = studio.run_ok(&format!("{RENDER} --denoise --aov depth"));
    assert!(stderr.contains(", denoise "), "{stderr}");
    assert_eq!(studio.files(), ["a.exr", "plain.exr"]);
    assert_eq!(studio.channels("a.exr", ""), studio.channels("plain.exr", "albedo."));
    assert_eq!(studio.channels("a.exr", "noisy."), studio.channels("plain.exr", ""));
    assert_eq!(studio.channels("a.exr", "depth."), studio.channels("plain.exr", "depth."));
    assert!(studio.channels("a.exr", "albedo.").is_empty(), "a layer that was not requested");
    let attributes = studio.0.contents("a.exr").attributes;
    assert!(attributes.iter().any(|line| line.contains("oidnDenoise")), "{attributes:?}");
    // The trial, then albedo and normals, which are as noisy, then the picture with both.
    let calls = fs::read_to_string(studio.0.path("calls.txt")).expect("the calls");
    let shape = |line: &str| {
        let words = line.split(' ');
        let file = |word: &str| word.rsplit('/').next().unwrap_or_default().to_owned();
        words.map(file).collect::<Vec<_>>().join(" ")
    };
    let whole = "--hdr beauty.pfm --alb albedo.pfm --nrm normal.pfm --clean_aux -o clean.pfm";
    let expected = [whole, "--alb noisy.pfm -o albedo.pfm", "--nrm noisy.pfm -o normal.pfm", whole];
    assert_eq!(calls.lines().map(shape).collect::<Vec<_>>(), expected);
    studio.assert_no_temporary_files();
}

#[test]
fn layers_that_are_requested_stay() {
    let studio = Studio::new("oidnDenoise", COPY);
    studio.run_ok(&RENDER.replace("a.exr", "plain.exr --aov normal,albedo,variance"));
    studio.run_ok(&format!("{RENDER} --denoise --aov normal,albedo,variance"));
    let plain = studio.0.contents("plain.exr").channels;
    let mut found = studio.0.contents("a.exr").channels;
    found.retain(|(name, _)| !name.starts_with("noisy."));
    assert_eq!(found, plain);
}

#[test]
fn an_8_bit_picture_has_the_noisy_one_beside_it() {
    let studio = Studio::new("oidnDenoise", "cp \"${alb:-$in}\" \"$out\"\n");
    studio.run_ok(&RENDER.replace("a.exr", "plain.png --exposure 0"));
    studio.run_ok(&RENDER.replace("a.exr", "a.png --denoise --exposure 0"));
    assert_eq!(studio.files(), ["a.noisy.png", "a.png", "plain.png"]);
    let [clean, noisy, plain] = ["a.png", "a.noisy.png", "plain.png"]
        .map(|name| Picture::read(&studio.0.path(name)).expect("a picture"));
    assert!(noisy == plain && clean != plain);
    // With automatic exposure, both are as bright as the denoised one needs.
    studio.run_ok(&RENDER.replace("a.exr", "b.png --denoise --exposure auto"));
    let auto = Picture::read(&studio.0.path("b.noisy.png")).expect("a picture");
    studio.run_ok(&RENDER.replace("a.exr", "own.png --exposure auto"));
    assert_ne!(auto, Picture::read(&studio.0.path("own.png")).expect("a picture"));
}

#[test]
fn the_sensor_reads_out_the_denoised_picture() {
    let studio = Studio::new("oidnDenoise", COPY);
    let sensor = "--sensor iso=6400 --bayer";
    studio.run_ok(&RENDER.replace("a.exr", &format!("plain.exr {sensor}")));
    studio.run_ok(&format!("{RENDER} --denoise {sensor}"));
    assert_eq!(studio.channels("a.exr", ""), studio.channels("plain.exr", ""));
    assert_eq!(studio.channels("a.exr", "noisy."), studio.channels("plain.exr", ""));
}

#[test]
fn halves_of_the_pupil_are_those_of_the_sensor_whether_the_program_fails_or_not() {
    let layers = "--sensor iso=800 --aov albedo,normal,dual_pixel";
    let halves = |studio: &Studio, name: &str| {
        ["left.", "right."].map(|half| {
            let channels = studio.channels(name, half);
            assert_eq!(channels.len(), 3, "{name}");
            channels
        })
    };
    let fails = format!("{COPY}[ $big ] || exit 0\nexit 1\n");
    for (program, name) in [(COPY, "a.exr"), (&fails, "a.noisy.exr")] {
        let studio = Studio::new("oidnDenoise", program);
        studio.run_ok(&RENDER.replace("a.exr", &format!("plain.exr {layers}")));
        studio.run(&format!("{RENDER} --denoise {layers}"));
        assert_eq!(halves(&studio, name), halves(&studio, "plain.exr"), "{name}");
    }
}

#[test]
fn a_film_of_another_colour_space_holds_both_pictures_in_it() {
    let studio = Studio::new("oidnDenoise", COPY);
    let text = fs::read_to_string(studio.0.path("scene.pbrt")).expect("the scene");
    fs::write(studio.0.path("scene.pbrt"), format!("ColorSpace \"rec2020\"\n{text}"))
        .expect("a scene");
    studio.run_ok(&format!("{RENDER} --denoise"));
    assert_eq!(studio.channels("a.exr", "noisy."), studio.channels("a.exr", ""));
    let read = Picture::read(&studio.0.path("a.exr")).expect("a picture");
    let red: Vec<u32> = read.pixels.iter().map(|pixel| pixel[0].to_bits()).collect();
    assert!(studio.channels("a.exr", "").iter().all(|(_, values)| *values != red));
}

#[test]
fn the_noisy_picture_survives_a_program_that_fails() {
    let half = "head -c 5000 \"$in\" > \"$out\"";
    let small = "printf 'PF\\n1 1\\n-1.0\\n123456789012' > \"$out\"";
    let infinite =
        "head -c 17 \"$in\" > \"$out\"; head -c 43200 /dev/zero | tr '\\0' '\\377' >> \"$out\"";
    for (body, expected) in [
        (
            "echo first; echo Error: out of memory >&2; exit 1",
            "exit status: 1: Error: out of memory",
        ),
        (half, "its length does not match the size in its header"),
        (small, "its size is 1 x 1, expected 72 x 50"),
        (infinite, "some of its pixels are not finite"),
        ("[ -z \"$hdr\" ] && kill -9 $$; true", "signal: 9"),
    ] {
        let studio = Studio::new("oidnDenoise", &format!("{COPY}[ $big ] || exit 0\n{body}\n"));
        fs::write(studio.0.path("a.exr"), "an older picture").expect("a file");
        studio.run_ok(&RENDER.replace("a.exr", "plain.exr --aov albedo,normal"));
        let (code, stderr) = studio.run(&format!("{RENDER} --denoise"));
        assert_eq!(code, 2, "{body}: {stderr}");
        assert!(stderr.contains(expected), "{body}: {stderr}");
        assert!(stderr.contains("a.noisy.exr is the noisy picture"), "{stderr}");
        assert_eq!(studio.files(), ["a.exr", "a.noisy.exr", "plain.exr"]);
        let (noisy, plain) = (studio.0.contents("a.noisy.exr"), studio.0.contents("plain.exr"));
        assert_eq!(noisy, plain);
        assert_eq!(fs::read(studio.0.path("a.exr")).expect("a file"), b"an older picture");
        studio.assert_no_temporary_files();
    }
}

#[test]
fn ctrl_c_ends_a_program_that_hangs_and_keeps_the_noisy_picture() {
    let hang = "[ $big ] && { trap '' INT TERM; echo hanging > hangs.txt; exec sleep 600; }\n";
    let studio = Studio::new("oidnDenoise", &format!("{hang}{COPY}"));
    studio.run_ok(&RENDER.replace("a.exr", "plain.exr --aov albedo,normal"));
    let mut child = studio.command(&format!("{RENDER} --denoise")).spawn().expect("a child");
    studio.0.wait_for_file(&mut child, "hangs.txt", 1);
    signal(&child, "INT");
    let (code, stderr) = finish(child);
    assert_eq!(code, 130, "{stderr}");
    assert!(
        stderr.contains("interrupted while the picture was denoised; a.noisy.exr is the noisy"),
        "{stderr}"
    );
    assert_eq!(studio.0.contents("a.noisy.exr"), studio.0.contents("plain.exr"));
    studio.assert_no_temporary_files();
}

#[test]
fn a_noisy_picture_that_cannot_be_written_is_an_error_before_the_render() {
    let studio = Studio::new("oidnDenoise", COPY);
    for (output, folder) in [("a.png", "a.noisy.png"), ("a.exr", "a.noisy.exr")] {
        fs::create_dir(studio.0.path(folder)).expect("a folder");
        let (code, stderr) =
            studio.run(&RENDER.replace("a.exr", output).replace("--spp 4", "--spp 4 --denoise"));
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.contains(&format!("{folder} is a folder")), "{stderr}");
        assert!(!stderr.contains("the samples are lost") && !studio.0.path(output).exists());
    }
    let command = studio.command(RENDER).arg("--denoise").env("TMPDIR", "/nowhere").output();
    let (code, stderr) = exit_and_stderr(command.expect("the command starts"));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("cannot write /nowhere") && !stderr.contains("install"), "{stderr}");
}

#[test]
fn no_picture_is_written_over_the_program() {
    let studio = Studio::new("mine.exr", COPY);
    let program = fs::read(studio.0.path("bin/mine.exr")).expect("the program");
    std::os::unix::fs::symlink("bin/mine.exr", studio.0.path("a.noisy.exr")).expect("a link");
    for arguments in [
        "-o bin/mine.exr --denoise=bin/mine.exr",
        "-o bin/../bin/mine.exr --denoise=mine.exr",
        "-o a.png --denoise=mine.exr",
        "-o bin/{fstop}.exr --sweep fstop=8 --contact b.png --denoise=bin/8.exr",
    ] {
        fs::hard_link(studio.0.path("bin/mine.exr"), studio.0.path("bin/8.exr")).expect("a link");
        let (code, stderr) = studio.run(&format!("render scene.pbrt --spp 1 {arguments}"));
        assert!(code == 2 && stderr.contains("an input"), "{arguments}: {stderr}");
        assert_eq!(fs::read(studio.0.path("bin/mine.exr")).expect("the program"), program);
        fs::remove_file(studio.0.path("bin/8.exr")).expect("the link");
    }
}

#[test]
fn ctrl_c_ends_the_trial_of_a_program_and_removes_its_folder() {
    // A program that it starts would write a file later.
    let body = "(sleep 2; echo lives > lives.txt) & echo hanging > hangs.txt; wait\n";
    let studio = Studio::new("oidnDenoise", body);
    let mut child = studio.command(&format!("{RENDER} --denoise")).spawn().expect("a child");
    studio.0.wait_for_file(&mut child, "hangs.txt", 1);
    signal(&child, "INT");
    let (code, stderr) = finish(child);
    assert_eq!(code, 130, "{stderr}");
    studio.assert_no_temporary_files();
    std::thread::sleep(std::time::Duration::from_millis(2500));
    assert!(!studio.0.path("lives.txt").exists(), "the program outlives the command");
}

#[test]
fn a_checkpoint_is_denoised_without_rendering_again() {
    let studio =
        Studio::new("oidnDenoise", &format!("{COPY}[ $big ] && [ ! -e works ] && exit 1\n:"));
    let long = RENDER.replace("--spp 4", "--spp 200 --checkpoint 0.01s");
    let (code, stderr) = studio.run(&format!("{long} --denoise"));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("a.exr.checkpoint holds all samples; denoise again with"), "{stderr}");
    assert!(stderr.contains("\n  petzval render --resume scene.pbrt"), "{stderr}");
    fs::write(studio.0.path("works"), "").expect("a file");
    let (noisy, before) = (studio.0.contents("a.noisy.exr"), studio.0.path("a.exr").exists());
    let stderr = studio.run_ok(&format!("{long} --denoise --resume"));
    assert!(stderr.contains("resuming from a.exr.checkpoint"), "{stderr}");
    assert!(!before && !studio.0.path("a.exr.checkpoint").exists());
    let found: Vec<_> = noisy.channels.iter().filter(|(name, _)| !name.contains('.')).collect();
    assert_eq!(found.len(), 3);
    let channels = studio.channels("a.exr", "noisy.");
    assert!(found.iter().zip(&channels).all(|(noisy, layer)| noisy.1 == layer.1));
}

#[test]
fn an_interrupted_render_is_not_denoised() {
    let studio = Studio::new("oidnDenoise", COPY);
    let long = RENDER.replace("--spp 4", "--spp 40000 --checkpoint 0.1s");
    let mut child = studio.command(&format!("{long} --denoise")).spawn().expect("a child");
    studio.0.wait_for_file(&mut child, "a.exr.checkpoint", 6000);
    signal(&child, "INT");
    let (code, stderr) = finish(child);
    assert_eq!(code, 130, "{stderr}");
    assert_eq!(studio.files(), ["a.exr.checkpoint", "a.partial.exr"]);
    let channels = studio.0.contents("a.partial.exr").channels;
    assert_eq!(channels.len(), 3, "layers that were not requested");
}

#[test]
fn parts_are_denoised_when_they_are_merged() {
    let studio = Studio::new("oidnDenoise", COPY);
    studio.run_ok(&format!("{RENDER} --denoise"));
    // A machine that renders parts needs no program.
    for i in 1..=2 {
        let part = RENDER.replace("a.exr", &format!("{i}.petzval --shard {i}/2 --denoise"));
        let output = studio.command(&part).env("PATH", "").output().expect("the command starts");
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    }
    studio.run_ok("merge 1.petzval 2.petzval -o merged.exr --denoise");
    let difference = studio.0.contents("merged.exr").difference(&studio.0.contents("a.exr"));
    assert!(difference < 1e-5, "{difference:e}");
    studio.run_ok("merge 1.petzval 2.petzval -o plain.exr");
    assert_eq!(studio.channels("plain.exr", ""), studio.channels("merged.exr", "noisy."));
    assert!(studio.channels("plain.exr", "noisy.").is_empty());
    assert!(studio.channels("plain.exr", "albedo.").is_empty());
    studio.run_ok(&RENDER.replace("a.exr", "3.petzval --samples 0..4"));
    let (code, stderr) = studio.run("merge 3.petzval -o other.exr --denoise");
    assert_eq!(code, 2);
    assert!(stderr.contains("the parts hold no albedo and no normals"), "{stderr}");
}

#[test]
fn a_sweep_is_denoised_and_a_picture_is_not_an_input() {
    let studio = Studio::new("oidnDenoise", "cp \"${alb:-$in}\" \"$out\"\n");
    studio.run_ok(
        "render scene.pbrt --spp 2 --effects none --sweep fstop=4,8 -o {fstop}.exr --denoise",
    );
    studio.run_ok("render scene.pbrt --spp 2 --effects none --fstop 8 -o single.exr --denoise");
    assert_eq!(studio.0.contents("8.exr").channels, studio.0.contents("single.exr").channels);
    // The same sweep without --denoise renders other pictures.
    let again =
        "render scene.pbrt --spp 2 --effects none --sweep fstop=4,8 -o {fstop}.exr --resume";
    assert!(studio.run_ok(&format!("{again} --denoise")).contains("2 of them unchanged"));
    assert!(studio.run_ok(again).contains("0 of them unchanged"));
    // A picture without its noisy one is not finished.
    let png = "render scene.pbrt --spp 2 --effects none --sweep fstop=4,8 -o {fstop}.png --resume --denoise";
    studio.run_ok(png);
    assert!(studio.run_ok(png).contains("2 of them unchanged"));
    fs::remove_file(studio.0.path("8.noisy.png")).expect("the noisy picture");
    let stderr = studio.run_ok(png);
    assert!(stderr.contains("the noisy picture of 8.png is missing"), "{stderr}");
    assert!(studio.0.path("8.noisy.png").is_file());
    // Another denoiser makes other pictures.
    studio.program("mirror", COPY);
    let other = png.replace("--denoise", "--denoise=mirror");
    assert!(studio.run_ok(&other).contains("0 of them unchanged"));
    // The noisy picture must not replace a texture of the scene.
    fs::copy(studio.0.path("8.exr"), studio.0.path("b.noisy.exr")).expect("a texture");
    let scene = fs::read_to_string(studio.0.path("scene.pbrt")).expect("the scene");
    let texture = "Texture \"t\" \"spectrum\" \"imagemap\" \"string filename\" \"b.noisy.exr\"";
    let used = "Material \"diffuse\" \"texture reflectance\" \"t\" Shape \"disk\"";
    fs::write(studio.0.path("scene.pbrt"), format!("{scene}\n{texture}\n{used}\n"))
        .expect("a scene");
    let (code, stderr) = studio.run("render scene.pbrt --spp 1 -o b.exr --denoise");
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("cannot write b.noisy.exr"), "{stderr}");
    studio.run_ok("render scene.pbrt --spp 1 -o b.exr");
}
