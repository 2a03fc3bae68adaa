//! References: results of slow computations, kept in `tests/references`.
//!
//! The fast tier reads them. The full tier, `PETZVAL_FULL=1`, computes each again and compares it with the
//! file. `PETZVAL_FULL=write` adds those that the file lacks. A row holds the hash of what was computed (a
//! world, a lens, a depth), a label for readers, and the numbers.

use std::fmt::Debug;
use std::fs::{File, OpenOptions};
use std::io::{Read, Seek, Write};

use super::root;

/// Returns whether this is a run of the full tier.
pub fn full() -> bool {
    std::env::var_os("PETZVAL_FULL").is_some()
}

/// Returns whether this run adds missing rows: `PETZVAL_FULL=write`.
fn writes() -> bool {
    std::env::var("PETZVAL_FULL").is_ok_and(|value| value == "write")
}

/// Returns `fast` in the fast tier, and `full` in the full one.
pub fn by_tier<T>(fast: T, full_value: T) -> T {
    if full() { full_value } else { fast }
}

/// Returns the numbers that `compute` gives for `subject`, from the rows of `tests/references/FILE.csv`.
/// The full tier computes them again, and `same` tells whether stored and computed ones agree.
pub fn reference(
    file: &str,
    label: &str,
    subject: impl Debug,
    same: impl FnOnce(&[f64], &[f64]) -> bool,
    compute: impl FnOnce() -> Vec<f64>,
) -> Vec<f64> {
    let hash = format!("{:016x}", hash(format!("{subject:?}").as_bytes()));
    let path = root().join("tests/references").join(file).with_extension("csv");
    let stored = std::fs::read_to_string(&path).ok().and_then(|text| row(&text, &hash));
    if !full() {
        return stored.unwrap_or_else(|| {
            panic!(
                "{file}: {label}: no row {hash} in {}: this world is new or has changed. Run this test with \
                 PETZVAL_FULL=write to add the row, and remove the old one",
                path.display()
            )
        });
    }
    let found = compute();
    match stored {
        Some(stored) => assert!(
            stored.len() == found.len() && same(&stored, &found),
            "{file}: {label}: the row {hash} holds {stored:?}, computed are {found:?}"
        ),
        None if writes() => {
            let values: Vec<String> = found.iter().map(|value| format!("{value:e}")).collect();
            let line = format!("{hash},{},{}\n", label.replace(',', ";"), values.join(","));
            add(&path, line).expect("a file of references");
        }
        None => panic!("{file}: {label}: no row {hash}: PETZVAL_FULL=write adds it"),
    }
    found
}

/// Returns a test of whether numbers differ by at most a share of the largest one.
pub fn within(share: f64) -> impl FnOnce(&[f64], &[f64]) -> bool {
    move |stored, found| {
        let most = stored.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
        stored.iter().zip(found).all(|(a, b)| (a - b).abs() <= share * most)
    }
}

/// Returns a test of whether pairs of a mean and its standard error agree to a number of errors.
pub fn means_agree(errors: f64) -> impl FnOnce(&[f64], &[f64]) -> bool {
    move |stored, found| {
        let pairs = stored.as_chunks::<2>().0.iter().zip(found.as_chunks::<2>().0);
        pairs.into_iter().all(|(a, b)| (a[0] - b[0]).abs() <= errors * a[1].hypot(b[1]))
    }
}

/// Returns the numbers of the row of a hash.
fn row(text: &str, hash: &str) -> Option<Vec<f64>> {
    let row = text.lines().find(|line| line.starts_with(hash))?;
    Some(row.split(',').skip(2).map(|value| value.parse().expect("a number")).collect())
}

/// Adds a line to a file, whose lines are in the order of their labels. Other tests wait meanwhile.
fn add(path: &std::path::Path, line: String) -> std::io::Result<()> {
    let mut file: File =
        OpenOptions::new().read(true).write(true).create(true).truncate(false).open(path)?;
    file.lock()?;
    let mut text = String::new();
    file.read_to_string(&mut text)?;
    let mut lines: Vec<&str> = text.lines().chain([line.trim_end()]).collect();
    lines.sort_by_key(|line| line.split(',').nth(1));
    let text = lines.join("\n") + "\n";
    file.rewind()?;
    file.set_len(0)?;
    file.write_all(text.as_bytes())
}

/// FNV-1a of 64 bits.
fn hash(bytes: &[u8]) -> u64 {
    bytes.iter().fold(0xcbf2_9ce4_8422_2325, |hash, byte| {
        (hash ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3)
    })
}

/// Returns the fields of a structure that differ from those of another, as text. Rows of a subject that
/// names these alone stay when the structure gets a field.
pub fn changed_fields<T: Debug>(value: &T, default: &T) -> String {
    let fields = |value: &T| -> Vec<String> {
        let text = format!("{value:#?}");
        // A field starts with four spaces; its own lines have more, or close a bracket.
        let starts =
            |line: &str| line.starts_with("    ") && line[4..].starts_with(char::is_alphabetic);
        text.lines().fold(Vec::new(), |mut fields: Vec<String>, line| {
            match fields.last_mut() {
                Some(field) if !starts(line) => *field += line.trim_start(),
                _ => fields.push(line.trim_start().to_owned()),
            }
            fields
        })
    };
    let usual = fields(default);
    fields(value).into_iter().filter(|field| !usual.contains(field)).collect()
}
