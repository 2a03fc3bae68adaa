//! No work is lost: renders that are killed, stopped and gone on with.

mod support;

use std::process::{Child, Command};
use std::time::{Duration, Instant};

use petzval::checkpoint::Saved;
use support::Random;
use support::kept::{Studio, forge_build, said};

/// Everything that is added up has a layer.
const EVEN: &str = "render scene.pbrt -o a.exr --spp 150 --effects +ghosts --threads 2 \
                    --aov variance,depth,samples,object";
const ADAPTIVE: &str = "render scene.pbrt -o a.exr --noise 0.02 --effects +ghosts --threads 2 \
                        --aov variance,depth";

/// How often the tests kill: `PETZVAL_KILLS=200 cargo test --release --test resume`.
fn kills() -> u32 {
    std::env::var("PETZVAL_KILLS").map_or(6, |kills| kills.parse().expect("a number"))
}

fn signal(child: &Child, name: &str) {
    let kill = Command::new("kill").args([name, &child.id().to_string()]).status();
    assert!(kill.expect("kill").success());
}

/// Kills a render at random moments, goes on with it, and finds the same picture each time.
fn survives_kills(words: &str, seed: u64) {
    let studio = Studio::new();
    let begun = Instant::now();
    studio.done(words);
    let time = begun.elapsed().as_secs_f64();
    let whole = studio.contents("a.exr");
    let mut random = Random::new(seed);
    let (mut resumed, mut killed) = (0, 0);
    while killed < kills() {
        std::fs::remove_file(studio.path("a.exr")).expect("the picture of before");
        let mut resume = "";
        // Often twice, so that what went on is killed too.
        for _ in 0..2 {
            let mut child = studio.start(&format!("{words} --checkpoint 2ms {resume}"));
            std::thread::sleep(Duration::from_secs_f64(random.next() * 1.2 * time));
            child.kill().expect("a child");
            killed += u32::from(!child.wait().expect("a child").success());
            resume = "--resume";
        }
        if studio.path("a.exr").exists() {
            assert_eq!(studio.contents("a.exr"), whole, "never a broken picture");
        }
        let said = studio.done(&format!("{words} --resume"));
        resumed += u32::from(!said.contains("from the beginning"));
        assert_eq!(studio.contents("a.exr"), whole, "after {killed} kills");
        // Neither the checkpoint nor what was being written when it was killed.
        assert_eq!(studio.names(), ["a.exr"], "nothing is left over");
    }
    println!("{killed} kills, {resumed} pictures from checkpoints, {time:.2} s each");
    assert!(resumed > 0);
}

#[test]
fn an_even_render_is_the_same_after_any_kill() {
    survives_kills(EVEN, 1);
}

#[test]
fn an_adaptive_render_is_the_same_after_any_kill() {
    survives_kills(ADAPTIVE, 2);
}

/// A render that has a checkpoint with something in it.
fn begun(studio: &Studio, words: &str) -> Child {
    let mut child = studio.start(&format!("{words} --checkpoint 2ms"));
    // A share of a tile of 256 pixels has 6 KB.
    let holds =
        |least| std::fs::metadata(studio.path("a.exr.checkpoint")).is_ok_and(|m| m.len() > least);
    while !holds(8000) {
        assert!(child.try_wait().expect("a child").is_none(), "it ended before its checkpoint");
        std::thread::sleep(Duration::from_millis(1));
    }
    child
}

/// Stops such a render: what it says.
fn stopped(studio: &Studio, words: &str, name: &str) -> String {
    let child = begun(studio, words);
    signal(&child, name);
    let (code, said) = said(child.wait_with_output().expect("a child"));
    assert_eq!(code, 130, "{said}");
    said
}

#[test]
fn ctrl_c_and_sigterm_say_how_to_go_on() {
    for (words, name) in [(EVEN, "-INT"), (ADAPTIVE, "-TERM")] {
        let studio = Studio::new();
        let words = words.replace("--spp 150", "--spp 400");
        studio.done(&words);
        let whole = studio.contents("a.exr");
        let said = stopped(&studio, &words, name);
        assert_eq!(studio.names(), ["a.exr", "a.exr.checkpoint", "a.partial.exr"]);
        let on = format!("{} --checkpoint 2ms\n", words.replace("render", "render --resume"));
        assert!(said.contains(&on), "{said}");
        assert!(said.contains("a.partial.exr has no layer of variance"), "{said}");
        let said = studio.done(&format!("{words} --resume"));
        let count =
            if words.contains("--spp") { "of 400 samples a pixel" } else { "samples a pixel" };
        assert!(said.contains("going on from a.exr.checkpoint: "), "{said}");
        assert!(said.contains(&format!("{count} are done")), "{said}");
        assert!(!said.contains("variance"), "{said}");
        assert_eq!(studio.contents("a.exr"), whole);
        assert_eq!(studio.names(), ["a.exr"], "nothing is left over");
    }
}

