//! Corrupt input: readers survive the corpus of the fuzzers and thousands of mutations of it, in bounded
//! time and memory.

#[path = "fuzz/readers.rs"]
mod readers;
mod support;

use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};

use peak_alloc::PeakAlloc;
use readers::{READERS, Reader, accepted};
use support::{Random, root};

#[global_allocator]
static MEMORY: PeakAlloc = PeakAlloc;

/// Number of mutants for each reader.
const MUTANTS: usize = 5_000;
/// Maximum time for one input. Only a hang reaches it, even on a busy machine.
const LONGEST: Duration = Duration::from_secs(30);
/// Maximum memory of a reader, bytes: a constant, and a part per byte of input. A few bytes may name a
/// sphere, which is thousands of triangles, or unpack to a thousand times their size.
const MAX_MEMORY: [usize; 2] = [1 << 26, 4096];

/// Text that mutations insert: numbers at the ends of ranges, brackets, keywords of formats.
const WORDS: [&str; 42] = [
    "nan",
    "inf",
    "-inf",
    "1e308",
    "-1e308",
    "1e-320",
    "1e39",
    "0",
    "-0",
    "-1",
    "4294967295",
    "4294967296",
    "9223372036854775807",
    "99999999999999999999999",
    "0.1",
    "1e10",
    "[",
    "]",
    "\"",
    "\"\"",
    "#",
    "\n",
    "\u{e9}",
    "\u{1f4f7}",
    "{",
    "}",
    "= [",
    "[[surface]]",
    "Include \"scene.pbrt\"",
    "Include \"/dev/zero\"",
    "ObjectInstance \"it\"",
    "ObjectBegin \"it\"",
    "ObjectEnd",
    "AttributeBegin",
    "AttributeEnd",
    "WorldBegin",
    "Scale 0 1 1",
    "\"integer levels\" 30",
    "\"float radius\"",
    "element vertex 4000000000",
    "property list uint int vertex_indices",
    "end_header",
];

/// Returns a file of the corpus with one to four random changes.
fn mutant(random: &mut Random, corpus: &[Vec<u8>]) -> Vec<u8> {
    let mut pick = |below: usize| ((random.next() * below as f64) as usize).min(below.max(1) - 1);
    let mut bytes = corpus[pick(corpus.len())].clone();
    for _ in 0..1 + pick(4) {
        let at = pick(bytes.len());
        let end = (at + 1 + pick(16)).min(bytes.len());
        match pick(7) {
            0 if !bytes.is_empty() => bytes[at] = pick(256) as u8,
            1 if !bytes.is_empty() => bytes[at] ^= 1 << pick(8),
            2 => drop(bytes.drain(at..end)),
            3 => {
                let part = bytes[at..end].to_vec();
                let to = pick(bytes.len());
                bytes.splice(to..to, part);
            }
            4 => {
                let other = &corpus[pick(corpus.len())];
                let from = pick(other.len());
                bytes.truncate(at);
                bytes.extend_from_slice(&other[from..]);
            }
            5 => bytes.truncate(at),
            _ => {
                let word = format!(" {} ", WORDS[pick(WORDS.len())]);
                bytes.splice(at..if pick(2) == 0 { at } else { end }, word.into_bytes());
            }
        }
    }
    bytes
}

/// Reads one input. Saves it and panics if the reader needs too much time or memory.
fn feed(folder: &Path, (name, read): (&str, Reader), bytes: &[u8]) {
    MEMORY.reset_peak_usage();
    let (before, start) = (MEMORY.current_usage(), Instant::now());
    read(folder, bytes);
    let memory = MEMORY.peak_usage().saturating_sub(before);
    let most = MAX_MEMORY[0] + MAX_MEMORY[1] * bytes.len();
    let kept = folder.join("too-much");
    let keep = || fs::write(&kept, bytes).expect("a file in the folder of a test");
    if memory > most || start.elapsed() > LONGEST {
        keep();
        let text = String::from_utf8_lossy(bytes);
        panic!("{name}: {memory} bytes, {:?}: {text:.2000}", start.elapsed());
    }
}

fn files(folder: &Path) -> Vec<Vec<u8>> {
    let mut paths: Vec<_> = fs::read_dir(folder)
        .expect("a corpus")
        .map(|entry| entry.expect("an entry of the corpus").path())
        .collect();
    paths.sort();
    paths.iter().map(|path| fs::read(path).expect("a file of the corpus")).collect()
}

/// Creates a folder with the files that scenes of the corpus name.
fn surroundings() -> tempfile::TempDir {
    let folder = support::folder();
    let corpus = root().join("tests/fuzz/corpus");
    for (from, to) in [
        ("ply/ascii.ply", "mesh.ply"),
        ("image/rgb.png", "sky.png"),
        ("lens/spheres.dat", "lens.dat"),
    ] {
        fs::copy(corpus.join(from), folder.path().join(to)).expect("a file of the corpus");
    }
    support::write(&folder, "part.pbrt", "AttributeBegin Shape \"sphere\" AttributeEnd");
    folder
}

/// A single test, since the peak of memory is that of the process.
#[test]
fn readers_survive_corrupt_input_within_time_and_memory() {
    for (name, read) in READERS {
        let folder = surroundings();
        let corpus = files(&root().join("tests/fuzz/corpus").join(name));
        assert!(corpus.len() >= 3, "{name}: {} files", corpus.len());
        for bytes in &corpus {
            feed(folder.path(), (name, read), bytes);
        }
        let mut random = Random::new(2026);
        let start = Instant::now();
        for _ in 0..MUTANTS {
            feed(folder.path(), (name, read), &mutant(&mut random, &corpus));
        }
        println!("{name}: {MUTANTS} mutants in {:?}", start.elapsed());
    }
    checkpoints_of_the_corpus_are_of_the_present_format();
}

/// Checkpoints of another version would only test the comparison of versions.
fn checkpoints_of_the_corpus_are_of_the_present_format() {
    let folder = support::folder();
    let corpus = root().join("tests/fuzz/corpus/checkpoint");
    let takers = ["part.petzval", "even.exr.checkpoint", "adaptive.exr.checkpoint"];
    for (taker, name) in takers.into_iter().enumerate() {
        let bytes = fs::read(corpus.join(name)).expect("a file of the corpus");
        let taken = accepted(folder.path(), &bytes);
        assert!(taken[taker], "{name} is of another version; readers.rs says how to write it anew");
    }
}
