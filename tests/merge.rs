//! Parts of a picture, rendered apart and added up; and what is no part.

mod support;

use std::process::Command;
use std::time::Duration;

use support::kept::Studio;

const WORDS: &str = "render scene.pbrt --spp 130 --effects +ghosts --resolution 48x32 \
                     --aov variance,depth,samples,object";

/// Sums in f64 differ by their order only, and single floats by their last bit.
const ROUNDING: f64 = 1e-5;

#[test]
fn parts_in_any_order_make_the_picture_of_a_single_run() {
    let studio = Studio::new();
    studio.done(&format!("{WORDS} -o whole.exr"));
    for i in 1..=7 {
        studio.done(&format!("{WORDS} -o {i}.petzval --shard {i}/7"));
    }
    studio.done(
        "merge 3.petzval 1.petzval 7.petzval 2.petzval 6.petzval 5.petzval 4.petzval -o a.exr",
    );
    studio.done(
        "merge 1.petzval 2.petzval 3.petzval 4.petzval 5.petzval 6.petzval 7.petzval -o b.exr",
    );
    let [whole, a, b] = ["whole.exr", "a.exr", "b.exr"].map(|name| studio.contents(name));
    assert_eq!(a, b, "order does not matter");
    assert_eq!(a.attributes, whole.attributes);
    assert_eq!(a.channels.len(), 12);
    let off = a.difference(&whole);
    assert!(off < ROUNDING, "off by {off:e}");
}

#[test]
fn the_end_of_a_picture_is_that_of_a_single_run() {
    let studio = Studio::new();
    let words = "render scene.pbrt --spp 32 --resolution 48x32 --crop 8,4,40,30 \
                 --effects +diffraction --sensor iso=800 --fstop 11";
    studio.done(&format!("{words} -o whole.png"));
    studio.done(&format!("{words} -o a.petzval --samples 0..9"));
    studio.done(&format!("{words} -o b.petzval --samples 9..32"));
    studio.done("merge b.petzval a.petzval -o merged.png");
    let [whole, merged] = ["whole.png", "merged.png"]
        .map(|name| petzval::image::Picture::read(&studio.path(name), false).expect("a picture"));
    assert_eq!(whole, merged);
}

#[test]
fn parts_that_do_not_fit_are_refused_and_named() {
    let studio = Studio::new();
    let part = |name: &str, more: &str| {
        studio.done(&format!(
            "render scene.pbrt --spp 20 --resolution 24x16 -o {name}.petzval {more}"
        ))
    };
    part("a", "--samples 0..8");
    part("b", "--samples 8..20");
    part("c", "--samples 6..12");
    part("seed", "--samples 8..20 --seed 9");
    part("stop", "--samples 8..20 --fstop 8");
    studio.refuses("merge a.petzval -o x.exr", "samples 8..20 are missing");
    studio.refuses("merge b.petzval -o x.exr", "samples 0..8 are missing");
    studio.refuses(
        "merge a.petzval c.petzval -o x.exr",
        "a.petzval and c.petzval both hold samples 6..8; samples 12..20 are missing",
    );
    studio.refuses("merge a.petzval a.petzval b.petzval -o x.exr", "both hold samples 0..8");
    studio.refuses("merge a.petzval seed.petzval -o x.exr", "the seed was 0, and is 9 now");
    studio.refuses("merge stop.petzval a.petzval -o x.exr", "--fstop was 8, and is not given now");
    assert!(!studio.path("x.exr").exists());
    studio.done("merge a.petzval b.petzval -o x.exr");
    let text = std::fs::read_to_string(studio.path("floor.pbrt")).expect("a text");
    std::fs::write(studio.path("floor.pbrt"), text + "\n#").expect("a file");
    studio.refuses("merge a.petzval b.petzval -o y.exr", "floor.pbrt has changed since");
    std::fs::remove_file(studio.path("scene.pbrt")).expect("the scene");
    studio.refuses("merge a.petzval b.petzval -o y.exr", "the parts were rendered by");
}

#[test]
fn what_makes_no_part_is_refused() {
    let studio = Studio::new();
    let render = "render scene.pbrt --spp 4 --resolution 24x16";
    studio.refuses(&format!("{render} --shard 1/2"), "a part of a picture needs a name");
    studio.refuses(&format!("{render} --shard 1/2 -o a.exr"), "-o PART.petzval");
    studio.refuses(&format!("{render} --shard 1/5 -o a.petzval"), "make no 5 shards");
    studio.refuses(&format!("{render} --shard 0/2 -o a.petzval"), "expected I/N");
    studio.refuses(&format!("{render} --samples 2..5 -o a.petzval"), "has 4 samples a pixel");
    studio.refuses(&format!("{render} --samples 3..3 -o a.petzval"), "expected A..B");
    studio.refuses(
        &format!("{render} --noise 0.1 --shard 1/2 -o a.petzval"),
        "--shard with --noise: how many samples a tile needs",
    );
    studio.refuses(&format!("{render} -o a.petzval"), "known are .exr");
    assert!(studio.names().is_empty());
}

