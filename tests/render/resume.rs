//! Resume: renders that are killed or stopped lose no samples.

use std::process::{Child, Command};
use std::time::{Duration, Instant};

use crate::support::workspace::{Workspace, finish, forge_build, signal};
use crate::support::{Random, wait_until};
use petzval_render::checkpoint::SavedRender;

/// A uniform render with layers of every kind that is accumulated.
const UNIFORM: &str = "render scene.pbrt -o a.exr --spp 150 --effects +ghosts --threads 2 \
                    --aov variance,depth,samples,object,dual_pixel,cryptomatte,motion";
const ADAPTIVE: &str = "render scene.pbrt -o a.exr --noise 0.02 --effects +ghosts --threads 2 \
                        --aov variance,depth,dual_pixel,cryptomatte,motion";

/// Size of a checkpoint that holds samples of a tile or more, bytes: 256 pixels take 6 KB.
const SOME_TILES: u64 = 8000;

/// Returns how often a test kills: `PETZVAL_KILLS=200 cargo test --release --test render resume::`.
fn kills() -> u32 {
    std::env::var("PETZVAL_KILLS").map_or(6, |kills| kills.parse().expect("a number"))
}

/// Kills a render at random moments and resumes it. The picture must be the same each time.
fn survives_kills(arguments: &str, seed: u64) {
    let workspace = Workspace::new();
    let begun = Instant::now();
    workspace.run_ok(arguments);
    let time = begun.elapsed().as_secs_f64();
    let whole = workspace.contents("a.exr");
    let mut random = Random::new(seed);
    let (mut resumed, mut killed) = (0, 0);
    while killed < kills() {
        std::fs::remove_file(workspace.path("a.exr")).expect("the earlier picture");
        let mut resume = "";
        // Twice, so that resumed renders are killed too.
        for _ in 0..2 {
            let mut child = workspace.start(&format!("{arguments} --checkpoint 2ms {resume}"));
            // The first render leaves a checkpoint for certain, the others die at random moments.
            if killed == 0 {
                workspace.wait_for_file(&mut child, "a.exr.checkpoint", SOME_TILES);
            } else {
                std::thread::sleep(Duration::from_secs_f64(random.next() * 1.2 * time));
            }
            child.kill().expect("a child");
            killed += u32::from(!child.wait().expect("a child").success());
            resume = "--resume";
        }
        if workspace.path("a.exr").exists() {
            assert_eq!(
                workspace.contents("a.exr"),
                whole,
                "a picture of a killed render is damaged"
            );
        }
        let stderr = workspace.run_ok(&format!("{arguments} --resume"));
        resumed += u32::from(!stderr.contains("from the beginning"));
        assert_eq!(workspace.contents("a.exr"), whole, "after {killed} kills");
        // Neither the checkpoint nor a partly written file remains.
        assert_eq!(workspace.file_names(), ["a.exr"], "nothing is left over");
    }
    println!("{killed} kills, {resumed} pictures from checkpoints, {time:.2} s each");
    assert!(resumed > 0);
}

#[test]
fn a_uniform_render_is_the_same_after_any_kill() {
    survives_kills(UNIFORM, 1);
}

#[test]
fn an_adaptive_render_is_the_same_after_any_kill() {
    survives_kills(ADAPTIVE, 2);
}

/// Starts a render and returns it when its checkpoint holds samples.
fn start_and_checkpoint(workspace: &Workspace, arguments: &str) -> Child {
    let mut child = workspace.start(&format!("{arguments} --checkpoint 2ms"));
    workspace.wait_for_file(&mut child, "a.exr.checkpoint", SOME_TILES);
    child
}

/// Stops such a render by a signal, and returns its standard error.
fn stopped(workspace: &Workspace, arguments: &str, name: &str) -> String {
    let child = start_and_checkpoint(workspace, arguments);
    signal(&child, name);
    let (code, stderr) = finish(child);
    assert_eq!(code, 130, "{stderr}");
    stderr
}

