//! The manual: its commands run, its links have targets, its options exist, its pages are short.
#![cfg(unix)]

use std::collections::BTreeSet;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::Command;

use crate::support::{folder, in_parallel, petzval, root, write};

/// Commands of the manual that the test does not run, with the reason.
const NOT_RUN: [(&str, &str); 44] = [
    ("petzval view scenes/atelier.pbrt", "waits for Ctrl-C; tests/view runs it"),
    (
        "petzval lens mine.toml --catalogue SCHOTT_OLD.AGF --catalogue catalogues/",
        "needs the catalogue of a maker",
    ),
    (
        "petzval render scenes/atelier.pbrt -o atelier.exr --spp 16 --denoise",
        "needs Open Image Denoise; tests/command/denoise.rs has programs in its place",
    ),
    (
        "petzval render scenes/atelier.pbrt -o atelier.png --spp 16 \
         --denoise=/opt/oidn/bin/oidnDenoise",
        "needs Open Image Denoise",
    ),
    (
        "petzval measure photo.png --edge 400,300,500,400",
        "needs a chart; tests/command/measure.rs has one",
    ),
    (
        "petzval measure photo.png --edge 400,300,500,400 --edge 20,40,120,140 --pixel 4.5 --csv sfr.csv",
        "needs a chart; tests/command/measure.rs has one",
    ),
    (
        "petzval measure photo.png --edge 400,300,500,400 --channel green --json",
        "needs a chart; tests/command/measure.rs has one",
    ),
    (
        "petzval chart edges lenses/dgauss.50mm.dat --film-size 36x24 --resolution 900x600 --focus 2m --fstop 8 \
         -o edges.pbrt",
        "needs more pixels than this test gives; tests/command/measure.rs draws it",
    ),
    (
        "petzval chart grid lenses/dgauss.50mm.dat --film-size 36x24 --resolution 900x600 --focus 2m --fstop 8 \
         -o grid.pbrt",
        "needs more pixels than this test gives; tests/command/measure.rs draws it",
    ),
    (
        "petzval chart leaves lenses/dgauss.50mm.dat --film-size 36x24 --resolution 900x600 --focus 2m --fstop 8 \
         -o leaves.pbrt",
        "needs more pixels than this test gives; tests/command/measure.rs draws it",
    ),
    (
        "petzval measure texture leaves.exr --region 300,150,600,450 --chart leaves.png --second again.exr",
        "needs pictures; tests/command/measure.rs renders them",
    ),
    (
        "petzval chart colours lenses/dgauss.50mm.dat --film-size 36x24 --resolution 900x600 --focus 2m --fstop 8 \
         -o colours.pbrt",
        "needs more pixels than this test gives; tests/command/colours.rs draws it",
    ),
    (
        "petzval measure colours colours.exr --region 90,62,810,537 --flat flat.exr",
        "needs pictures; tests/command/colours.rs renders them",
    ),
    (
        "petzval chart star lenses/dgauss.50mm.dat --film-size 36x24 --resolution 900x600 --focus 2m --fstop 8 \
         -o star.pbrt",
        "needs more pixels than this test gives; tests/command/charts.rs draws it",
    ),
    (
        "petzval chart greys lenses/dgauss.50mm.dat --film-size 36x24 --resolution 900x600 --focus 2m --fstop 8 \
         -o greys.pbrt",
        "needs more pixels than this test gives; tests/command/charts.rs draws it",
    ),
    (
        "petzval measure star star.exr --region 250,100,650,500",
        "needs a picture; tests/command/charts.rs renders it",
    ),
    (
        "petzval measure greys greys.exr --region 148,60,752,540 --flat flat.exr",
        "needs pictures; tests/command/charts.rs renders them",
    ),
    ("petzval measure shading flat.exr", "needs a picture; tests/command/charts.rs renders it"),
    ("petzval measure grid grid.exr", "needs a picture; tests/command/measure.rs renders it"),
    (
        "petzval measure grid grid.exr --csv dots.csv --json",
        "needs a picture; tests/command/measure.rs renders it",
    ),
    ("petzval measure noise list.txt", "needs pictures; tests/command/measure.rs has them"),
    (
        "petzval measure noise list.txt --csv curve.csv --json",
        "needs pictures; tests/command/measure.rs has them",
    ),
    ("cargo test --release", "runs this test"),
    ("RUSTFLAGS=\"-C target-cpu=x86-64\" cargo build --release", "compiles; .ci/run does it"),
    ("cargo bench -- --save-baseline before", "takes many minutes"),
    ("cargo bench -- --baseline before", "takes many minutes"),
    ("cargo bench --bench variance", "takes minutes"),
    ("cargo bench --bench cluster", "takes minutes"),
    ("petzval render scenes/night.pbrt", "diffraction takes ten seconds at any size"),
    ("petzval bench", "takes ten seconds; tests/command/bench.rs runs it"),
    ("petzval bench --json", "takes ten seconds; tests/command/bench.rs runs it"),
    (
        "hyperfine 'target/release/petzval render scenes/dgauss.pbrt --spp 512 -o out.exr'",
        "needs hyperfine",
    ),
    ("python3 benches/conformance/conformance.py --pbrt pbrt", "needs pbrt-v4"),
    ("python3 benches/spectral/colours.py --pbrt pbrt", "needs pbrt-v4"),
    ("python3 benches/spectral/buckets.py --pbrt pbrt", "needs pbrt-v4"),
    ("python3 benches/spectral/cost.py", "takes minutes"),
    ("python3 benches/spectral/cornell.py", "takes half a minute"),
    (
        "python3 benches/scoreboard/scoreboard.py",
        "takes hours, and renderers that are not installed",
    ),
    (
        "scenes/slurm/submit.sh scenes/atelier.pbrt 100 atelier.exr --spp 4096",
        "needs Slurm; tests/command/slurm.rs runs it",
    ),
    ("squeue", "needs Slurm"),
    ("cargo test --release --test command slurm:: -- --ignored --nocapture", "needs Slurm"),
    (
        "sh -c 'i=$((JOB_COMPLETION_INDEX + 1)); exec petzval render s.pbrt --shard $i/100 \
         -o parts/$i.petzval --resume'",
        "needs Kubernetes",
    ),
    (
        "petzval render s.pbrt --shard #IFRAME#/100 -o parts/#IFRAME#.petzval --resume",
        "needs OpenCue",
    ),
    ("petzval merge parts/*.petzval -o s.exr", "needs the parts of a cluster's nodes"),
];

