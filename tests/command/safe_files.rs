//! Output files are complete or absent, even on full and read-only disks.

use std::path::Path;
use std::process::{Command, Output};

use crate::support::workspace::{Workspace, exit_and_stderr, finish};

const RENDER: &str = "render scene.pbrt -o a.exr --spp 300 --effects none";

/// Runs the command with a limit on the size of files, KiB.
fn run_with_file_limit(workspace: &Workspace, kib: u32, arguments: &str) -> (i32, String) {
    let program = env!("CARGO_BIN_EXE_petzval");
    // With the signal ignored a write fails, as on a full disk.
    let script = format!("trap '' XFSZ; ulimit -f {kib}; exec '{program}' {arguments}");
    let output: Output = Command::new("bash")
        .args(["-c", &script])
        .current_dir(workspace.path(""))
        .output()
        .expect("bash starts");
    exit_and_stderr(output)
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_too_small_for_the_picture_leaves_the_old_one() {
    let workspace = Workspace::new();
    std::fs::write(workspace.path("a.exr"), "precious").expect("a file");
    std::fs::write(workspace.path("a.petzval"), "a part").expect("a file");
    for arguments in [RENDER.to_owned(), RENDER.replace("a.exr", "a.petzval --shard 1/2")] {
        let (code, stderr) = run_with_file_limit(&workspace, 8, &arguments);
        assert_eq!(code, 2, "{stderr}");
        assert!(stderr.contains("cannot write") && stderr.contains("File too large"), "{stderr}");
    }
    assert_eq!(std::fs::read(workspace.path("a.exr")).expect("a file"), b"precious");
    assert_eq!(std::fs::read(workspace.path("a.petzval")).expect("a file"), b"a part");
    assert_eq!(workspace.file_names(), ["a.exr", "a.petzval"], "nothing is left over");
}

#[cfg(target_os = "linux")]
#[test]
fn a_disk_too_small_for_a_checkpoint_does_not_stop_the_render() {
    let workspace = Workspace::new();
    workspace.run_ok(RENDER);
    let whole = workspace.contents("a.exr");
    // The picture is half as large as the checkpoint.
    let (code, stderr) = run_with_file_limit(&workspace, 64, &format!("{RENDER} --checkpoint 2ms"));
    assert_eq!(code, 0, "{stderr}");
    assert!(stderr.contains("cannot write a.exr.checkpoint: File too large"), "{stderr}");
    assert_eq!(workspace.contents("a.exr"), whole);
    assert_eq!(workspace.file_names(), ["a.exr"]);
}

/// A small disk in memory, mounted in a folder until it is dropped.
struct Disk<'a>(&'a Path);

impl<'a> Disk<'a> {
    fn mount(at: &'a Path, options: &str) -> Self {
        std::fs::create_dir(at).expect("a folder");
        let mut mount = Command::new("mount");
        mount.args(["-t", "tmpfs", "-o", options, "none"]).arg(at);
        let output = mount.output().expect("mount starts");
        let problem = String::from_utf8_lossy(&output.stderr);
        assert!(output.status.success(), "mount, which needs root: {problem}");
        Self(at)
    }
}

impl Drop for Disk<'_> {
    fn drop(&mut self) {
        let _ = Command::new("umount").arg(self.0).status();
    }
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "needs root, to mount a small disk; .ci/run runs it"]
fn a_full_disk_is_named_and_the_old_picture_stays() {
    let workspace = Workspace::new();
    let at = workspace.path("disk");
    let _disk = Disk::mount(&at, "size=64k");
    std::fs::write(at.join("a.exr"), vec![7; 40_000]).expect("a file");
    let arguments = RENDER.replace("a.exr", "disk/a.exr");
    workspace.refuses(&arguments, "cannot write the picture disk/a.exr: No space left");
    assert_eq!(std::fs::read(at.join("a.exr")).expect("a file"), vec![7; 40_000]);
    assert_eq!(std::fs::read_dir(&at).expect("the disk").count(), 1, "nothing is left over");
}

#[cfg(target_os = "linux")]
#[test]
#[ignore = "needs root, to mount a small disk; .ci/run runs it"]
fn a_read_only_disk_is_named_before_the_render() {
    let workspace = Workspace::new();
    let at = workspace.path("disk");
    let _disk = Disk::mount(&at, "ro,size=64k");
    workspace.refuses(&RENDER.replace("a.exr", "disk/a.exr"), "cannot write disk/a.exr: Read-only");
}

#[cfg(unix)]
#[test]
fn a_link_is_followed_and_kept() {
    use std::os::unix::fs::symlink;
    let workspace = Workspace::new();
    std::fs::create_dir(workspace.path("far")).expect("a folder");
    symlink("far/b.exr", workspace.path("a.exr")).expect("a link");
    workspace.run_ok(&RENDER.replace("300", "1"));
    assert!(workspace.path("a.exr").is_symlink());
    assert!(workspace.path("far/b.exr").is_file() && !workspace.path("far/b.exr").is_symlink());
    assert_eq!(workspace.file_names(), ["a.exr", "far"]);
    // The target of the link is checked before the render.
    assert!(Command::new("mkfifo").arg(workspace.path("pipe")).status().expect("mkfifo").success());
    for (to, problem) in [("gone/b.exr", "No such file"), ("pipe", "it is a pipe or a device")] {
        std::fs::remove_file(workspace.path("a.exr")).expect("the link");
        symlink(to, workspace.path("a.exr")).expect("a link");
        workspace.refuses(RENDER, &format!("cannot write a.exr: {problem}"));
    }
}

#[test]
fn a_folder_that_disappears_is_an_error_at_the_end() {
    let workspace = Workspace::new();
    std::fs::create_dir(workspace.path("sub")).expect("a folder");
    let arguments = RENDER.replace("a.exr", "sub/a.exr").replace("300", "3000");
    let mut child = workspace.start(&format!("{arguments} --checkpoint 50ms"));
    workspace.wait_for_file(&mut child, "sub/a.exr.checkpoint", 0);
    // A new checkpoint may appear while the files are removed.
    while std::fs::remove_dir_all(workspace.path("sub")).is_err() {}
    let (code, stderr) = finish(child);
    assert_eq!(code, 2, "{stderr}");
    assert!(stderr.contains("cannot write sub/a.exr.checkpoint"), "{stderr}");
    assert!(stderr.contains("cannot write the picture sub/a.exr"), "{stderr}");
    assert!(workspace.file_names().is_empty());
}
