//! Merging parts of a picture, and the refusal of files that do not fit.

use std::time::Duration;

use crate::support::workspace::{Workspace, finish, forge_build, signal};

const RENDER: &str = "render scene.pbrt --spp 130 --effects +ghosts --resolution 48x32 \
                     --aov variance,depth,samples,object,dual_pixel,cryptomatte,motion";

/// Largest relative difference: sums in f64 differ by their order, f32 values by their last bit.
const ROUNDING: f64 = 1e-5;

#[test]
fn parts_in_any_order_give_the_picture_of_a_single_run() {
    let workspace = Workspace::new();
    workspace.run_ok(&format!("{RENDER} -o whole.exr"));
    for i in 1..=7 {
        workspace.run_ok(&format!("{RENDER} -o {i}.petzval --shard {i}/7"));
    }
    workspace.run_ok(
        "merge 3.petzval 1.petzval 7.petzval 2.petzval 6.petzval 5.petzval 4.petzval -o a.exr",
    );
    workspace.run_ok(
        "merge 1.petzval 2.petzval 3.petzval 4.petzval 5.petzval 6.petzval 7.petzval -o b.exr",
    );
    let [whole, a, b] = ["whole.exr", "a.exr", "b.exr"].map(|name| workspace.contents(name));
    assert_eq!(a, b, "the order of parts changes the picture");
    assert_eq!(a.attributes, whole.attributes);
    assert_eq!(a.channels.len(), 56);
    let off = a.difference(&whole);
    assert!(off < ROUNDING, "differs by {off:e}");
}

#[test]
fn a_merged_picture_is_finished_like_that_of_a_single_run() {
    let workspace = Workspace::new();
    let arguments = "render scene.pbrt --spp 32 --resolution 48x32 --crop 8,4,40,30 \
                 --effects +diffraction --sensor iso=800 --fstop 11";
    workspace.run_ok(&format!("{arguments} -o whole.png"));
    workspace.run_ok(&format!("{arguments} -o a.petzval --samples 0..9"));
    workspace.run_ok(&format!("{arguments} -o b.petzval --samples 9..32"));
    workspace.run_ok("merge b.petzval a.petzval -o merged.png");
    let [whole, merged] = ["whole.png", "merged.png"]
        .map(|name| petzval_image::Picture::read(&workspace.path(name)).expect("a picture"));
    assert_eq!(whole, merged);
}

#[test]
fn parts_that_do_not_fit_are_refused_and_named() {
    let workspace = Workspace::new();
    let part = |name: &str, more: &str| {
        workspace.run_ok(&format!(
            "render scene.pbrt --spp 20 --resolution 24x16 -o {name}.petzval {more}"
        ))
    };
    part("a", "--samples 0..8");
    part("b", "--samples 8..20");
    part("c", "--samples 6..12");
    part("seed", "--samples 8..20 --seed 9");
    part("stop", "--samples 8..20 --fstop 8");
    workspace.refuses("merge a.petzval -o x.exr", "samples 8..20 are missing");
    workspace.refuses("merge b.petzval -o x.exr", "samples 0..8 are missing");
    workspace.refuses(
        "merge a.petzval c.petzval -o x.exr",
        "a.petzval and c.petzval both hold samples 6..8; samples 12..20 are missing",
    );
    workspace.refuses("merge a.petzval a.petzval b.petzval -o x.exr", "both hold samples 0..8");
    workspace.refuses("merge a.petzval seed.petzval -o x.exr", "the seed was 0, and is 9 now");
    workspace
        .refuses("merge stop.petzval a.petzval -o x.exr", "--fstop was 8, and is not given now");
    assert!(!workspace.path("x.exr").exists());
    workspace.run_ok("merge a.petzval b.petzval -o x.exr");
    // All parts must be of one build; the build that merges them may be another.
    forge_build(&workspace.path("a.petzval"));
    workspace.refuses("merge a.petzval b.petzval -o x.exr", "begun by another build of petzval");
    forge_build(&workspace.path("b.petzval"));
    workspace.run_ok("merge a.petzval b.petzval -o x.exr");
    let text = std::fs::read_to_string(workspace.path("floor.pbrt")).expect("a text");
    std::fs::write(workspace.path("floor.pbrt"), text + "\n#").expect("a file");
    workspace.refuses("merge a.petzval b.petzval -o y.exr", "floor.pbrt has changed since");
    std::fs::remove_file(workspace.path("scene.pbrt")).expect("the scene");
    workspace.refuses("merge a.petzval b.petzval -o y.exr", "the parts were rendered by");
}

#[test]
fn options_that_give_no_part_are_refused() {
    let workspace = Workspace::new();
    let render = "render scene.pbrt --spp 4 --resolution 24x16";
    workspace.refuses(&format!("{render} --shard 1/2"), "a part of a picture needs a name");
    workspace.refuses(&format!("{render} --shard 1/2 -o a.exr"), "-o PART.petzval");
    workspace.refuses(&format!("{render} --shard 1/5 -o a.petzval"), "make no 5 shards");
    workspace.refuses(&format!("{render} --shard 0/2 -o a.petzval"), "expected I/N");
    workspace.refuses(&format!("{render} --samples 2..5 -o a.petzval"), "has 4 samples a pixel");
    workspace.refuses(&format!("{render} --samples 3..3 -o a.petzval"), "expected A..B");
    workspace.refuses(
        &format!("{render} --noise 0.1 --shard 1/2 -o a.petzval"),
        "--shard with --noise: how many samples a tile needs",
    );
    workspace.refuses(&format!("{render} -o a.petzval"), "known are .exr");
    assert!(workspace.file_names().is_empty());
}