#[test]
fn ctrl_c_and_sigterm_print_how_to_resume() {
    for (arguments, name) in [(UNIFORM, "INT"), (ADAPTIVE, "TERM")] {
        let workspace = Workspace::new();
        let arguments = arguments.replace("--spp 150", "--spp 400");
        workspace.run_ok(&arguments);
        let whole = workspace.contents("a.exr");
        let stderr = stopped(&workspace, &arguments, name);
        assert_eq!(workspace.file_names(), ["a.exr", "a.exr.checkpoint", "a.partial.exr"]);
        let on = format!("{} --checkpoint 2ms\n", arguments.replace("render", "render --resume"));
        assert!(stderr.contains(&on), "{stderr}");
        assert!(stderr.contains("a.partial.exr has no variance layer"), "{stderr}");
        let stderr = workspace.run_ok(&format!("{arguments} --resume"));
        let count =
            if arguments.contains("--spp") { "of 400 samples a pixel" } else { "samples a pixel" };
        assert!(stderr.contains("resuming from a.exr.checkpoint: "), "{stderr}");
        assert!(stderr.contains(&format!("{count} are done")), "{stderr}");
        assert!(!stderr.contains("variance"), "{stderr}");
        assert_eq!(workspace.contents("a.exr"), whole);
        assert_eq!(workspace.file_names(), ["a.exr"], "nothing is left over");
    }
}

#[test]
fn a_partial_picture_is_divided_by_its_own_sample_counts() {
    let workspace = Workspace::new();
    // A pass of 256 samples takes seconds. The sums of light paths would fill the checkpoint that is
    // waited for before any tile is done.
    let arguments =
        "render scene.pbrt -o a.exr --effects none --light-paths off --resolution 144x100";
    workspace.run_ok(&format!("{arguments} --spp 256"));
    let whole = workspace.contents("a.exr");
    stopped(&workspace, &format!("{arguments} --spp 100000"), "INT");
    assert_eq!(workspace.contents("a.exr"), whole, "the earlier picture is still there");
    let partial = workspace.contents("a.partial.exr");
    let (mut lit, mut pixels) = (0, 0);
    for ((_, partial), (_, whole)) in partial.channels.iter().zip(&whole.channels) {
        for (&partial, &whole) in partial.iter().zip(whole) {
            assert!(partial == 0 || partial == whole, "a pixel is black or has its 256 samples");
            lit += u32::from(partial != 0);
            pixels += 1;
        }
    }
    assert!(lit > 0, "no pixel is done");
    let number = |name: &str| -> f64 {
        let found = partial.attributes.iter().find_map(|text| text.strip_prefix(name));
        let found = found.unwrap_or_else(|| panic!("{name}: {:?}", partial.attributes));
        found.trim_start_matches(": F32(").trim_end_matches(')').parse().expect("a number")
    };
    assert_eq!(number("complete"), 0.0);
    let mean = 256.0 * f64::from(lit) / f64::from(pixels);
    assert!((number("samplesPerPixel") / mean - 1.0).abs() < 1e-5, "{mean}");
}

#[test]
fn changed_options_and_files_are_named_and_refused() {
    let workspace = Workspace::new();
    stopped(&workspace, UNIFORM, "INT");
    let resume = format!("{UNIFORM} --resume");
    let refuses = |arguments: &str, expected: &str| workspace.refuses(arguments, expected);
    refuses(&format!("{resume} --fstop 4"), "--fstop was not given, and is 4 now");
    refuses(&format!("{resume} --seed 3"), "the seed was 0, and is 3 now");
    refuses(&resume.replace("150", "151"), "the number of samples was 150, and is 151 now");
    refuses(&format!("{resume} --resolution 40x30"), "the resolution was 72x50");
    refuses(&resume.replace("depth,", ""), "the list of layers was [variance, depth");
    for (name, what) in [("floor.pbrt", "# another\n"), ("lens.dat", "# another\n")] {
        let text = std::fs::read_to_string(workspace.path(name)).expect("a text");
        std::fs::write(workspace.path(name), format!("{text}\n{what}")).expect("a file");
        refuses(&resume, &format!("{name} has changed since"));
        std::fs::write(workspace.path(name), text).expect("a file");
    }
    let checkpoint = workspace.path("a.exr.checkpoint");
    let own = std::fs::read(&checkpoint).expect("a checkpoint");
    forge_build(&checkpoint);
    refuses(&resume, "it was begun by another build of petzval");
    std::fs::write(&checkpoint, own).expect("the checkpoint");
    // Threads, lanes and the checkpoint interval may change.
    workspace.run_ok(&format!("{resume} --backend scalar --checkpoint 3s"));
}