/// Option values that replace those of the manual, so that each command ends within two seconds.
const SMALL: [(&str, &str); 7] = [
    ("--resolution", "24x16"),
    ("--spp", "4"),
    ("--noise", "1"),
    ("--time", "0.1s"),
    ("--budget", "20s"),
    ("--crop", "2,3,20,12"),
    ("--pixel", "5,7"),
];

/// Options of other tools that the manual names.
const FOREIGN: [&str; 17] = [
    "--array",
    "--requeue",
    "--wrap",
    "--release",
    "--test",
    "--bench",
    "--nocapture",
    "--ignored",
    "--save-baseline",
    "--baseline",
    "--features",
    "--upgrade",
    "--pbrt",
    "--hdr",
    "--alb",
    "--nrm",
    "--clean",
];

/// A page of the manual.
struct Page {
    name: String,
    text: String,
}

fn page(name: &str) -> Page {
    let text = fs::read_to_string(root().join(name)).expect("a page");
    Page { name: name.to_owned(), text }
}

/// Reads the README and all pages of docs.
fn pages() -> Vec<Page> {
    let docs = fs::read_dir(root().join("docs")).expect("the manual");
    let docs = docs.map(|entry| entry.expect("an entry").file_name().into_string().expect("text"));
    let mut names: Vec<String> = docs.filter(|name| name.ends_with(".md")).collect();
    names.sort();
    let docs = names.iter().map(|name| page(&format!("docs/{name}")));
    [page("README.md")].into_iter().chain(docs).collect()
}

/// Returns the lines of the fenced blocks of one language.
fn blocks<'a>(text: &'a str, language: &str) -> Vec<Vec<&'a str>> {
    let (mut blocks, mut open) = (Vec::new(), None::<(bool, Vec<&str>)>);
    for line in text.lines() {
        open = match (line.strip_prefix("```"), open) {
            (Some(name), None) => Some((name == language, Vec::new())),
            (Some(_), Some((wanted, block))) => {
                blocks.extend(wanted.then_some(block));
                None
            }
            (None, Some((wanted, mut block))) => {
                block.push(line);
                Some((wanted, block))
            }
            (None, None) => None,
        };
    }
    assert!(open.is_none(), "a fence is not closed");
    blocks
}

/// Returns the commands of a page, one per line.
fn commands(page: &Page) -> Vec<String> {
    let text = page.text.replace("\\\n", " ");
    let lines = blocks(&text, "sh").into_iter().flatten().map(str::trim);
    lines.filter(|line| !line.is_empty() && !line.starts_with('#')).map(str::to_owned).collect()
}

