//! Files are whole or not there, whatever the disk does.

mod support;

use std::path::Path;
use std::process::{Command, Output};
use std::time::Duration;

use support::kept::{Studio, said};

const WORDS: &str = "render scene.pbrt -o a.exr --spp 300 --effects none";

/// Runs the command with files of at most so many KiB.
fn limited(studio: &Studio, kib: u32, words: &str) -> (i32, String) {
    let program = env!("CARGO_BIN_EXE_petzval");
    // Where the signal is ignored a write fails, as on a full disk.
    let script = format!("trap '' XFSZ; ulimit -f {kib}; exec '{program}' {words}");
    let output: Output = Command::new("bash")
        .args(["-c", &script])
        .current_dir(studio.path(""))
        .output()
        .expect("bash starts");
    said(output)
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_too_small_for_the_picture_leaves_the_old_one() {
    let studio = Studio::new();
    std::fs::write(studio.path("a.exr"), "precious").expect("a file");
    std::fs::write(studio.path("a.petzval"), "a part").expect("a file");
    for words in [WORDS.to_owned(), WORDS.replace("a.exr", "a.petzval --shard 1/2")] {
        let (code, said) = limited(&studio, 8, &words);
        assert_eq!(code, 2, "{said}");
        assert!(said.contains("cannot write") && said.contains("File too large"), "{said}");
    }
    assert_eq!(std::fs::read(studio.path("a.exr")).expect("a file"), b"precious");
    assert_eq!(std::fs::read(studio.path("a.petzval")).expect("a file"), b"a part");
    assert_eq!(studio.names(), ["a.exr", "a.petzval"], "nothing is left over");
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_too_small_for_a_checkpoint_does_not_cost_the_picture() {
    let studio = Studio::new();
    studio.done(WORDS);
    let whole = studio.contents("a.exr");
    // The picture takes half as much as the sums.
    let (code, said) = limited(&studio, 64, &format!("{WORDS} --checkpoint 2ms"));
    assert_eq!(code, 0, "{said}");
    assert!(said.contains("cannot write a.exr.checkpoint: File too large"), "{said}");
    assert_eq!(studio.contents("a.exr"), whole);
    assert_eq!(studio.names(), ["a.exr"]);
}

/// Mounts a small disk in a folder, for as long as it lives.
struct Disk<'a>(&'a Path);

impl<'a> Disk<'a> {
    fn mount(at: &'a Path, options: &str) -> Option<Self> {
        std::fs::create_dir(at).expect("a folder");
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", options, "none"]).arg(at);
        let mounted = mount.output().is_ok_and(|output| output.status.success());
        if !mounted {
            eprintln!("NOT TESTED: only root can mount a small disk");
        }
        mounted.then_some(Self(at))
    }
}

impl Drop for Disk<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0).status();
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_is_named_and_the_old_picture_stays() {
    let studio = Studio::new();
    let at = studio.path("disk");
    let Some(_disk) = Disk::mount(&at, "size=64k") else { return };
    std::fs::write(at.join("a.exr"), vec![7; 40_000]).expect("a file");
    let words = WORDS.replace("a.exr", "disk/a.exr");
    studio.refuses(&words, "cannot write the picture disk/a.exr: No space left");
    assert_eq!(std::fs::read(at.join("a.exr")).expect("a file"), vec![7; 40_000]);
    assert_eq!(std::fs::read_dir(&at).expect("the disk").count(), 1, "nothing is left over");
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_that_only_reads_is_named_before_the_render() {
    let studio = Studio::new();
    let at = studio.path("disk");
    let Some(_disk) = Disk::mount(&at, "ro,size=64k") else { return };
    studio.refuses(&WORDS.replace("a.exr", "disk/a.exr"), "cannot write disk/a.exr: Read-only");
}

#[cfg(unix)]
#[test]
fn a_link_is_followed_and_stays() {
    use std::os::unix::fs::symlink;
    let studio = Studio::new();
    std::fs::create_dir(studio.path("far")).expect("a folder");
    symlink("far/b.exr", studio.path("a.exr")).expect("a link");
    studio.done(&WORDS.replace("300", "1"));
    assert!(studio.path("a.exr").is_symlink());
    assert!(studio.path("far/b.exr").is_file() && !studio.path("far/b.exr").is_symlink());
    assert_eq!(studio.names(), ["a.exr", "far"]);
    // Where it goes is looked at before the render.
    assert!(Command::new("mkfifo").arg(studio.path("pipe")).status().expect("mkfifo").success());
    for (to, problem) in [("gone/b.exr", "No such file"), ("pipe", "it is a pipe or a device")] {
        std::fs::remove_file(studio.path("a.exr")).expect("the link");
        symlink(to, studio.path("a.exr")).expect("a link");
        studio.refuses(WORDS, &format!("cannot write a.exr: {problem}"));
    }
}

#[test]
fn a_folder_that_vanishes_is_an_error_at_the_end() {
    let studio = Studio::new();
    std::fs::create_dir(studio.path("sub")).expect("a folder");
    let words = WORDS.replace("a.exr", "sub/a.exr").replace("300", "3000");
    let child = studio.start(&format!("{words} --checkpoint 50ms"));
    std::thread::sleep(Duration::from_millis(400));
    // The next checkpoint may be on its way.
    while std::fs::remove_dir_all(studio.path("sub")).is_err() {}
    let (code, said) = said(child.wait_with_output().expect("a child"));
    assert_eq!(code, 2, "{said}");
    assert!(said.contains("cannot write sub/a.exr.checkpoint"), "{said}");
    assert!(said.contains("cannot write the picture sub/a.exr"), "{said}");
    assert!(studio.names().is_empty());
}