#[test]
fn without_resume_a_render_starts_anew_and_mentions_the_checkpoint() {
    let workspace = Workspace::new();
    stopped(&workspace, UNIFORM, "INT");
    let stderr = workspace.run_ok(&format!("{UNIFORM} --fstop 8"));
    assert!(
        stderr.contains("a.exr.checkpoint is of another picture (--fstop was not given"),
        "{stderr}"
    );
    assert!(
        workspace.path("a.exr.checkpoint").exists(),
        "a checkpoint of another picture was replaced"
    );
    let stderr = workspace.run_ok(UNIFORM);
    assert!(stderr.contains("--resume would continue"), "{stderr}");
    assert_eq!(workspace.file_names(), ["a.exr"]);
    let stderr = workspace.run_ok(&format!("{UNIFORM} --resume"));
    assert!(
        stderr.contains("there is no a.exr.checkpoint; rendering from the beginning"),
        "{stderr}"
    );
}

#[test]
fn a_checkpoint_with_more_samples_is_not_replaced() {
    let workspace = Workspace::new();
    let long = UNIFORM.replace("150", "4000");
    let mut child = start_and_checkpoint(&workspace, &long);
    wait_until("a checkpoint that holds much", || {
        assert!(child.try_wait().expect("a child").is_none(), "the render ended too early");
        let saved = SavedRender::open(&workspace.path("a.exr.checkpoint"));
        saved.is_ok_and(|saved| saved.head.film_samples > 72 * 50 * 600)
    });
    child.kill().expect("a child");
    child.wait().expect("a child");
    let before = std::fs::read(workspace.path("a.exr.checkpoint")).expect("a checkpoint");
    // A render that is stopped early must not replace the checkpoint by its own, which holds less. If it
    // is stopped while it reads the scene, it just ends; so stop it later and later.
    let stopped = (2..30).any(|wait| {
        let child = workspace.start(&format!("{long} --checkpoint 60s"));
        std::thread::sleep(Duration::from_millis(50 * wait));
        signal(&child, "INT");
        let (code, stderr) = finish(child);
        code == 130 && stderr.contains("interrupted; a.exr was not written")
    });
    assert!(stopped);
    assert!(std::fs::read(workspace.path("a.exr.checkpoint")).expect("a checkpoint") == before);
}

#[test]
fn a_picture_that_cannot_be_written_is_not_lost() {
    let workspace = Workspace::new();
    let arguments = UNIFORM.replace("150", "400");
    workspace.run_ok(&arguments);
    let whole = workspace.contents("a.exr");
    std::fs::remove_file(workspace.path("a.exr")).expect("the picture");
    let child = start_and_checkpoint(&workspace, &arguments);
    std::fs::create_dir(workspace.path("a.exr")).expect("a folder in the picture's place");
    let (code, stderr) = finish(child);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("cannot write the picture a.exr"), "{stderr}");
    assert!(stderr.contains("a.exr.checkpoint holds the state of the render"), "{stderr}");
    let saved = SavedRender::open(&workspace.path("a.exr.checkpoint")).expect("a checkpoint");
    assert_eq!(saved.head.film_samples, 72 * 50 * 400, "all samples are there");
    std::fs::remove_dir(workspace.path("a.exr")).expect("the folder");
    workspace.run_ok(&arguments.replace("render", "render --resume"));
    assert_eq!(workspace.contents("a.exr"), whole);
    assert_eq!(workspace.file_names(), ["a.exr"]);
}