/// Returns a command as a call of an installed petzval, if it is one and is not listed.
fn petzval_call(command: &str) -> Option<String> {
    if NOT_RUN.iter().any(|(listed, _)| *listed == command) {
        return None;
    }
    let command = command.replace("cargo run --release -- ", "petzval ");
    let body = command.split_once("; do ").map_or(command.as_str(), |(_, body)| body);
    body.starts_with("petzval ").then_some(command)
}

/// Returns the arguments of each call of petzval in a command, expanded by the shell.
fn arguments(at: &Path, command: &str) -> Vec<Vec<String>> {
    let script = format!("petzval() {{ printf '%s\\037' \"$@\"; echo; }}\n{command}");
    let output = Command::new("sh").args(["-c", &script]).current_dir(at).output();
    let output = output.expect("a shell");
    assert!(output.status.success(), "{command}");
    let text = String::from_utf8(output.stdout).expect("text");
    let calls = text.lines().map(|line| line.split_terminator('\u{1f}'));
    calls.map(|call| call.map(str::to_owned).collect()).collect()
}

/// Returns a call with a small picture and a short budget.
fn small(mut call: Vec<String>) -> Vec<String> {
    for i in 1..call.len() {
        if let Some((_, value)) = SMALL.iter().find(|(option, _)| *option == call[i - 1]) {
            call[i] = (*value).to_owned();
        } else if call[i].starts_with("auto@") {
            call[i] = "auto@12,8".to_owned();
        } else if call[i - 1] == "--sweep" {
            call[i] = call[i].replace(":8", ":2");
        }
    }
    if call[0] == "dataset" {
        // The recipes are run by tests/command/dataset.rs.
        call.push("--dry-run".to_owned());
    }
    let has = |option: &str| call.iter().any(|word| word == option);
    let takes = |commands: &[&str]| commands.contains(&call[0].as_str());
    let size = takes(&["render", "replay", "plan", "accuracy"]) && !has("--resolution");
    let samples = takes(&["render", "accuracy"]) && !has("--spp") && !has("--samples");
    let more = [(size, SMALL[0]), (samples, SMALL[1])];
    for (_, (option, value)) in more.into_iter().filter(|(missing, _)| *missing) {
        call.extend([option.to_owned(), value.to_owned()]);
    }
    call
}

/// Creates a folder with the files that the commands of a page use.
fn folder_for(user: &Page) -> tempfile::TempDir {
    let folder = folder();
    for name in ["scenes", "lenses"] {
        symlink(root().join(name), folder.path().join(name)).expect("a link");
    }
    let language = page("docs/scene-language.md");
    let example = blocks(&language.text, "text").swap_remove(0).join("\n");
    write(&folder, "scene.pbrt", example);
    write(&folder, "rays.csv", "x,y,z,dx,dy,dz\n0,0,8,0,0,-1\n");
    let pictures = ["out.exr", "reference.exr"];
    for name in pictures.into_iter().filter(|_| user.text.contains("reference.exr")) {
        run(folder.path(), &format!("petzval render scene.pbrt -o {name}")).expect("a picture");
    }
    folder
}

/// Runs a command of the manual. Returns an error if it fails.
fn run(at: &Path, command: &str) -> Result<(), String> {
    for call in arguments(at, command).into_iter().map(small) {
        let call: Vec<&str> = call.iter().map(String::as_str).collect();
        let (code, _, stderr) = petzval(at, &call);
        if code != 0 {
            return Err(format!("{command}\nwas run as petzval {}\n{stderr}", call.join(" ")));
        }
    }
    Ok(())
}

#[test]
fn every_command_of_the_manual_runs() {
    let pages = pages();
    let failures = in_parallel(&pages, |page| {
        let commands = commands(page);
        let calls: Vec<String> = commands.iter().filter_map(|line| petzval_call(line)).collect();
        // Pages without commands need no files.
        let folder = (!calls.is_empty()).then(|| folder_for(page));
        let runs = folder.iter().flat_map(|at| calls.iter().map(|call| run(at.path(), call)));
        let failures = runs.filter_map(Result::err);
        failures.map(|failure| format!("{}: {failure}", page.name)).collect::<Vec<String>>()
    });
    let failures = failures.concat();
    assert!(failures.is_empty(), "{}", failures.join("\n"));
}

#[test]
fn a_command_that_is_not_run_is_listed_with_a_reason() {
    let pages = pages();
    let all: BTreeSet<String> = pages.iter().flat_map(commands).collect();
    for command in &all {
        let listed = NOT_RUN.iter().any(|(listed, _)| listed == command);
        assert!(listed || petzval_call(command).is_some(), "neither run nor listed: {command}");
    }
    for (listed, _) in NOT_RUN {
        assert!(all.contains(listed), "listed, but no longer in the manual: {listed}");
    }
}