#[test]
fn damaged_and_foreign_files_are_refused() {
    let workspace = Workspace::new();
    workspace.run_ok("render scene.pbrt --spp 4 --resolution 24x16 --shard 1/1 -o good.petzval");
    let good = std::fs::read(workspace.path("good.petzval")).expect("a part");
    let refuses = |bytes: &[u8], expected: &str| {
        std::fs::write(workspace.path("bad.petzval"), bytes).expect("a file");
        workspace.refuses("merge bad.petzval -o x.exr", expected);
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
    refuses(&[&good[..], b"more"].concat(), "data follow its end");
    for end in [1, 9, 13, 21, 200, good.len() / 2, good.len() - 1] {
        refuses(&good[..end], "bad.petzval: ");
    }
    workspace.refuses("merge . -o x.exr", "this is no checkpoint");
    workspace.refuses("merge none.petzval -o x.exr", "cannot read none.petzval");
    workspace.run_ok("merge good.petzval -o x.exr");
}

/// Returns a part with a changed head and a correct checksum.
fn rewritten(workspace: &Workspace, name: &str, old: &str, new: &str) -> Vec<u8> {
    let bytes = std::fs::read(workspace.path(name)).expect("a part");
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
fn a_head_that_does_not_match_its_body_is_refused() {
    let workspace = Workspace::new();
    let refuses = |old: &str, new: &str, expected: &str| {
        let bad = rewritten(&workspace, "a.petzval", old, new);
        std::fs::write(workspace.path("bad.petzval"), bad).expect("a file");
        workspace.refuses("merge bad.petzval -o x.exr", expected);
    };
    let arguments = "render scene.pbrt --resolution 24x16 -o a.petzval --samples 0..4";
    workspace.run_ok(&format!("{arguments} --spp 8"));
    refuses("[0,4,8]", "[0,8,8]", "it does not hold the samples that it names");
    workspace.run_ok(&format!("{arguments} --spp 4"));
    let foreign = "its counts of rays are not of this picture";
    let rows = format!(r#""blocked":[{}"#, "0,".repeat(40));
    refuses(r#""blocked":["#, &rows, foreign);
    refuses(r#""lens":["#, r#""lens":[0,0],"was":["#, foreign);
    assert!(!workspace.path("x.exr").exists());
}

#[cfg(target_os = "linux")]
#[test]
fn an_unfinished_shard_can_be_resumed_but_not_merged() {
    let workspace = Workspace::new();
    let arguments = "render scene.pbrt --spp 3000 --shard 1/2 -o a.petzval --checkpoint 2ms";
    let mut child = workspace.start(arguments);
    workspace.wait_for_file(&mut child, "a.petzval.checkpoint", 0);
    signal(&child, "TERM");
    let (code, stderr) = finish(child);
    assert_eq!(code, 130, "{stderr}");
    assert_eq!(workspace.file_names(), ["a.petzval.checkpoint"]);
    workspace.refuses("merge a.petzval.checkpoint -o x.exr", "is not finished; continue with");
    workspace.refuses(
        &format!("{} --resume", arguments.replace("1/2", "1/3")),
        "its samples are 0..1500, and these 0..1000",
    );
}

/// Parts are added one after another, so memory does not depend on their number.
#[cfg(target_os = "linux")]
#[test]
fn a_thousand_parts_are_merged_in_little_memory() {
    let workspace = Workspace::new();
    let arguments = "render scene.pbrt --spp 1000 --resolution 48x32 --threads 1 --effects none";
    // One part is rendered; the others are it, under other numbers.
    workspace.run_ok(&format!("{arguments} -o 0.petzval --samples 0..1"));
    let mut list = String::from("merge 0.petzval");
    for i in 1..1000 {
        let part =
            rewritten(&workspace, "0.petzval", "[0,1,1000]", &format!("[{i},{},1000]", i + 1));
        std::fs::write(workspace.path(&format!("{i}.petzval")), part).expect("a file");
        list += &format!(" {i}.petzval");
    }
    let mut child = workspace.start(&format!("{list} -o a.exr"));
    let status = std::path::PathBuf::from(format!("/proc/{}/status", child.id()));
    let mut peak = 0;
    while child.try_wait().expect("a child").is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|line| line.strip_prefix("VmHWM:"));
        let kib = line.and_then(|line| line.trim().trim_end_matches(" kB").parse().ok());
        peak = peak.max(kib.unwrap_or(0));
        std::thread::sleep(Duration::from_millis(1));
    }
    let (code, stderr) = finish(child);
    assert_eq!(code, 0, "{stderr}");
    println!("{} KiB at most", peak);
    assert!(0 < peak && peak < 300 * 1024, "{peak} KiB");
    workspace
        .run_ok("render scene.pbrt --spp 1 --resolution 48x32 --threads 1 --effects none -o b.exr");
    let [merged, one] = ["a.exr", "b.exr"].map(|name| workspace.contents(name));
    assert!(
        merged.difference(&one) < ROUNDING,
        "the mean of a thousand equal parts differs from one of them"
    );
}