#[test]
fn no_checkpoint_is_written_if_it_is_off() {
    let workspace = Workspace::new();
    let arguments = UNIFORM.replace("150", "1000000");
    // Stopped later and later, until the render has begun.
    let rendered = (1..60).any(|wait| {
        let child = workspace.start(&format!("{arguments} --checkpoint off"));
        std::thread::sleep(Duration::from_millis(50 * wait));
        signal(&child, "INT");
        let (code, stderr) = finish(child);
        assert!(code == 130 || wait < 10, "exit code {code}: {stderr}");
        workspace.path("a.partial.exr").exists()
    });
    assert!(rendered, "no partial picture");
    assert_eq!(workspace.file_names(), ["a.partial.exr"]);
    // A render shorter than the default interval of a minute.
    workspace.run_ok(UNIFORM);
    assert_eq!(workspace.file_names(), ["a.exr", "a.partial.exr"]);
}

#[test]
fn a_finished_part_is_not_used_as_a_checkpoint() {
    let workspace = Workspace::new();
    workspace.run_ok(&format!("{} --samples 0..9", UNIFORM.replace("a.exr", "a.petzval")));
    std::fs::rename(workspace.path("a.petzval"), workspace.path("a.exr.checkpoint"))
        .expect("a part");
    for arguments in [UNIFORM.to_owned(), format!("{UNIFORM} --resume")] {
        workspace.refuses(&arguments, "a.exr.checkpoint is a finished part of a picture");
    }
    assert_eq!(workspace.file_names(), ["a.exr.checkpoint"], "it is still there");
}

#[cfg(unix)]
#[test]
fn a_lens_from_a_pipe_is_compared_by_its_content() {
    let workspace = Workspace::new();
    let made = Command::new("mkfifo").arg(workspace.path("pipe.dat")).status();
    assert!(made.expect("mkfifo").success());
    let lens = std::fs::read_to_string(workspace.path("lens.dat")).expect("a lens");
    let piped = |arguments: &str, lens: &str| {
        let child = workspace.start(arguments);
        std::fs::write(workspace.path("pipe.dat"), lens).expect("a reader");
        finish(child)
    };
    let arguments = "render scene.pbrt --spp 4 --resolution 24x16 --lens pipe.dat --checkpoint off";
    for i in [1, 2] {
        let (code, stderr) = piped(&format!("{arguments} --shard {i}/2 -o {i}.petzval"), &lens);
        assert_eq!(code, 0, "{stderr}");
    }
    let merge = "merge 1.petzval 2.petzval -o a.exr";
    let (code, stderr) = piped(merge, &format!("{lens}\n# another\n"));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("pipe.dat has changed since"), "{stderr}");
    let (code, stderr) = piped(merge, &lens);
    assert_eq!(code, 0, "{stderr}");
}

/// Returns the exit code and the standard error of a command that must not wait for a writer.
fn ends(mut child: Child) -> (i32, String) {
    wait_until("the end of the command", || child.try_wait().expect("a child").is_some());
    finish(child)
}

#[cfg(unix)]
#[test]
fn a_pipe_in_place_of_a_checkpoint_or_a_texture_is_refused() {
    let workspace = Workspace::new();
    for name in ["a.exr.checkpoint", "pipe.png"] {
        let made = Command::new("mkfifo").arg(workspace.path(name)).status();
        assert!(made.expect("mkfifo").success());
    }
    let (code, stderr) = ends(workspace.start(&format!("{UNIFORM} --resume")));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("a.exr.checkpoint: this is no checkpoint"), "{stderr}");
    let texture = r#"Texture "it" "spectrum" "imagemap" "string filename" "pipe.png""#;
    std::fs::write(workspace.path("floor.pbrt"), texture).expect("a file");
    let (code, stderr) = ends(workspace.start("render scene.pbrt -o b.exr"));
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("pipe.png: it is a pipe or a device; expected a file"), "{stderr}");
}