#[test]
fn what_there_is_of_a_picture_is_divided_by_its_own_counts() {
    let studio = Studio::new();
    // A pass has 256 samples, and takes seconds.
    let words = "render scene.pbrt -o a.exr --effects none --resolution 144x100";
    studio.done(&format!("{words} --spp 256"));
    let whole = studio.contents("a.exr");
    stopped(&studio, &format!("{words} --spp 100000"), "-INT");
    assert_eq!(studio.contents("a.exr"), whole, "the earlier picture is still there");
    let partial = studio.contents("a.partial.exr");
    let (mut lit, mut pixels) = (0, 0);
    for ((_, partial), (_, whole)) in partial.channels.iter().zip(&whole.channels) {
        for (&partial, &whole) in partial.iter().zip(whole) {
            assert!(partial == 0 || partial == whole, "a pixel is black or has its 256 samples");
            lit += u32::from(partial != 0);
            pixels += 1;
        }
    }
    assert!(lit > 0, "a share is done");
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
fn what_has_changed_is_named_and_refused() {
    let studio = Studio::new();
    stopped(&studio, EVEN, "-INT");
    let resume = format!("{EVEN} --resume");
    let refuses = |words: &str, expected: &str| studio.refuses(words, expected);
    refuses(&format!("{resume} --fstop 4"), "--fstop was not given, and is 4 now");
    refuses(&format!("{resume} --seed 3"), "the seed was 0, and is 3 now");
    refuses(&resume.replace("150", "151"), "the number of samples was 150, and is 151 now");
    refuses(&format!("{resume} --resolution 40x30"), "the resolution was 72x50");
    refuses(&resume.replace("depth,", ""), "the list of layers was [variance, depth");
    for (name, what) in [("floor.pbrt", "# another\n"), ("lens.dat", "# another\n")] {
        let text = std::fs::read_to_string(studio.path(name)).expect("a text");
        std::fs::write(studio.path(name), format!("{text}\n{what}")).expect("a file");
        refuses(&resume, &format!("{name} has changed since"));
        std::fs::write(studio.path(name), text).expect("a file");
    }
    let checkpoint = studio.path("a.exr.checkpoint");
    let own = std::fs::read(&checkpoint).expect("a checkpoint");
    forge_build(&checkpoint);
    refuses(&resume, "it was begun by another build of petzval");
    std::fs::write(&checkpoint, own).expect("the checkpoint");
    // Threads, lanes and times decide nothing.
    studio.done(&format!("{resume} --backend scalar --checkpoint 3s"));
}

#[test]
fn without_resume_a_render_begins_again_and_says_what_is_there() {
    let studio = Studio::new();
    stopped(&studio, EVEN, "-INT");
    let said = studio.done(&format!("{EVEN} --fstop 8"));
    assert!(
        said.contains("a.exr.checkpoint is of another picture (--fstop was not given"),
        "{said}"
    );
    assert!(studio.path("a.exr.checkpoint").exists(), "what was not written over is still there");
    let said = studio.done(EVEN);
    assert!(said.contains("--resume would go on"), "{said}");
    assert_eq!(studio.names(), ["a.exr"]);
    let said = studio.done(&format!("{EVEN} --resume"));
    assert!(said.contains("there is no a.exr.checkpoint; rendering from the beginning"), "{said}");
}

#[test]
fn a_checkpoint_that_knows_more_is_not_written_over() {
    let studio = Studio::new();
    let long = EVEN.replace("150", "4000");
    let mut child = begun(&studio, &long);
    std::thread::sleep(Duration::from_millis(1500));
    child.kill().expect("a child");
    child.wait().expect("a child");
    let before = std::fs::read(studio.path("a.exr.checkpoint")).expect("a checkpoint");
    // Stopped it would write down what it has, which is less; while it reads it just ends.
    let stopped = (2..30).any(|wait| {
        let child = studio.start(&format!("{long} --checkpoint 60s"));
        std::thread::sleep(Duration::from_millis(50 * wait));
        signal(&child, "-INT");
        let (code, said) = said(child.wait_with_output().expect("a child"));
        code == 130 && said.contains("interrupted; a.exr was not written")
    });
    assert!(stopped);
    assert!(std::fs::read(studio.path("a.exr.checkpoint")).expect("a checkpoint") == before);
}

#[test]
fn a_picture_that_cannot_be_written_is_not_lost() {
    let studio = Studio::new();
    let words = EVEN.replace("150", "400");
    studio.done(&words);
    let whole = studio.contents("a.exr");
    std::fs::remove_file(studio.path("a.exr")).expect("the picture");
    let child = begun(&studio, &words);
    std::fs::create_dir(studio.path("a.exr")).expect("a folder in the picture's place");
    let (code, said) = said(child.wait_with_output().expect("a child"));
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("cannot write the picture a.exr"), "{said}");
    assert!(said.contains("a.exr.checkpoint holds what is done"), "{said}");
    let saved = Saved::open(&studio.path("a.exr.checkpoint")).expect("a checkpoint");
    assert_eq!(saved.head.taken, 72 * 50 * 400, "all samples are there");
    std::fs::remove_dir(studio.path("a.exr")).expect("the folder");
    studio.done(&words.replace("render", "render --resume"));
    assert_eq!(studio.contents("a.exr"), whole);
    assert_eq!(studio.names(), ["a.exr"]);
}

