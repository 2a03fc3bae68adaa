#![no_main]

#[allow(dead_code, reason = "each fuzzer uses one reader")]
#[path = "../readers.rs"]
mod readers;

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| tempfile::tempdir().expect("a folder"));

fuzz_target!(|bytes: &[u8]| readers::glass(FOLDER.path(), bytes));