#[test]
fn damaged_and_foreign_files_are_refused() {
    let studio = Studio::new();
    studio.done("render scene.pbrt --spp 4 --resolution 24x16 --shard 1/1 -o good.petzval");
    let good = std::fs::read(studio.path("good.petzval")).expect("a part");
    let refuses = |bytes: &[u8], expected: &str| {
        std::fs::write(studio.path("bad.petzval"), bytes).expect("a file");
        studio.refuses("merge bad.petzval -o x.exr", expected);
    };
    let changed = |at: usize, to: u8| {
        let mut bytes = good.clone();
        bytes[at] = to;
        bytes
    };
    refuses(b"", "this is no checkpoint");
    refuses(b"v/1\x01 an EXR, or whatever else", "this is no checkpoint");
    refuses(&changed(8, 3), "its format has version 3, and this petzval reads version 2");
    refuses(&changed(18, 1), "its head is longer than any");
    refuses(&changed(60, !good[60]), "the checksum of its head is wrong");
    refuses(&changed(good.len() - 900, !good[good.len() - 900]), "bad.petzval: it is damaged");
    refuses(&changed(good.len() - 1, !good[good.len() - 1]), "the checksum of its sums is wrong");
    refuses(&[&good[..], b"more"].concat(), "something behind its end");
    for end in [1, 9, 13, 21, 200, good.len() / 2, good.len() - 1] {
        refuses(&good[..end], "bad.petzval: ");
    }
    studio.refuses("merge . -o x.exr", "this is no checkpoint");
    studio.refuses("merge none.petzval -o x.exr", "cannot read none.petzval");
    studio.done("merge good.petzval -o x.exr");
}

/// A part with something else in its head, and a checksum that says nothing of it.
fn rewritten(studio: &Studio, name: &str, old: &str, new: &str) -> Vec<u8> {
    let bytes = std::fs::read(studio.path(name)).expect("a part");
    let length = u64::from_le_bytes(bytes[12..20].try_into().expect("a length")) as usize;
    let (head, rest) = (std::str::from_utf8(&bytes[20..20 + length]), &bytes[24 + length..]);
    let head = head.expect("JSON");
    assert!(head.contains(old), "{head}");
    let head = head.replace(old, new);
    let checksum = crc32fast::hash(head.as_bytes()).to_le_bytes();
    let length = (head.len() as u64).to_le_bytes();
    [&bytes[..12], &length, head.as_bytes(), &checksum, rest].concat()
}

#[test]
fn a_head_that_promises_what_is_not_there_is_refused() {
    let studio = Studio::new();
    let refuses = |old: &str, new: &str, expected: &str| {
        let bad = rewritten(&studio, "a.petzval", old, new);
        std::fs::write(studio.path("bad.petzval"), bad).expect("a file");
        studio.refuses("merge bad.petzval -o x.exr", expected);
    };
    let words = "render scene.pbrt --resolution 24x16 -o a.petzval --samples 0..4";
    studio.done(&format!("{words} --spp 8"));
    refuses("[0,4,8]", "[0,8,8]", "it does not hold the samples that it names");
    studio.done(&format!("{words} --spp 4"));
    let foreign = "its counts of rays are not of this picture";
    let rows = format!(r#""blocked":[{}"#, "0,".repeat(40));
    refuses(r#""blocked":["#, &rows, foreign);
    refuses(r#""lens":["#, r#""lens":[0,0],"was":["#, foreign);
    assert!(!studio.path("x.exr").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn an_interrupted_shard_goes_on_and_is_no_part_before() {
    let studio = Studio::new();
    let words = "render scene.pbrt --spp 3000 --shard 1/2 -o a.petzval --checkpoint 2ms";
    let child = studio.start(words);
    while !studio.path("a.petzval.checkpoint").exists() {
        std::thread::sleep(Duration::from_millis(1));
    }
    let kill = Command::new("kill").args(["-TERM", &child.id().to_string()]).status();
    assert!(kill.expect("kill").success());
    let (code, said) = support::kept::said(child.wait_with_output().expect("a child"));
    assert_eq!(code, 130, "{said}");
    assert_eq!(studio.names(), ["a.petzval.checkpoint"]);
    studio.refuses("merge a.petzval.checkpoint -o x.exr", "is not finished; go on with");
    studio.refuses(
        &format!("{} --resume", words.replace("1/2", "1/3")),
        "its samples are 0..1500, and these 0..1000",
    );
}

/// Parts are added one after another: memory does not depend on how many there are.
#[cfg(target_os = "linux")]
#[test]
fn a_thousand_parts_are_merged_in_little_memory() {
    let studio = Studio::new();
    let words = "render scene.pbrt --spp 1000 --resolution 48x32 --threads 1 --effects none";
    // One part is rendered; the others are it, under other numbers.
    studio.done(&format!("{words} -o 0.petzval --samples 0..1"));
    let mut list = String::from("merge 0.petzval");
    for i in 1..1000 {
        let part = rewritten(&studio, "0.petzval", "[0,1,1000]", &format!("[{i},{},1000]", i + 1));
        std::fs::write(studio.path(&format!("{i}.petzval")), part).expect("a file");
        list += &format!(" {i}.petzval");
    }
    let mut child = studio.start(&format!("{list} -o a.exr"));
    let status = std::path::PathBuf::from(format!("/proc/{}/status", child.id()));
    let mut peak = 0;
    while child.try_wait().expect("a child").is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok());
        peak = peak.max(kib.unwrap_or(0));
        std::thread::sleep(Duration::from_millis(1));
    }
    let (code, said) = support::kept::said(child.wait_with_output().expect("a child"));
    assert_eq!(code, 0, "{said}");
    println!("{} KiB at most", peak);
    assert!(0 < peak && peak < 300 * 1024, "{peak} KiB");
    studio.done("render scene.pbrt --spp 1 --resolution 48x32 --threads 1 --effects none -o b.exr");
    let [merged, one] = ["a.exr", "b.exr"].map(|name| studio.contents(name));
    assert!(merged.difference(&one) < ROUNDING, "the mean of a thousand equals is each of them");
}