#[test]
fn no_checkpoint_is_written_where_none_is_wanted() {
    let studio = Studio::new();
    let words = EVEN.replace("150", "1000000");
    let child = studio.start(&format!("{words} --checkpoint off"));
    std::thread::sleep(Duration::from_millis(1500));
    signal(&child, "-INT");
    let (code, said) = said(child.wait_with_output().expect("a child"));
    assert_eq!(code, 130, "{said}");
    assert_eq!(studio.names(), ["a.partial.exr"]);
    // As short as the usual minute.
    studio.done(EVEN);
    assert_eq!(studio.names(), ["a.exr", "a.partial.exr"]);
}

#[test]
fn a_finished_part_is_no_checkpoint() {
    let studio = Studio::new();
    studio.done(&format!("{} --samples 0..9", EVEN.replace("a.exr", "a.petzval")));
    std::fs::rename(studio.path("a.petzval"), studio.path("a.exr.checkpoint")).expect("a part");
    for words in [EVEN.to_owned(), format!("{EVEN} --resume")] {
        studio.refuses(&words, "a.exr.checkpoint is a finished part of a picture");
    }
    assert_eq!(studio.names(), ["a.exr.checkpoint"], "it is still there");
}

#[cfg(unix)]
#[test]
fn what_came_through_a_pipe_is_known_again() {
    let studio = Studio::new();
    let made = Command::new("mkfifo").arg(studio.path("pipe.dat")).status();
    assert!(made.expect("mkfifo").success());
    let lens = std::fs::read_to_string(studio.path("lens.dat")).expect("a lens");
    let piped = |words: &str, lens: &str| {
        let child = studio.start(words);
        std::fs::write(studio.path("pipe.dat"), lens).expect("somebody who reads");
        said(child.wait_with_output().expect("a child"))
    };
    let words = "render scene.pbrt --spp 4 --resolution 24x16 --lens pipe.dat --checkpoint off";
    for i in [1, 2] {
        let (code, said) = piped(&format!("{words} --shard {i}/2 -o {i}.petzval"), &lens);
        assert_eq!(code, 0, "{said}");
    }
    let merge = "merge 1.petzval 2.petzval -o a.exr";
    let (code, said) = piped(merge, &format!("{lens}\n# another\n"));
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("pipe.dat has changed since"), "{said}");
    let (code, said) = piped(merge, &lens);
    assert_eq!(code, 0, "{said}");
}

/// What a command says that waits for nobody.
fn at_once(mut child: Child) -> (i32, String) {
    let begun = Instant::now();
    while child.try_wait().expect("a child").is_none() {
        if begun.elapsed() > Duration::from_secs(20) {
            child.kill().expect("a child");
            panic!("it waits for somebody to write");
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    said(child.wait_with_output().expect("a child"))
}

#[cfg(unix)]
#[test]
fn nobody_waits_for_a_pipe_in_place_of_a_checkpoint_or_a_texture() {
    let studio = Studio::new();
    for name in ["a.exr.checkpoint", "pipe.png"] {
        let made = Command::new("mkfifo").arg(studio.path(name)).status();
        assert!(made.expect("mkfifo").success());
    }
    let (code, said) = at_once(studio.start(&format!("{EVEN} --resume")));
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("a.exr.checkpoint: this is no checkpoint"), "{said}");
    let texture = r#"Texture "it" "spectrum" "imagemap" "string filename" "pipe.png""#;
    std::fs::write(studio.path("floor.pbrt"), texture).expect("a file");
    let (code, said) = at_once(studio.start("render scene.pbrt -o b.exr"));
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("pipe.png: it is a pipe or a device; expected a file"), "{said}");
}