#[test]
fn pages_are_short() {
    for page in pages() {
        let most = if page.name == "README.md" { 160 } else { 249 };
        let lines = page.text.lines().count();
        assert!(lines <= most, "{} has {lines} lines, of at most {most}", page.name);
    }
}

/// Returns the targets of the links and pictures of a page.
fn links(text: &str) -> impl Iterator<Item = &str> {
    text.split("](").skip(1).filter_map(|rest| rest.split(')').next())
}

/// Returns the anchors that GitHub makes of headings.
fn anchors(text: &str) -> Vec<String> {
    let headings = text.lines().filter(|line| line.starts_with('#'));
    let slug = |heading: &str| {
        let kept = heading.trim_start_matches('#').trim().to_lowercase();
        let kept = kept.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c));
        kept.map(|c| if c == ' ' { '-' } else { c }).collect()
    };
    headings.map(slug).collect()
}

#[test]
fn every_link_has_a_target() {
    for page in pages() {
        let path = root().join(&page.name);
        for link in links(&page.text).filter(|link| !link.starts_with("https://")) {
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() { path.clone() } else { path.with_file_name(file) };
            assert!(target.is_file(), "{}: {link} is no file", page.name);
            if !anchor.is_empty() {
                let text = fs::read_to_string(&target).expect("a page");
                let found = anchors(&text).iter().any(|heading| heading == anchor);
                assert!(found, "{}: {link} is no heading", page.name);
            }
        }
    }
}

#[test]
fn the_readme_links_to_every_page() {
    let readme = page("README.md");
    for page in pages().iter().skip(1) {
        assert!(links(&readme.text).any(|link| link == page.name), "{}", page.name);
    }
}

#[test]
fn every_test_and_bench_that_the_manual_names_exists() {
    for page in pages() {
        let words: Vec<&str> = page.text.split_whitespace().collect();
        for (i, word) in words.iter().enumerate() {
            let option = word.trim_start_matches(['`', '(']);
            let end = |c: char| !c.is_ascii_lowercase() && c != '_';
            let following = |n: usize| words.get(i + n).copied().unwrap_or_default();
            let name = following(1).split(end).next().unwrap_or_default();
            let folder = match option {
                "--test" => "tests",
                "--bench" => "benches",
                _ => continue,
            };
            let mut places =
                vec![format!("{folder}/{name}.rs"), format!("{folder}/{name}/main.rs")];
            // A part of an executable: `--test ROOM NAME::`.
            if let (true, Some((part, _))) = (option == "--test", following(2).split_once("::")) {
                places = vec![
                    format!("{folder}/{name}/{part}.rs"),
                    format!("{folder}/{name}/{part}/mod.rs"),
                ];
            }
            let found = places.iter().any(|place| root().join(place).is_file());
            let general = ["NAME", "ROOM"].iter().any(|word| following(1).starts_with(word));
            assert!(found || general, "{}: {option} {name}: no {places:?}", page.name);
        }
    }
}

/// Returns the long options in a text.
fn options(text: &str) -> BTreeSet<String> {
    let words = text.split(|c: char| !c.is_ascii_lowercase() && c != '-');
    let letter = |c: char| c.is_ascii_lowercase();
    words
        .filter(|w| w.strip_prefix("--").is_some_and(|w| w.starts_with(letter)))
        .map(String::from)
        .collect()
}

#[test]
fn the_manual_describes_every_option_and_no_other() {
    let mut known = BTreeSet::new();
    for command in [
        "render",
        "merge",
        "lens",
        "lens trace",
        "lens calibrate",
        "lens depth-of-field",
        "lens report",
        "lens tolerance",
        "lens optimize",
        "replay",
        "view",
        "plan",
        "accuracy",
        "compare",
        "measure",
        "measure colours",
        "measure greys",
        "measure grid",
        "measure noise",
        "measure shading",
        "measure star",
        "measure texture",
        "develop",
        "chart",
        "dataset",
        "bench",
    ] {
        let words: Vec<&str> = command.split(' ').chain(["--help"]).collect();
        let (code, stdout, stderr) = petzval(root(), &words);
        assert_eq!(code, 0, "{stderr}");
        known.extend(options(&stdout));
    }
    known.remove("--help");
    let pages = pages();
    let told: BTreeSet<String> = pages.iter().flat_map(|page| options(&page.text)).collect();
    let undescribed: Vec<&String> = known.difference(&told).collect();
    assert!(undescribed.is_empty(), "options that the manual does not describe: {undescribed:?}");
    let foreign = FOREIGN.map(String::from);
    let unknown: Vec<&String> = told.difference(&known).filter(|o| !foreign.contains(o)).collect();
    assert!(unknown.is_empty(), "options that no command has: {unknown:?}");
}
