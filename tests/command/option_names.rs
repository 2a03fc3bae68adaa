//! Names of settings in messages of the library.

use std::fs;
use std::path::{Path, PathBuf};

use crate::support::root;

/// Texts that hold options of other programs.
const OPTIONS_OF_OTHERS: [&str; 1] = ["nanovdb_convert --zip"];

/// Messages of the library reach Rust and Python too, where no setting has dashes before its name: they
/// name it in single quotes, and the command translates that.
#[test]
fn options_of_the_command_are_named_by_the_command_alone() {
    // The pages of `report` are those of the command.
    let of_the_command =
        ["cli", "cpu", "main.rs", "report"].map(|name| root().join("src").join(name));
    let mut found = Vec::new();
    let mut read = 0;
    for path in sources(&root().join("src")).into_iter().chain(sources(&root().join("python/src")))
    {
        if of_the_command.iter().any(|own| path.starts_with(own)) {
            continue;
        }
        read += 1;
        let text = fs::read_to_string(&path).expect("a source");
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        for (i, line) in code.lines().enumerate() {
            let comment = line.trim_start().starts_with("//");
            if !comment
                && names_an_option(line)
                && !OPTIONS_OF_OTHERS.iter().any(|o| line.contains(o))
            {
                found.push(format!("{}:{}: {}", path.display(), i + 1, line.trim()));
            }
        }
    }
    assert!(read > 400, "{read} sources");
    assert!(found.is_empty(), "name settings as 'focus' instead:\n{}", found.join("\n"));
}

#[test]
fn an_option_is_two_dashes_and_a_letter() {
    assert!(names_an_option("expected --focus") && names_an_option("\"--f\""));
    assert!(!names_an_option("a ---b") && !names_an_option("x - -y") && !names_an_option("i--"));
}

/// Returns whether a line holds two dashes and a letter, but no longer row of dashes.
fn names_an_option(line: &str) -> bool {
    let bytes = line.as_bytes();
    (0..bytes.len()).any(|i| {
        bytes[i..].starts_with(b"--")
            && bytes.get(i + 2).is_some_and(u8::is_ascii_lowercase)
            && (i == 0 || bytes[i - 1] != b'-')
    })
}

/// Returns the sources of a folder without its tests.
fn sources(folder: &Path) -> Vec<PathBuf> {
    let entries =
        fs::read_dir(folder).expect("a folder").map(|entry| entry.expect("an entry").path());
    let mut files = Vec::new();
    for path in entries {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() && name != "tests" {
            files.extend(sources(&path));
        } else if name.ends_with(".rs") && name != "tests.rs" {
            files.push(path);
        }
    }
    files
}
