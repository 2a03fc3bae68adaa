//! The universal executable of `.ci/universal`: the AVX2 program where the CPU has AVX2, else the portable one.
#![cfg(all(target_os = "linux", target_arch = "x86_64", target_feature = "avx2"))]

use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use crate::support::{folder, root};
use petzval_image::Picture;

fn universal() -> PathBuf {
    let path = root().join("target/universal/petzval");
    assert!(path.exists(), "run .ci/universal first: there is no {}", path.display());
    path
}

/// Renders a small picture. Returns what the command said, and the picture.
fn render(launcher: &[&str], program: &Path, out: &Path) -> (Output, Picture) {
    let mut words = launcher.iter().map(AsRef::as_ref).chain([program.as_os_str()]);
    let output = Command::new(words.next().expect("a program"))
        .args(words)
        .args(["render", "scenes/dgauss.pbrt", "--resolution", "40x30", "--spp", "8", "-o"])
        .arg(out)
        .current_dir(root())
        .output()
        .expect("the command starts");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    (output, Picture::read(out).expect("a picture"))
}

#[test]
#[ignore = "needs the file that .ci/universal makes, and qemu-x86_64; .ci/run runs it"]
fn each_cpu_runs_the_program_built_for_it() {
    let folder = folder();
    let path = |name: &str| folder.path().join(name);
    let (_, avx2) = render(&[], Path::new(env!("CARGO_BIN_EXE_petzval")), &path("avx2.exr"));
    let (said, fast) = render(&[], &universal(), &path("fast.exr"));
    assert!(!String::from_utf8_lossy(&said.stderr).contains("portable build"));
    let portable = root().join("target/portable/release/petzval");
    let (_, portable) = render(&[], &portable, &path("portable.exr"));
    let old = ["qemu-x86_64", "-cpu", "Nehalem"];
    let (said, slow) = render(&old, &universal(), &path("slow.exr"));
    // A faster build is of no use to an old CPU.
    assert!(!String::from_utf8_lossy(&said.stderr).contains("portable build"));
    assert!(fast.pixels == avx2.pixels, "not the AVX2 program's picture");
    assert!(slow.pixels == portable.pixels, "not the portable program's picture");
    assert!(fast.pixels != slow.pixels, "both programs round alike, so the test shows nothing");
}

#[test]
#[ignore = "needs the file that .ci/universal makes; .ci/run runs it"]
fn a_damaged_file_says_so_and_runs_the_portable_program() {
    let folder = folder();
    let damaged = folder.path().join("petzval");
    fs::copy(universal(), &damaged).expect("a copy");
    let mut bytes = fs::read(&damaged).expect("the copy");
    let digits = bytes.len() - 32;
    bytes[digits] = b'x';
    fs::write(&damaged, bytes).expect("the damaged copy");
    let output = Command::new(&damaged).arg("--version").output().expect("the command starts");
    let stderr = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{stderr}");
    assert!(stderr.contains("cannot start the AVX2 program"), "{stderr}");
    assert!(stderr.contains(".ci/universal"), "{stderr}");
}
